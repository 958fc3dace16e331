//! Joints of a compiled robot, by name.

use robot_dynamics_description::{JointKind, Limits, Mimic, PassiveForces};

/// A joint of the model, with its indices in q and v.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Joint {
    /// The joint's name.
    pub name: String,
    /// Its kind, with its axes in the joint's frame.
    pub kind: JointKind,
    /// The parent link; `world` for a floating base.
    pub parent: String,
    /// The child link.
    pub child: String,
    /// First entry in q.
    pub q_index: usize,
    /// Entries in q; 0 for fixed and mimic joints.
    pub nq: usize,
    /// First entry in v.
    pub v_index: usize,
    /// Entries in v; 0 for fixed and mimic joints.
    pub nv: usize,
    /// The leader of a mimic joint, with ratio and offset.
    pub mimic: Option<Mimic>,
    /// Limits, per degree of freedom.
    pub limits: Limits,
    /// Armature, damping, friction and stiffness, per degree of freedom.
    pub passive: PassiveForces,
}

impl Joint {
    /// The names of its coordinates.
    pub fn coordinate_names(&self) -> Vec<String> {
        self.kind.velocities().iter().map(|coordinate| coordinate.of_joint(&self.name)).collect()
    }
}

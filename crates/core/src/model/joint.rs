//! Joints of a compiled robot, by name.

use core::ops::Range;

use robot_dynamics_description::{JointKind, Limits, Mimic, PassiveForces};

/// A joint of the model, with its indices in q and v.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Joint {
    /// The joint's name.
    pub name: String,
    /// Its kind, with its axes in the joint's frame.
    pub kind: JointKind,
    /// Its index in [`Model::joints`](crate::Model::joints).
    pub index: usize,
    /// The parent link; `world` for a floating base.
    pub parent_link: String,
    /// The child link.
    pub child_link: String,
    /// The joint of which the parent link is the child, as an index in
    /// [`Model::joints`](crate::Model::joints); `None` at the root.
    pub parent_joint: Option<usize>,
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
    /// Its entries in q.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!([0.3][model.joints()[0].q()], [0.3]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn q(&self) -> Range<usize> {
        self.q_index..self.q_index + self.nq
    }

    /// Its entries in v.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut thrown = pendulum(2.0, 0.5);
    /// thrown.base = Base::Floating;
    /// let model = Model::new(thrown)?;
    /// assert_eq!((model.joints()[0].v(), model.joints()[1].v()), (0..6, 6..7));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn v(&self) -> Range<usize> {
        self.v_index..self.v_index + self.nv
    }

    /// The names of its coordinates.
    pub fn coordinate_names(&self) -> Vec<String> {
        self.kind.velocities().iter().map(|coordinate| coordinate.of_joint(&self.name)).collect()
    }
}

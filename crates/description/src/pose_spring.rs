//! Springs of spherical and floating joints.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A spring of a spherical or floating joint that pulls the child back to its rest pose. Its energy is
/// V = ½ k |φ|² with the rotation φ = log(R_restᵀ R), and for a floating joint also ½ k |p − p_rest|². Its
/// moment is −k φ along the body's axes, and its force −k (p − p_rest) along the axes of the joint's frame in
/// the parent.
///
/// The joint's [`PolynomialStiffnessDamping`](crate::PolynomialStiffnessDamping) add to it, with the lengths |φ| and |p − p_rest|.
/// `Actuation` applies it; it is not part of g. The force is discontinuous at |φ| = π, where two rotation
/// vectors give the same rotation.
///
/// ```
/// use robot_dynamics::description::{Base, JointKind, PoseSpring, Pose, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Actuation;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].kind = JointKind::Spherical;
/// robot.joints[0].spring = Some(PoseSpring { stiffness: 40.0, rest: Pose::IDENTITY });
/// let model = Model::new(robot)?;
/// let actuation = Actuation::new(&model)?;
/// let (mut memory, mut tau) = (actuation.workspace(), [0.0; 3]);
/// let q = robot_dynamics::description::Quaternion::exp([0.1, 0.0, -0.2]).to_xyzw();
/// actuation.passive_forces(&model, &mut memory, &q, &[0.0; 3], &mut tau);
/// assert!(tau.iter().zip([-4.0, 0.0, 8.0]).all(|(tau, expected)| (tau - expected).abs() < 1e-14));
/// assert!((actuation.stored_energy(&mut memory, &q) - 0.5 * 40.0 * 0.05).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[doc(alias = "PlacementSpring")]
pub struct PoseSpring {
    /// k \[N·m/rad, and N/m\].
    pub stiffness: f64,
    /// Its relaxed pose: the child's frame in the joint's. For a spherical joint only the rotation counts.
    pub rest: Pose,
}

/// Prints the name `PlacementSpring` of version 0.1: the text enters the fingerprint of a robot.
impl core::fmt::Debug for PoseSpring {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { stiffness, rest } = self;
        f.debug_struct("PlacementSpring").field("stiffness", stiffness).field("rest", rest).finish()
    }
}

//! The spring of a joint that turns, or moves, freely.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A spring of a spherical or floating joint, which pulls the child back to where it rests: V = ½ k |φ|², φ = log(R_restᵀ R) the turn
/// from there, and of a floating joint ½ k |p − p_rest|² beside it. Its forces are −k φ along the body's axes and −k (p − p_rest)
/// along those that the joint hangs in.
///
/// The joint's [`HigherTerms`](crate::HigherTerms) add to it by the lengths |φ| and |p − p_rest|. It acts by
/// [`Actuation`](crate::Actuation), and is no part of g. Where |φ| = π the turn has two directions and the force jumps.
///
/// ```
/// use multibody::{Actuation, Base, JointKind, Model, PlacementSpring, Pose, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].kind = JointKind::Spherical;
/// robot.joints[0].spring = Some(PlacementSpring { stiffness: 40.0, rest: Pose::IDENTITY });
/// let model = Model::new(robot)?;
/// let actuation = Actuation::new(&model)?;
/// let (mut memory, mut tau) = (actuation.workspace(), [0.0; 3]);
/// let q = multibody::Quaternion::exp([0.1, 0.0, -0.2]).to_xyzw();
/// actuation.passive_forces(&model, &mut memory, &q, &[0.0; 3], &mut tau);
/// assert!(tau.iter().zip([-4.0, 0.0, 8.0]).all(|(tau, expected)| (tau - expected).abs() < 1e-14));
/// assert!((actuation.stored_energy(&mut memory, &q) - 0.5 * 40.0 * 0.05).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct PlacementSpring {
    /// k \[N·m/rad, and N/m\].
    pub stiffness: f64,
    /// Where it is relaxed: the child's frame in the joint's; of a spherical joint its rotation counts.
    pub rest: Pose,
}

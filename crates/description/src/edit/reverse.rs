//! Reverses a joint: its child becomes the parent, with the same relative motion.
//!
//! With X = `parent_from_joint` and the joint's motion M(q), `parent_from_child` is X M(q), so
//! `child_from_parent` is M(q)⁻¹ X⁻¹. M⁻¹ is a motion M′(q′) of the same kind:
//!
//! | kind | M′ | q′ |
//! | --- | --- | --- |
//! | revolute, continuous, prismatic, helical | the opposite axis, the same pitch | q |
//! | universal | the opposite axes in the opposite order | (q₂, q₁) |
//! | planar | the same normal | (−Rᵀ(θ) (x, y), −θ) |
//! | spherical | | the conjugate quaternion; v′ = −R v |
//!
//! M′(q′) X⁻¹ is a joint before a fixed placement X⁻¹ of the old parent. The placement can move before the
//! joint if the joint is prismatic, or if X is a rotation and the joint turns about fixed axes. In the other
//! cases a link without mass carries the old parent by a fixed joint.

use super::motion::moved_by;
use crate::{JointDescription, JointKind, ModelError, Pose, PoseSpring, Quaternion};

/// A reversed joint.
pub(super) struct Reversed {
    pub(super) kind: JointKind,
    /// Its frame in the old child.
    pub(super) parent_from_joint: Pose,
    /// The old parent in the frame that the joint moves, if they differ.
    pub(super) carried: Option<Pose>,
    pub(super) spring: Option<PoseSpring>,
}

/// The reversed joint.
pub(super) fn reversed(joint: &JointDescription) -> Result<Reversed, ModelError> {
    let x = joint.parent_from_joint;
    let opposite = |axis: [f64; 3]| axis.map(|component| -component);
    let kind = match joint.kind {
        JointKind::Revolute { axis } => JointKind::Revolute { axis: opposite(axis) },
        JointKind::Continuous { axis } => JointKind::Continuous { axis: opposite(axis) },
        JointKind::Prismatic { axis } => JointKind::Prismatic { axis: opposite(axis) },
        JointKind::Helical { axis, pitch } => JointKind::Helical { axis: opposite(axis), pitch },
        JointKind::Universal { first, second } => {
            JointKind::Universal { first: opposite(second), second: opposite(first) }
        }
        kind => kind,
    };
    let refuse = |reason| Err(ModelError::Irreversible { joint: joint.name.clone(), reason });
    let passive = &joint.passive;
    match kind {
        JointKind::Planar { .. } => {
            let limits = &joint.limits;
            let bounds = [limits.upper, -limits.lower, limits.velocity, limits.effort];
            if *passive != crate::PassiveForces::default() || bounds.iter().any(|bound| bound.is_finite()) {
                return refuse("a planar joint with limits or passive forces has no equal reversed joint");
            }
        }
        JointKind::Spherical if passive.friction != 0.0 || !joint.higher_terms.is_zero() => {
            return refuse("friction about the axes of a spherical joint's child has no reversed form");
        }
        _ => {}
    }
    let turns = |kind: &JointKind| {
        let by = |axis: [f64; 3]| x.rotate(axis);
        match *kind {
            JointKind::Revolute { axis } => Some(JointKind::Revolute { axis: by(axis) }),
            JointKind::Continuous { axis } => Some(JointKind::Continuous { axis: by(axis) }),
            JointKind::Helical { axis, pitch } => Some(JointKind::Helical { axis: by(axis), pitch }),
            JointKind::Universal { first, second } => {
                Some(JointKind::Universal { first: by(first), second: by(second) })
            }
            _ => None,
        }
    };
    let direct = match kind {
        JointKind::Fixed => Some(JointKind::Fixed),
        JointKind::Prismatic { axis } => Some(JointKind::Prismatic { axis: x.rotate(axis) }),
        _ if x == Pose::IDENTITY => Some(kind),
        _ if x.translation == [0.0; 3] => turns(&kind),
        _ => None,
    };
    let spring = joint.spring.map(|spring| PoseSpring { rest: spring.rest.inverse(), ..spring });
    Ok(match direct {
        Some(kind) => Reversed { kind, parent_from_joint: x.inverse(), carried: None, spring },
        None => Reversed { kind, parent_from_joint: Pose::IDENTITY, carried: Some(x.inverse()), spring },
    })
}

/// The position and the velocity of the reversed joint.
pub(super) fn reversed_state(kind: &JointKind, q: &[f64], v: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    Some(match kind {
        JointKind::Universal { .. } => (vec![q[1], q[0]], vec![v[1], v[0]]),
        JointKind::Planar { .. } => {
            let (sin, cos) = q[2].sin_cos();
            let turned = |x: f64, y: f64| [-(cos * x + sin * y), sin * x - cos * y];
            let [x, y] = turned(q[0], q[1]);
            // The rate of −Rᵀ(θ) p is −Rᵀ(θ) ṗ + θ̇ (−Rᵀ)′ p.
            let [vx, vy] = turned(v[0], v[1]);
            (vec![x, y, -q[2]], vec![vx + v[2] * y, vy - v[2] * x, -v[2]])
        }
        JointKind::Spherical => {
            let turn = moved_by(kind, q)?;
            let back = Quaternion::from_rotation(&turn.inverse().rotation).to_xyzw();
            (back.to_vec(), turn.rotate([v[0], v[1], v[2]]).map(|x| -x).to_vec())
        }
        _ => (q.to_vec(), v.to_vec()),
    })
}

//! Checks of a joint's numbers.

use super::checks::{check, check_pose, check_range, check_terms};
use crate::{JointDescription, JointKind, ModelError};

pub(crate) fn check_joint(joint: &JointDescription) -> Result<(), ModelError> {
    let owner = format!("joint `{}`", joint.name);
    check_pose(&owner, &joint.parent_from_joint)?;
    let axes: &[[f64; 3]] = match &joint.kind {
        JointKind::Revolute { axis }
        | JointKind::Continuous { axis }
        | JointKind::Prismatic { axis }
        | JointKind::Helical { axis, .. }
        | JointKind::Planar { normal: axis } => &[*axis],
        JointKind::Universal { first, second } => &[*first, *second],
        JointKind::Fixed | JointKind::Spherical | JointKind::Floating => &[],
    };
    for axis in axes {
        let norm = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < 1e-9 || !norm.is_finite() {
            return Err(ModelError::ZeroAxis { joint: joint.name.clone(), axis: *axis });
        }
    }
    if let JointKind::Helical { pitch, .. } = joint.kind {
        check(pitch.is_finite(), &owner, "pitch", pitch, "finite")?;
    }
    let passive = &joint.passive;
    for (value, quantity) in [
        (passive.armature, "armature"),
        (passive.damping, "damping"),
        (passive.friction, "friction"),
        (passive.stiffness, "stiffness"),
    ] {
        check(value.is_finite(), &owner, quantity, value, "finite")?;
    }
    check(passive.rest.is_finite(), &owner, "rest position", passive.rest, "finite")?;
    if matches!(joint.kind, JointKind::Spherical | JointKind::Floating) {
        check(
            passive.stiffness == 0.0,
            &owner,
            "stiffness",
            passive.stiffness,
            "zero, as a quaternion joint needs; give it a placement's spring",
        )?;
    }
    let limits = &joint.limits;
    check(!limits.lower.is_nan(), &owner, "lower limit", limits.lower, "a number")?;
    check(!limits.upper.is_nan(), &owner, "upper limit", limits.upper, "a number")?;
    check(limits.velocity >= 0.0, &owner, "velocity limit", limits.velocity, "zero or positive")?;
    check(limits.effort >= 0.0, &owner, "effort limit", limits.effort, "zero or positive")?;
    check(limits.turn >= 0.0, &owner, "largest turn", limits.turn, "zero or positive")
}

/// Checks the forces on a joint beyond its linear spring and its damping.
pub(super) fn check_joint_forces(joint: &JointDescription) -> Result<(), ModelError> {
    let owner = format!("joint `{}`", joint.name);
    check_range(&owner, "actuator force range", joint.actuator_force_range)?;
    check_terms(&owner, &joint.higher_terms)?;
    let (yields, kind) = (joint.spring_yield, joint.kind);
    let is_single = kind.nv() == 1 || kind == JointKind::Fixed;
    let allowed = if is_single {
        "finite and not negative"
    } else {
        "zero, as the joint has several degrees of freedom"
    };
    let is_valid = yields >= 0.0 && yields.is_finite() && (is_single || yields == 0.0);
    check(is_valid, &owner, "yield stretch of its spring", yields, allowed)?;
    let turns_freely = matches!(joint.kind, JointKind::Spherical | JointKind::Floating | JointKind::Fixed);
    if !joint.higher_terms.is_zero() && joint.kind.nv() != 1 && !turns_freely {
        let [k2, _] = joint.higher_terms.stiffness;
        check(
            false,
            &owner,
            "higher terms",
            k2,
            "of a joint of one degree of freedom, a spherical or a floating one",
        )?;
    }
    if let Some(spring) = &joint.spring {
        check(spring.stiffness.is_finite(), &owner, "stiffness", spring.stiffness, "finite")?;
        check_pose(&owner, &spring.rest)?;
        check(
            turns_freely,
            &owner,
            "stiffness of a placement's spring",
            spring.stiffness,
            "of a spherical or floating joint",
        )?;
    }
    Ok(())
}

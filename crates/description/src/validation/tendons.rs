//! Checks of the tendons of a description.

use std::collections::HashSet;

use super::checks::{check, check_pose, check_range, check_terms, index_names};
use super::names::Names;
use crate::{
    ModelError, PassiveForces, PolynomialStiffnessDamping, RobotDescription, SpatialTendonDescription,
    TendonPathElement,
};

pub(super) fn check_tendons(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("tendon", description.tendon_names())?;
    for tendon in &description.tendons {
        let owner = format!("tendon `{}`", tendon.name);
        for (joint, coefficient) in &tendon.terms {
            names.single_joint(&owner, joint)?;
            check(coefficient.is_finite(), &owner, "coefficient", *coefficient, "finite")?;
        }
        check(
            tendon.offset.is_finite(),
            &owner,
            "length where its joints are at 0",
            tendon.offset,
            "finite",
        )?;
        check_law(&owner, &tendon.passive, &tendon.higher_terms, (tendon.dead_band, tendon.spring_yield))?;
    }
    let frames: HashSet<&str> = description.frames.iter().map(|frame| frame.name.as_str()).collect();
    for tendon in &description.spatial_tendons {
        check_spatial(&frames, names, tendon)?;
    }
    Ok(())
}

fn check_spatial(
    frames: &HashSet<&str>,
    names: &Names<'_>,
    tendon: &SpatialTendonDescription,
) -> Result<(), ModelError> {
    let owner = format!("tendon `{}`", tendon.name);
    let frame = |name: &str| if frames.contains(name) { Ok(()) } else { names.link(&owner, name) };
    SpatialTendonDescription::check_path(&tendon.path)
        .map_err(|problem| ModelError::TendonPath { tendon: tendon.name.clone(), problem })?;
    for element in &tendon.path {
        match element {
            TendonPathElement::Point { frame: name } => frame(name)?,
            TendonPathElement::Surface { link, link_from_surface, radius, side, surface: _ } => {
                names.link(&owner, link)?;
                side.as_deref().map_or(Ok(()), frame)?;
                check_pose(&owner, link_from_surface)?;
                check(radius.is_finite() && *radius > 0.0, &owner, "radius", *radius, "positive and finite")?;
            }
            TendonPathElement::Pulley { divisor } => {
                check(
                    divisor.is_finite() && *divisor > 0.0,
                    &owner,
                    "divisor",
                    *divisor,
                    "positive and finite",
                )?;
            }
        }
    }
    let armature = tendon.passive.armature;
    check(armature == 0.0, &owner, "armature", armature, "zero for a spatial tendon")?;
    check_law(&owner, &tendon.passive, &tendon.higher_terms, (tendon.dead_band, tendon.spring_yield))?;
    check_range(&owner, "range of its actuators' force", tendon.actuator_force_range)
}

/// Checks the spring, the damper, friction and armature of a tendon.
fn check_law(
    owner: &str,
    passive: &PassiveForces,
    higher_terms: &PolynomialStiffnessDamping,
    (dead_band, spring_yield): (f64, f64),
) -> Result<(), ModelError> {
    for (value, quantity) in [
        (passive.armature, "armature"),
        (passive.damping, "damping"),
        (passive.friction, "friction"),
        (passive.stiffness, "stiffness"),
        (passive.rest, "rest length"),
    ] {
        check(value.is_finite(), owner, quantity, value, "finite")?;
    }
    check_terms(owner, higher_terms)?;
    check(dead_band >= 0.0, owner, "dead band", dead_band, "zero or positive")?;
    let is_valid = spring_yield >= 0.0 && spring_yield.is_finite();
    check(is_valid, owner, "yield stretch of its spring", spring_yield, "finite and not negative")
}

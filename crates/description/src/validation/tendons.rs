//! Checks of the tendons of a description.

use super::checks::{check, check_terms, index_names};
use super::names::Names;
use crate::{ModelError, RobotDescription};

pub(super) fn check_tendons(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("tendon", description.tendons.iter().map(|tendon| tendon.name.as_str()))?;
    for tendon in &description.tendons {
        let owner = format!("tendon `{}`", tendon.name);
        for (joint, coefficient) in &tendon.terms {
            names.single_joint(&owner, joint)?;
            check(coefficient.is_finite(), &owner, "coefficient", *coefficient, "finite")?;
        }
        let passive = &tendon.passive;
        for (value, quantity) in [
            (tendon.offset, "length where its joints are at 0"),
            (passive.armature, "armature"),
            (passive.damping, "damping"),
            (passive.friction, "friction"),
            (passive.stiffness, "stiffness"),
            (passive.rest, "rest length"),
        ] {
            check(value.is_finite(), &owner, quantity, value, "finite")?;
        }
        check_terms(&owner, &tendon.higher_terms)?;
        check(tendon.dead_band >= 0.0, &owner, "dead band", tendon.dead_band, "zero or positive")?;
    }
    Ok(())
}

//! Checks of the equalities of a description.

use std::collections::HashSet;

use super::checks::{check, check_pose, index_names, unknown};
use super::names::Names;
use crate::{Equality, ModelError, RobotDescription};

pub(super) fn check_equalities(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("equality", description.equalities.iter().map(|equality| equality.name.as_str()))?;
    let RobotDescription { tendons, spatial_tendons, .. } = description;
    let tendons = tendons.iter().map(|own| own.name.as_str());
    let tendons: HashSet<&str> = tendons.chain(spatial_tendons.iter().map(|own| own.name.as_str())).collect();
    for equality in &description.equalities {
        let owner = format!("equality `{}`", equality.name);
        let finite = |quantity: &'static str, numbers: &[f64]| {
            let bad = numbers.iter().find(|x| !x.is_finite());
            bad.map_or(Ok(()), |&x| check(false, &owner, quantity, x, "finite"))
        };
        match &equality.kind {
            Equality::Joints { joint, leader, polynomial } => {
                for (name, reference) in core::iter::once(joint).chain(leader) {
                    names.single_joint(&owner, name)?;
                    finite("reference position", &[*reference])?;
                }
                finite("coefficient", polynomial)?;
            }
            Equality::Tendons { tendon, leader, polynomial } => {
                for (name, reference) in core::iter::once(tendon).chain(leader) {
                    if !tendons.contains(name.as_str()) {
                        return Err(unknown(&owner, "tendon", name));
                    }
                    finite("reference length", &[*reference])?;
                }
                finite("coefficient", polynomial)?;
            }
            Equality::Connect { a, b } => {
                for (link, point) in [a, b] {
                    names.link(&owner, link)?;
                    finite("point", point)?;
                }
            }
            Equality::Weld { a, b, a_from_b, anchor, torque_scale } => {
                names.link(&owner, a)?;
                names.link(&owner, b)?;
                check_pose(&owner, a_from_b)?;
                finite("anchor", anchor)?;
                let is_scale = torque_scale.is_finite() && *torque_scale > 0.0;
                check(is_scale, &owner, "torque scale", *torque_scale, "finite and positive")?;
            }
        }
    }
    Ok(())
}

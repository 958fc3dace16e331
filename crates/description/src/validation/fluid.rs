//! Checks of the fluid and of the shapes on which it acts.

use std::collections::HashMap;

use super::checks::{check, check_pose, unknown};
use crate::{FluidForm, ModelError, RobotDescription};

pub(super) fn check_fluid(
    description: &RobotDescription,
    links: &HashMap<&str, usize>,
) -> Result<(), ModelError> {
    let medium = &description.medium;
    for (value, quantity) in [(medium.density, "density"), (medium.viscosity, "viscosity")] {
        check(value >= 0.0 && value.is_finite(), "the fluid", quantity, value, "zero or positive")?;
    }
    for value in medium.wind {
        check(value.is_finite(), "the fluid", "wind", value, "finite")?;
    }
    for shape in &description.fluid_shapes {
        let owner = format!("a fluid shape of link `{}`", shape.link);
        if !links.contains_key(shape.link.as_str()) {
            return Err(unknown("a fluid shape", "link", &shape.link));
        }
        check_pose(&owner, &shape.link_from_shape)?;
        let (lengths, others) = match &shape.form {
            FluidForm::InertiaBox { size } => (size, Vec::new()),
            FluidForm::Ellipsoid(own) => {
                let numbers = own.coefficients().into_iter().chain(own.added_mass).chain(own.added_inertia);
                (&own.half_axes, numbers.collect())
            }
        };
        for &length in lengths {
            check(length > 0.0 && length.is_finite(), &owner, "length", length, "positive")?;
        }
        for value in others {
            check(value.is_finite(), &owner, "coefficient", value, "finite")?;
        }
    }
    Ok(())
}

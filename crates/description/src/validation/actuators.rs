//! Checks of the actuators of a description.

use super::checks::{check, check_range, index_names, unknown};
use super::names::Names;
use crate::{Activation, ModelError, RobotDescription, Transmission};

pub(super) fn check_actuators(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("actuator", description.actuators.iter().map(|actuator| actuator.name.as_str()))?;
    for actuator in &description.actuators {
        let owner = format!("actuator `{}`", actuator.name);
        let gear: &[f64] = match &actuator.transmission {
            Transmission::Joint { joint, gear } => {
                names.joints.get(joint.as_str()).ok_or_else(|| unknown(&owner, "joint", joint))?;
                gear
            }
            Transmission::Tendon { tendon, gear } => {
                let found = description.tendons.iter().any(|own| own.name == *tendon);
                if !found {
                    return Err(unknown(&owner, "tendon", tendon));
                }
                core::slice::from_ref(gear)
            }
            Transmission::Frame { frame, gear } => {
                let is_frame = description.frames.iter().any(|own| own.name == *frame);
                if !is_frame {
                    names.link(&owner, frame)?;
                }
                gear
            }
        };
        let laws = [actuator.gain, actuator.bias];
        let numbers = laws.iter().flat_map(|law| [law.constant, law.length, law.velocity]);
        for number in gear.iter().copied().chain(numbers) {
            check(number.is_finite(), &owner, "gear, gain or bias", number, "finite")?;
        }
        if let Activation::Filter { time_constant } = actuator.activation {
            check(time_constant > 0.0, &owner, "time constant", time_constant, "positive")?;
        }
        check_range(&owner, "control range", actuator.control_range)?;
        check_range(&owner, "force range", actuator.force_range)?;
    }
    Ok(())
}

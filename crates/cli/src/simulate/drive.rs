//! The controls of the actuators of the robot's file.

use multibody::Model;
use multibody::simulator::Effect;

use super::Arguments;
use super::setup::Setup;
use super::start::Start;
use crate::failure::Failure;
use crate::joint_values::JointValues;

/// The controls of a run.
pub(crate) struct Drive {
    pub controls: Vec<f64>,
    /// In words, for the summary.
    pub described: String,
}

/// The controls given, those of the named pose, or 0; `None` where no actuators act.
///
/// # Errors
/// Controls are given, and no actuators act, or not one of that name.
pub(crate) fn choose(
    arguments: &Arguments,
    model: &Model,
    setup: &Setup,
    start: &Start,
) -> Result<Option<Drive>, Failure> {
    let simulation = &setup.simulation;
    if !setup.acts(Effect::Actuators) {
        return match arguments.controls {
            None => Ok(None),
            Some(_) if model.description().actuators.is_empty() => Err(Failure::new(format!(
                "--controls: the file of robot `{}` has no actuators; --hold holds a pose by motors of its own",
                model.name()
            ))),
            Some(_) => Err(Failure::new(format!(
                "--controls: actuators do not act here; leave out --conservative, --without actuators, or --integrator {}",
                setup.method()
            ))),
        };
    }
    let names: Vec<&str> = simulation.control_names().collect();
    let mut controls = start.controls.clone();
    controls.resize(names.len(), 0.0);
    if let Some(given) = arguments.controls.as_ref().filter(|given| !given.is_empty()) {
        let refused = |error: String| Failure::new(format!("--controls: {error}"));
        let given: JointValues = given.parse().map_err(refused)?;
        for (name, value) in given.single().map_err(refused)? {
            let index = names.iter().position(|own| *own == name).ok_or_else(|| {
                Failure::new(format!(
                    "--controls: there is no actuator `{name}`; there are {}",
                    names.join(", ")
                ))
            })?;
            controls[index] = value;
        }
    }
    let shown = names.iter().zip(&controls).filter(|(_, control)| **control != 0.0);
    let shown: Vec<String> = shown.map(|(name, control)| format!("{name}={control}")).collect();
    let at = if shown.is_empty() { "controls at 0".into() } else { shown.join(", ") };
    let described = format!("{} of the file, {at}", crate::inspect::count(names.len(), "actuator"));
    Ok(Some(Drive { controls, described }))
}

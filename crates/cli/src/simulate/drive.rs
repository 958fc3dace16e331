//! Controls of the actuators in the robot's file.

use robot_dynamics::model::Model;
use robot_dynamics::simulation::Effect;

use super::arguments::Arguments;
use super::setup::Setup;
use super::start::Start;
use crate::failure::Failure;
use crate::joint_values::JointValues;

/// The controls of a run.
pub(crate) struct ActuatorControls {
    pub controls: Vec<f64>,
    /// Text for the summary.
    pub described: String,
}

/// The given controls, those of the named pose, or 0; `None` if no actuators act.
///
/// # Errors
///
/// Controls are given and no actuators act, or an actuator's name is unknown.
pub(crate) fn choose(
    arguments: &Arguments,
    model: &Model,
    setup: &Setup,
    start: &Start,
) -> Result<Option<ActuatorControls>, Failure> {
    let simulation = &setup.simulation;
    if !setup.acts(Effect::Actuators) {
        return match arguments.controls {
            None => Ok(None),
            Some(_) if model.description().actuators.is_empty() => Err(Failure::new(format!(
                "--controls: robot `{}` has no actuators in its file; --hold adds motors that hold a pose",
                model.name()
            ))),
            Some(_) => Err(Failure::new(format!(
                "--controls: actuators are switched off; omit --conservative, --without actuators, or --integrator {}",
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
                Failure::new(format!("--controls: unknown actuator `{name}`; known: {}", names.join(", ")))
            })?;
            controls[index] = value;
        }
    }
    let shown = names.iter().zip(&controls).filter(|(_, control)| **control != 0.0);
    let shown: Vec<String> = shown.map(|(name, control)| format!("{name}={control}")).collect();
    let at = if shown.is_empty() { "all controls 0".into() } else { shown.join(", ") };
    let described = format!("{}, {at}", crate::table::count(names.len(), "actuator"));
    Ok(Some(ActuatorControls { controls, described }))
}

//! What the robot's file has beside its tree: actuators, tendons, springs of ball and free joints, carried weight.

use multibody::{Actuation, Model};

use super::Arguments;
use super::start::Start;
use crate::failure::{Context, Failure};
use crate::joint_values::JointValues;
use crate::output::tell;

/// Actuators and tendons of a run, and the controls.
pub(crate) struct Drive {
    pub actuation: Actuation,
    pub controls: Vec<f64>,
    /// In words, for the summary.
    pub described: String,
}

/// What drives the run; `None` where nothing does but the joints themselves.
pub(crate) fn choose(arguments: &Arguments, model: &Model, start: &Start) -> Result<Option<Drive>, Failure> {
    let actuation = Actuation::new(model).context(arguments.robot.shown())?;
    let has_drive = arguments.has_contact();
    let Some(given) = &arguments.controls else {
        if actuation.is_empty() {
            return Ok(None);
        }
        if !has_drive {
            let shown = arguments.robot.shown();
            tell(format_args!(
                "note: {shown}: its actuators, tendons, springs of ball and free joints and carried weight do not act; \
                 --damping lets the passive ones, --controls all of them"
            ));
            return Ok(None);
        }
        let passive = actuation.without_actuators();
        if passive.is_empty() {
            return Ok(None);
        }
        let described = "tendons, springs of ball and free joints and carried weight act".into();
        return Ok(Some(Drive { actuation: passive, controls: Vec::new(), described }));
    };
    if !has_drive {
        return Err(Failure::new(format!(
            "--controls goes with --integrator implicit or mujoco, as actuators follow the state within a step; {} holds its forces",
            arguments.method()
        )));
    }
    let names: Vec<&str> = actuation.control_names().collect();
    if names.is_empty() {
        return Err(Failure::new(format!(
            "--controls: the file of robot `{}` has no actuators; --hold holds a pose by motors of its own",
            model.name()
        )));
    }
    let mut controls = start.controls.clone();
    controls.resize(names.len(), 0.0);
    if !given.is_empty() {
        let given: JointValues =
            given.parse().map_err(|error| Failure::new(format!("--controls: {error}")))?;
        for (name, value) in given.single().map_err(|error| Failure::new(format!("--controls: {error}")))? {
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
    Ok(Some(Drive { actuation, controls, described }))
}

//! Options of `--integrator`.

use robot_dynamics::simulation::Method;

use super::arguments::Arguments;
use crate::failure::Failure;

/// Rejects options that do not apply to the method.
pub(crate) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let adaptive = Method::Adaptive;
    let is_adaptive = arguments.integrator == Some(adaptive);
    if !is_adaptive && arguments.tolerance.is_some() {
        let given = arguments.integrator.map_or_else(|| "the default".into(), |method| method.to_string());
        return Err(Failure::new(format!(
            "--tolerance needs --integrator {adaptive}; {given} takes fixed steps of --dt"
        )));
    }
    if is_adaptive && arguments.ground.is_some() {
        return Err(Failure::new(format!(
            "--ground needs --integrator implicit or mujoco; {adaptive} does not support contact"
        )));
    }
    Ok(())
}

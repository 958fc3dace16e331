//! Options of `--integrator`.

use robot_dynamics::simulation::Method;

use super::Arguments;
use crate::failure::Failure;

/// The default tolerance.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// Parses a tolerance in the range that adaptive steps support.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1e-13..=1e-2).contains(&x) => Ok(x),
        Ok(_) => Err("the tolerance must be between 1e-13 and 1e-2".into()),
        Err(_) => Err("not a number".into()),
    }
}

/// Rejects options that do not apply to the method.
pub(crate) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let adaptive = Method::Adaptive;
    let is_adaptive = arguments.integrator == Some(adaptive);
    if !is_adaptive && arguments.tolerance.is_some() {
        let given = arguments.integrator.map_or_else(|| "the default".into(), |method| method.to_string());
        return Err(Failure::new(format!(
            "--tolerance needs --integrator {adaptive}; {given} takes fixed steps of --step"
        )));
    }
    if is_adaptive && arguments.ground.is_some() {
        return Err(Failure::new(format!(
            "--ground needs --integrator implicit or mujoco; {adaptive} does not support contact"
        )));
    }
    Ok(())
}

//! Options of `--integrator`.

use multibody::simulator::Method;

use super::Arguments;
use crate::failure::Failure;

/// The tolerance where none is given.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// A tolerance that adaptive steps can meet.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1e-13..=1e-2).contains(&x) => Ok(x),
        Ok(_) => Err("it must lie between 1e-13 and 1e-2".into()),
        Err(_) => Err("it is not a number".into()),
    }
}

/// Refuses options of one method beside another.
pub(crate) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let adaptive = Method::Adaptive;
    let is_adaptive = arguments.integrator == Some(adaptive);
    if !is_adaptive && arguments.tolerance.is_some() {
        let given = arguments.integrator.map_or_else(|| "the default".into(), |method| method.to_string());
        return Err(Failure::new(format!(
            "--tolerance goes with --integrator {adaptive}; {given} takes steps of --step whatever their error"
        )));
    }
    if is_adaptive && arguments.ground.is_some() {
        return Err(Failure::new(format!(
            "--ground goes with --integrator implicit or mujoco; {adaptive} knows no contact"
        )));
    }
    Ok(())
}

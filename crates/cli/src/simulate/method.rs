//! `--integrator`: a row of the table of fixed steps, or adaptive steps.

use std::fmt;
use std::str::FromStr;

use dynamics::Integrator;

use super::Arguments;
use crate::failure::Failure;

/// How the motion is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Steps of `--step`.
    Fixed(Integrator),
    /// Steps as `--tolerance` allows.
    Adaptive,
}

const ADAPTIVE: &str = "adaptive";

impl FromStr for Method {
    type Err = String;
    fn from_str(name: &str) -> Result<Self, String> {
        if name == ADAPTIVE {
            return Ok(Self::Adaptive);
        }
        Integrator::from_name(name).map(Self::Fixed).map_err(|error| format!("{error} {ADAPTIVE}"))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(row) => row.fmt(f),
            Self::Adaptive => f.pad(ADAPTIVE),
        }
    }
}

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

/// Refuses options of adaptive steps beside fixed ones.
pub(crate) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let Method::Fixed(row) = arguments.integrator else { return Ok(()) };
    if arguments.tolerance.is_none() {
        return Ok(());
    }
    Err(Failure::new(format!(
        "--tolerance goes with --integrator {ADAPTIVE}; {row} takes steps of --step whatever their error"
    )))
}

//! `--integrator`: a row of the table of fixed steps, implicit steps, or adaptive ones.

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
    /// Steps of `--step` with damping, friction and stops implicit.
    Implicit,
    /// MuJoCo's steps of `--step`, under its law.
    Mujoco,
    /// Steps as `--tolerance` allows.
    Adaptive,
}

const ADAPTIVE: &str = "adaptive";
const IMPLICIT: &str = "implicit";
const MUJOCO: &str = "mujoco";

impl Arguments {
    /// The method asked for, or the one that fits.
    pub(crate) fn method(&self) -> Method {
        let fits = if self.has_damping() { Method::Implicit } else { Method::Fixed(Integrator::RungeKutta4) };
        self.integrator.unwrap_or(fits)
    }

    /// Whether the joints' damping and friction act.
    pub(crate) fn has_damping(&self) -> bool {
        let by_law = self.integrator == Some(Method::Mujoco);
        self.damping || self.controls.is_some() || self.ground.is_some() || by_law
    }

    /// Whether nothing takes energy out but the motors.
    pub(crate) fn conserves(&self) -> bool {
        !self.has_damping() && !self.has_stops()
    }

    /// Whether joints stop at their position limits.
    pub(crate) fn has_stops(&self) -> bool {
        match self.method() {
            Method::Implicit => !self.no_stops,
            method => method == Method::Mujoco,
        }
    }

    /// Whether the method knows the ground and what the file's actuators do.
    pub(crate) fn has_contact(&self) -> bool {
        matches!(self.method(), Method::Implicit | Method::Mujoco)
    }
}

impl FromStr for Method {
    type Err = String;
    fn from_str(name: &str) -> Result<Self, String> {
        if name == ADAPTIVE {
            return Ok(Self::Adaptive);
        }
        if name == IMPLICIT {
            return Ok(Self::Implicit);
        }
        if name == MUJOCO {
            return Ok(Self::Mujoco);
        }
        Integrator::from_name(name)
            .map(Self::Fixed)
            .map_err(|error| format!("{error} {IMPLICIT} {MUJOCO} {ADAPTIVE}"))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(row) => row.fmt(f),
            Self::Implicit => f.pad(IMPLICIT),
            Self::Mujoco => f.pad(MUJOCO),
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

/// Refuses options of one method beside another.
pub(crate) fn check(arguments: &Arguments) -> Result<(), Failure> {
    let method = arguments.method();
    if arguments.no_stops && method != Method::Implicit {
        return Err(Failure::new(format!(
            "--no-stops goes with --integrator {IMPLICIT}; {method} has no stops to leave out"
        )));
    }
    if arguments.tolerance.is_none() || method == Method::Adaptive {
        return Ok(());
    }
    Err(Failure::new(format!(
        "--tolerance goes with --integrator {ADAPTIVE}; {method} takes steps of --step whatever their error"
    )))
}

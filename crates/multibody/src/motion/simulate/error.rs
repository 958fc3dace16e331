//! Why a run ended early.

use std::error::Error;

use dynamics::IntegratorError;

use super::divergence::DivergenceCause;
use super::event::{Cause, NoValue};
use super::{CallbackError, ControllerError, Run};
use crate::{ConfigurationError, SingularMass};

/// Why a run could not go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError<E = IntegratorError> {
    /// A step that is not positive and finite.
    #[error("the step must be positive and finite, got {step} s")]
    BadStep {
        /// The step given \[s\].
        step: f64,
    },
    /// The state to start from is no configuration.
    #[error("the run cannot start: {0}")]
    Configuration(#[source] ConfigurationError),
    /// A number became NaN or infinite, or was given so.
    #[error(
        "{quantity} is not finite at coordinate `{coordinate}`, t = {time} s (step {step}); \
         check the inputs, or take a smaller step"
    )]
    NotFinite {
        /// Which quantity: `q`, `v`, `the acceleration`, `the energy`, `the controller's torque`, ...
        quantity: &'static str,
        /// The first coordinate it was seen at; for the energy the fastest one.
        coordinate: String,
        /// Steps done when it was seen.
        step: usize,
        /// The time then \[s\].
        time: f64,
    },
    /// The motion grew without bound, as that of a spring or servo does that is too stiff for the step.
    #[error(
        "the motion grows without bound: `{coordinate}` has v = {speed:.1e} at t = {time} s (step {step}); try a step of {suggested_step:.1e} s, \
         {cause}"
    )]
    Diverged {
        /// The fastest coordinate.
        coordinate: String,
        /// Its velocity \[rad/s or m/s\].
        speed: f64,
        /// Steps done when it was seen.
        step: usize,
        /// The time then \[s\].
        time: f64,
        /// A step that should do \[s\]; see the cause.
        suggested_step: f64,
        /// The cause by which that step was chosen.
        cause: DivergenceCause,
    },
    /// Some motion moves no inertia in the configuration reached, so no acceleration follows from the forces.
    #[error("t = {time} s (step {step}): {source}")]
    SingularMass {
        /// Steps done before it.
        step: usize,
        /// The time then \[s\].
        time: f64,
        /// Which joints.
        source: SingularMass,
    },
    /// The controller gave no torque.
    #[error("the controller gave no torque at t = {time} s (step {step}): {source}")]
    Controller {
        /// Steps done before it.
        step: usize,
        /// The time then \[s\].
        time: f64,
        /// Why.
        source: ControllerError,
    },
    /// An event's function is NaN or infinite.
    #[error("the function of event `{name}` is {value} at t = {time} s")]
    EventNotFinite {
        /// The event.
        name: String,
        /// The time \[s\].
        time: f64,
        /// The function's value.
        value: f64,
    },
    /// An event's function failed.
    #[error("the function of event `{name}` failed at t = {time} s: {source}")]
    Event {
        /// The event.
        name: String,
        /// The time \[s\].
        time: f64,
        /// What it says.
        source: CallbackError,
    },
    /// A step could not be taken.
    #[error("t = {time} s (step {step}): {source}")]
    Step {
        /// Steps done before it.
        step: usize,
        /// The time then \[s\].
        time: f64,
        /// Why.
        source: E,
    },
}

impl<E> RunError<E> {
    /// With the error of a step as another one.
    #[cfg_attr(not(feature = "adaptive"), allow(dead_code))]
    pub(crate) fn map<F>(self, of: impl FnOnce(E) -> F) -> RunError<F> {
        match self {
            Self::BadStep { step } => RunError::BadStep { step },
            Self::Configuration(source) => RunError::Configuration(source),
            Self::NotFinite { quantity, coordinate, step, time } => {
                RunError::NotFinite { quantity, coordinate, step, time }
            }
            Self::Diverged { coordinate, speed, step, time, suggested_step, cause } => {
                RunError::Diverged { coordinate, speed, step, time, suggested_step, cause }
            }
            Self::SingularMass { step, time, source } => RunError::SingularMass { step, time, source },
            Self::Controller { step, time, source } => RunError::Controller { step, time, source },
            Self::EventNotFinite { name, time, value } => RunError::EventNotFinite { name, time, value },
            Self::Event { name, time, source } => RunError::Event { name, time, source },
            Self::Step { step, time, source } => RunError::Step { step, time, source: of(source) },
        }
    }
}

impl<E> From<NoValue> for RunError<E> {
    fn from(NoValue { name, time, cause }: NoValue) -> Self {
        match cause {
            Cause::NotFinite(value) => Self::EventNotFinite { name, time, value },
            Cause::Failed(source) => Self::Event { name, time, source },
        }
    }
}

/// A run that ended in an error, with all that it did until then.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RunFailure<E: Error + 'static = IntegratorError> {
    /// What went wrong.
    #[source]
    pub error: RunError<E>,
    /// The run up to the last good state.
    pub until: Run,
}

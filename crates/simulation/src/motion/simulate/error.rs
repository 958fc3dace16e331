//! Errors of a run.

use robot_dynamics_core::SingularMass;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};

use super::divergence_cause::DivergenceCause;
use super::event::{Cause, NoValue};
use super::{CallbackError, ControllerError, Run, StepError};

/// The error of a step or a run of a [`Simulation`](crate::simulator::Simulation). A run that keeps its results
/// returns it in a [`RunFailure`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[doc(alias = "StepFailure")]
pub enum RunError {
    /// The step, a duration or the initial configuration is invalid.
    #[error("the run cannot start: {0}")]
    Input(#[from] InvalidInput),
    /// A torque of a controller or of `set_torques`, a wrench or a control is NaN or infinite.
    #[error("t = {time} s (step {step}): {source}")]
    StepInput {
        /// Completed steps.
        step: usize,
        /// The time \[s\].
        time: f64,
        /// The number, with its coordinate.
        source: InvalidInput,
    },
    /// A computed number is NaN or infinite.
    #[error(
        "{quantity} is not finite at coordinate `{coordinate}`, t = {time} s (step {step}); \
         check the inputs, or take a smaller step"
    )]
    NotFinite {
        /// The quantity: `v`, `the acceleration`, `the energy`, ...
        quantity: &'static str,
        /// The first coordinate with such a number; for the energy, the fastest coordinate.
        coordinate: String,
        /// Completed steps.
        step: usize,
        /// The time of the detection \[s\].
        time: f64,
    },
    /// The motion diverged, for example because a spring or servo is too stiff for the step.
    #[error(
        "the motion grows without bound: `{coordinate}` has v = {speed:.1e} at t = {time} s (step {step}); try a step of {suggested_step:.1e} s, \
         {cause}"
    )]
    Diverged {
        /// The fastest coordinate.
        coordinate: String,
        /// Its velocity \[rad/s or m/s\].
        speed: f64,
        /// Completed steps.
        step: usize,
        /// The time of the detection \[s\].
        time: f64,
        /// A step that should be stable \[s\]; see the cause.
        suggested_step: f64,
        /// The cause that determines the suggested step.
        cause: DivergenceCause,
    },
    /// M is singular: some motion has no inertia in the current configuration, so the acceleration is
    /// undefined.
    #[error("t = {time} s (step {step}): {source}")]
    SingularMass {
        /// Completed steps.
        step: usize,
        /// The time \[s\].
        time: f64,
        /// The joints without inertia.
        source: SingularMass,
    },
    /// The controller failed.
    #[error("the controller gave no torque at t = {time} s (step {step}): {source}")]
    Controller {
        /// Completed steps.
        step: usize,
        /// The time \[s\].
        time: f64,
        /// The cause.
        source: ControllerError,
    },
    /// The function of an event is NaN or infinite.
    #[error("the function of event `{name}` is {value} at t = {time} s")]
    EventNotFinite {
        /// The name of the event.
        name: String,
        /// The time \[s\].
        time: f64,
        /// The value of the function.
        value: f64,
    },
    /// The function of an event failed.
    #[error("the function of event `{name}` failed at t = {time} s: {source}")]
    Event {
        /// The name of the event.
        name: String,
        /// The time \[s\].
        time: f64,
        /// The error of the function.
        source: CallbackError,
    },
    /// A step failed.
    #[error("t = {time} s (step {step}): {source}")]
    Step {
        /// Completed steps.
        step: usize,
        /// The time \[s\].
        time: f64,
        /// The cause.
        source: StepError,
    },
}

impl Classified for RunError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(source) | Self::StepInput { source, .. } => source.kind(),
            Self::NotFinite { .. } | Self::Diverged { .. } => ErrorKind::Diverged,
            Self::SingularMass { source, .. } => source.kind(),
            Self::Controller { source, .. } => source.kind(),
            Self::EventNotFinite { .. } | Self::Event { .. } => ErrorKind::Callback,
            Self::Step { source, .. } => source.kind(),
        }
    }
}

impl From<NoValue> for RunError {
    fn from(NoValue { name, time, cause }: NoValue) -> Self {
        match cause {
            Cause::NotFinite(value) => Self::EventNotFinite { name, time, value },
            Cause::Failed(source) => Self::Event { name, time, source },
        }
    }
}

/// The error of a run, with the results up to it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RunFailure {
    /// The error.
    #[source]
    pub error: RunError,
    /// The run up to the last good state.
    pub until: Run,
}

impl Classified for RunFailure {
    fn kind(&self) -> ErrorKind {
        self.error.kind()
    }
}

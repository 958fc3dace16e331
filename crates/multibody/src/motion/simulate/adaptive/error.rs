//! Why an adaptive run ended early.

use thiserror::Error;

use super::super::event::{Cause, NoValue};
use super::AdaptiveRun;
use crate::{CallbackError, ConfigurationError, ControllerError, SingularMass};

/// Why an adaptive run could not start or go on.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// The state to start from is no configuration.
    #[error("the run cannot start: {0}")]
    Configuration(#[source] ConfigurationError),
    /// A tolerance that no step can meet, or that says nothing.
    #[error("the tolerance must lie between {least:e} and {most:e}, got {tolerance:e}")]
    Tolerance {
        /// The tolerance given.
        tolerance: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// Sample times that do not increase.
    #[error("sample time {index} is {time} s, after {before} s; the times must be finite and increase")]
    Times {
        /// Which.
        index: usize,
        /// The time \[s\].
        time: f64,
        /// The one before \[s\].
        before: f64,
    },
    /// Fewer than two sample times: no start and end.
    #[error("a run needs at least two sample times, its start and its end")]
    NoSpan,
    /// A joint with Coulomb friction.
    #[error(
        "coordinate `{coordinate}` has Coulomb friction, which jumps where the velocity changes its sign: no step \
         is small enough to pass where the joint sticks; take a fixed step, or leave the dissipation out"
    )]
    Friction {
        /// The coordinate.
        coordinate: String,
    },
    /// The motion grew until steps that meet the tolerance lost the digits of an angle or a position.
    #[error(
        "the motion grows without bound: `{coordinate}` moves at {speed:.2e} rad/s or m/s at t = {time} s, and steps of {step:.1e} s follow \
         it within the tolerance, so that no shorter step helps; look at the controller's gains and for dampers with the wrong sign"
    )]
    Diverged {
        /// The coordinate that moves fastest.
        coordinate: String,
        /// How fast \[rad/s or m/s\].
        speed: f64,
        /// The time \[s\].
        time: f64,
        /// The last step \[s\].
        step: f64,
    },
    /// A number became NaN or infinite, or was given so.
    #[error("{quantity} is not finite at coordinate `{coordinate}`, t = {time} s; check the inputs")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
        /// The first coordinate it was seen at.
        coordinate: String,
        /// The time \[s\].
        time: f64,
    },
    /// Some motion moves no inertia in the configuration reached, so no acceleration follows from the forces.
    #[error("t = {time} s: {source}")]
    SingularMass {
        /// The time \[s\].
        time: f64,
        /// Which joints.
        source: SingularMass,
    },
    /// A control period that is none.
    #[error("the control period must be positive and finite, got {period} s")]
    Period {
        /// The period given \[s\].
        period: f64,
    },
    /// The controller gave no torque.
    #[error("the controller gave no torque at t = {time} s: {source}")]
    Controller {
        /// The time \[s\]; of continuous control the last to which a step could be taken.
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
    /// The tolerance asks for steps below the rounding of time.
    #[error(
        "at t = {time} s the tolerance asks for steps below {step:e} s, most of all at coordinate `{coordinate}`: the \
         forces are not smooth there, or the tolerance is below rounding; a looser tolerance, or a fixed step, goes on"
    )]
    StepTooSmall {
        /// The time \[s\].
        time: f64,
        /// The step \[s\].
        step: f64,
        /// The coordinate with the largest local error.
        coordinate: String,
    },
    /// As many steps as may be taken from one sample to the next.
    #[error(
        "{steps} steps after the sample before came to t = {time} s only: coordinate `{coordinate}` asks for steps of \
         {step:.1e} s there, as a stiff or a very light joint does; allow more (max_steps), or a looser tolerance"
    )]
    TooManySteps {
        /// Steps tried.
        steps: usize,
        /// The time reached \[s\].
        time: f64,
        /// The step that the tolerance allows there \[s\].
        step: f64,
        /// The coordinate with the largest local error.
        coordinate: String,
    },
}

impl From<NoValue> for AdaptiveError {
    fn from(NoValue { name, time, cause }: NoValue) -> Self {
        match cause {
            Cause::NotFinite(value) => Self::EventNotFinite { name, time, value },
            Cause::Failed(source) => Self::Event { name, time, source },
        }
    }
}

/// An adaptive run that ended in an error, with all that it did until then.
#[derive(Clone, Debug, Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct AdaptiveFailure {
    /// What went wrong.
    #[source]
    pub error: AdaptiveError,
    /// The run up to its last step.
    pub until: AdaptiveRun,
}

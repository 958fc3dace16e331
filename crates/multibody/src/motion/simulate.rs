//! The parts of a run: steppers, controllers, events, samples and the energy account.

mod actuated;
#[cfg(feature = "adaptive")]
mod adaptive;
mod advance;
mod between;
mod callback;
mod control;
mod control_error;
mod cut;
mod divergence;
mod error;
mod event;
pub(crate) mod ledger;
mod losses;
mod pd;
mod root;
mod run;
mod stepper;
mod trajectory;

pub use actuated::ActuatedStepError;
pub(crate) use actuated::ActuatedStepper;
#[cfg(feature = "adaptive")]
pub(crate) use adaptive::{AdaptiveCourse, AdaptiveStepper, Applied};
#[cfg(feature = "adaptive")]
pub use adaptive::{
    AdaptiveMethod, AdaptiveOptions, AdaptiveOptionsError, AdaptiveRecord, AdaptiveStepError, ControlTiming,
    StepStatistics,
};
pub(crate) use between::Between;
pub use callback::{CallbackError, Outcome};
pub use control::{ConstantTorque, Controller, ZeroTorque};
pub use control_error::ControllerError;
pub(crate) use control_error::{check_finite, check_moment, check_number, check_torque};
pub use divergence::DivergenceCause;
pub(crate) use divergence::add_passive_gains;
pub use error::{RunError, RunFailure};
pub(crate) use event::Watch;
pub use event::{Event, EventOccurrence};
pub(crate) use ledger::travel;
pub use ledger::{energy_ledger, record_step};
pub use losses::Losses;
pub use pd::{GravityAt, GravityCompensatedPd};
pub(crate) use run::Course;
pub use run::{Observer, Run, StepInfo};
pub use stepper::{StepError, StepFault, Stepper};
pub use trajectory::{Sample, Trajectory};

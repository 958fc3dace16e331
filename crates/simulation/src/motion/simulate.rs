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
pub mod ledger;
mod losses;
mod pd;
mod root;
mod run;
mod stepper;
mod trajectory;

pub use actuated::ActuatedStepError;
pub use actuated::ActuatedStepper;
#[cfg(feature = "adaptive")]
pub use adaptive::{
    AdaptiveMethod, AdaptiveOptions, AdaptiveOptionsError, AdaptiveRecord, AdaptiveStepError, ControlTiming,
    StepStatistics,
};
#[cfg(feature = "adaptive")]
pub use adaptive::{AdaptiveRun, AdaptiveStepper, ExternalInputs};
pub use between::Between;
pub use callback::{CallbackError, IntoCallbackResult};
pub use control::{ConstantTorque, Controller, ZeroTorque};
pub use control_error::ControllerError;
pub use control_error::{check_controller_input, check_finite, check_number, check_torque};
pub use divergence::DivergenceCause;
pub use divergence::add_passive_gains;
pub use error::{RunError, RunFailure};
pub use event::EventDetector;
pub use event::{Event, EventOccurrence};
pub use ledger::end_energies;
pub use ledger::{energy_ledger, record_step};
pub use losses::Losses;
pub use pd::{GravityAt, GravityCompensatedPd};
pub use run::RunLoop;
pub use run::{Observer, Run, StepInfo};
pub use stepper::{StepError, StepFault, Stepper};
pub use trajectory::{Sample, Trajectory};

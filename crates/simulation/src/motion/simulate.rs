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
mod divergence_cause;
mod duration;
mod error;
mod event;
mod gains;
pub mod ledger;
mod losses;
mod pd;
mod results;
mod root;
mod run;
mod step_error;
mod stepper;
mod trajectory;

pub use actuated::ActuatedStepper;
#[cfg(feature = "adaptive")]
pub use adaptive::{
    AdaptiveMethod, AdaptiveOptions, AdaptiveRecord, AdaptiveRun, AdaptiveStepper, ControlTiming,
    ExternalInputs, StepStatistics,
};
pub use between::Between;
pub use callback::{CallbackError, IntoCallbackResult};
pub use control::{ConstantTorque, Controller, ZeroTorque};
pub(crate) use control_error::check_input_torque;
pub use control_error::{ControllerError, check_controller_input, check_torque};
pub use divergence_cause::DivergenceCause;
pub use duration::steps_in;
pub use error::{RunError, RunFailure};
pub use event::{Event, EventDetector, EventOccurrence};
pub use gains::add_passive_gains;
pub use ledger::{StateTransition, end_energies, energy_ledger, record_step};
pub use losses::Losses;
pub use pd::{GravityAt, GravityCompensatedPd};
pub use results::{Observer, Run, StepInfo};
pub use run::RunLoop;
pub use step_error::StepError;
pub use stepper::Stepper;
pub use trajectory::{Sample, Trajectory};

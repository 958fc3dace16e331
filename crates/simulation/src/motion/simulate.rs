//! The parts of a run: steppers, controllers, events, samples and the energy account.

mod actuated_stepper;
#[cfg(feature = "adaptive")]
mod adaptive;
mod advance;
mod callback;
mod control;
mod control_error;
mod delayed;
mod divergence;
mod divergence_cause;
mod duration;
pub mod energy_account;
mod error;
mod event;
mod gains;
mod implicit_gains;
mod interpolation;
mod losses;
mod pd;
mod results;
mod root;
mod run;
mod shortened_step;
mod step_error;
mod stepper;
mod trajectory;

pub use actuated_stepper::ActuatedStepper;
#[cfg(feature = "adaptive")]
pub use adaptive::{
    AdaptiveMethod, AdaptiveOptions, AdaptiveRecord, AdaptiveRun, AdaptiveStepper, ControlTiming,
    ExternalInputs, StepStatistics,
};
pub use callback::{CallbackError, IntoCallbackResult};
pub use control::{ConstantTorque, Controller, ZeroTorque};
pub(crate) use control_error::check_input_torque;
pub use control_error::{ControllerError, check_controller_input, check_torque, singular_mass};
pub use delayed::Delayed;
pub use divergence_cause::DivergenceCause;
pub use duration::steps_in;
pub use energy_account::{StateTransition, end_energies, energy_account, record_step};
pub use error::{RunError, RunFailure};
pub use event::{Event, EventDetector, EventOccurrence};
pub use gains::add_passive_gains;
pub use implicit_gains::{ImplicitGains, WithImplicitGains, set_limits};
pub use interpolation::StepInterpolation;
pub use losses::Losses;
pub use pd::{GravityAt, GravityCompensatedPd};
pub use results::{Observer, Run, StepInfo};
pub use run::RunLoop;
pub use step_error::StepError;
pub use stepper::Stepper;
pub use trajectory::{Sample, Trajectory};

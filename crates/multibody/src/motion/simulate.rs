//! A run: an integrator, a controller and the energy ledger, from a state for a number of steps.

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
mod ledger;
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
pub use run::{Moment, Observer, Run};
pub use stepper::{StepError, StepFault, Stepper};
pub use trajectory::{Sample, Trajectory};

use std::ops::ControlFlow;

use dynamics::Integrator;

use crate::Model;

/// How a run is made.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Simulation<'a, I = Integrator> {
    /// The robot.
    pub model: &'a Model,
    /// The row of the table of integrators, or another [`Stepper`].
    pub integrator: I,
    /// The step, which is also the control period \[s\].
    pub step: f64,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

impl<'a, I> Simulation<'a, I> {
    /// By that integrator, with steps of that length \[s\]; damping and friction act, and every state is kept.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// use multibody::{Model, Simulation, ZeroTorque, pendulum};
    /// use std::ops::ControlFlow;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let simulation = Simulation::new(&model, Integrator::RungeKutta4, 1e-3).with_samples_every(100);
    /// let run = simulation.run(&[0.3], &[0.0], 1000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    /// assert!((run.time - 1.0).abs() < 1e-12 && run.trajectory.len() == 11);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub const fn new(model: &'a Model, integrator: I, step: f64) -> Self {
        Self { model, integrator, step, dissipation: true, sample_every: 1 }
    }

    /// Whether the joints' damping and friction act.
    pub fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub fn with_samples_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }
}

impl<I: Stepper + Clone> Simulation<'_, I> {
    /// Runs `steps` steps from (q0, v0). The controller is asked at the start of each step and its torque
    /// held over it; the observer is called at each of these instants and at the end, and may break off.
    ///
    /// What is computed until an interruption or an error is kept: the run is in the result, and in the
    /// error.
    ///
    /// # Errors
    /// [`RunFailure`]: q0 is no configuration, v0, a torque or the step is not finite, the controller fails, M is
    /// singular at the start of a step, an implicit step does not converge, or the motion blows up; with time, step
    /// and coordinate or joints.
    ///
    /// # Panics
    /// If v0 has the wrong length.
    ///
    /// ```
    /// use dynamics::{Integrator, MassProperties};
    /// use multibody::{Base, LinkDescription, Model, RobotDescription, Simulation, ZeroTorque, neutral};
    /// use nalgebra::Vector3;
    /// use std::ops::ControlFlow;
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let run = Simulation::new(&model, Integrator::RungeKutta4, 1e-3)
    ///     .with_samples_every(100)
    ///     .run(&neutral(&model), &[0.0; 6], 1000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    /// // Free fall for a second.
    /// assert_eq!(run.trajectory.len(), 11);
    /// assert!((run.q[2] + 9.81 / 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Box<RunFailure<I::Error>>> {
        self.run_with_events(q0, v0, steps, controller, &mut [], observer)
    }

    /// As [`run`](Self::run), with events watched for all along: [`Run::events`].
    ///
    /// Inside a step the state is q(t) = q₀ ⊕ Θ(t), Θ the cubic with the step's displacement and end velocities, off by
    /// |Θ⁗| h⁴/384 at most. v follows from Θ̇, off by O(h³); in rows of first and second order it is the line between
    /// the end velocities, off by O(h²). So crossings of a function of q are found to the row's order up to 4, of v up
    /// to 3.
    ///
    /// A terminal event ends the run by a step of the same row from the last step's start, cut so short that it ends
    /// there, its length improved by one step of Newton's method: that end is as accurate as any step's. It is the last
    /// sample, and the controller and the observer are asked there too.
    ///
    /// # Errors
    /// As [`run`](Self::run), and where the function of an event fails or is not finite ([`RunError::Event`],
    /// [`RunError::EventNotFinite`]): the run then ends with the step before.
    ///
    /// # Panics
    /// If v0 has the wrong length.
    ///
    /// ```
    /// use dynamics::{Integrator, MassProperties};
    /// use multibody::{Base, Event, LinkDescription, Model, RobotDescription, Simulation, ZeroTorque, neutral};
    /// use nalgebra::Vector3;
    /// use std::ops::ControlFlow;
    /// // A brick thrown up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let v = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
    /// let simulation = Simulation::new(&model, Integrator::RungeKutta4, 0.01);
    /// let run = simulation
    ///     .run_with_events(&q, &v, 1000, &mut ZeroTorque, &mut events, |_| ControlFlow::Continue(()))?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!(run.ended_by_event && run.q[2].abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn run_with_events(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        events: &mut [Event<'_>],
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Box<RunFailure<I::Error>>> {
        let Self { model, ref integrator, step, dissipation, sample_every } = *self;
        let course = Course { model, step, dissipation, sample_every, base: (0, 0.0) };
        course.run(&mut integrator.clone(), (q0, v0), steps, controller, events, observer)
    }
}

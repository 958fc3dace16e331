//! A run: an integrator, a controller and the energy ledger, from a state for a number of steps.

#[cfg(feature = "adaptive")]
mod adaptive;
mod callback;
mod control;
mod control_error;
mod error;
mod ledger;
mod pd;
mod trajectory;

#[cfg(feature = "adaptive")]
pub use adaptive::{
    AdaptiveEnd, AdaptiveError, AdaptiveFailure, AdaptiveRun, AdaptiveSimulation, ControlTiming, Event,
    EventOccurrence, StepStatistics,
};
pub use callback::{CallbackError, Outcome};
pub use control::{ConstantTorque, Controller, ZeroTorque};
pub use control_error::ControllerError;
pub(crate) use control_error::{check_finite, check_moment, check_number, check_torque};
pub use error::{RunError, RunFailure};
pub use ledger::EnergyLedger;
pub use pd::{GravityAt, GravityCompensatedPd};
pub use trajectory::{Sample, Trajectory};

use std::ops::ControlFlow;

use dynamics::{DynamicsError, Integrator, IntegratorError};

use crate::algorithms::rank::check_rank;
use crate::model::length::check_length;
use crate::motion::integrate::check_step;
use crate::{Model, SingularMass, StepForces, StepWorkspace, check_configuration, step};

/// How a run is made.
#[derive(Clone, Copy, Debug)]
pub struct Simulation<'a> {
    /// The robot.
    pub model: &'a Model,
    /// The row of the table of integrators.
    pub integrator: Integrator,
    /// The step, which is also the control period \[s\].
    pub step: f64,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

/// What an observer sees: the state at a control instant, before the torque acts.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Steps done.
    pub step: usize,
    /// Time since the start \[s\].
    pub time: f64,
    /// The configuration.
    pub q: &'a [f64],
    /// The velocity.
    pub v: &'a [f64],
    /// The torque the controller gives here \[N·m or N\].
    pub tau: &'a [f64],
    /// The books so far.
    pub ledger: &'a EnergyLedger,
}

/// What a run did.
#[derive(Clone, Debug)]
pub struct Run {
    /// The samples.
    pub trajectory: Trajectory,
    /// The books.
    pub ledger: EnergyLedger,
    /// The largest |τ| that acted on each coordinate \[N·m or N\].
    pub peak_torque: Vec<f64>,
    /// Steps done.
    pub steps: usize,
    /// Whether the observer ended it early.
    pub interrupted: bool,
    /// q at the end.
    pub q: Vec<f64>,
    /// v at the end.
    pub v: Vec<f64>,
}

impl Simulation<'_> {
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
    /// robot.links.push(LinkDescription { name: "brick".into(), mass_properties: Some(brick) });
    /// let model = Model::new(robot)?;
    /// let run = Simulation {
    ///     model: &model,
    ///     integrator: Integrator::RungeKutta4,
    ///     step: 1e-3,
    ///     dissipation: false,
    ///     sample_every: 100,
    /// }
    /// .run(&neutral(&model), &[0.0; 6], 1000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    /// // Free fall for a second.
    /// assert_eq!(run.trajectory.len(), 11);
    /// assert!((run.q[2] + 9.81 / 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        mut observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Box<RunFailure>> {
        let Self { model, step: h, .. } = *self;
        check_length("v0", v0.len(), model.nv());
        let mut workspace = StepWorkspace::new(model);
        let start =
            check_step(h).map_err(|source| RunError::Step { step: 0, time: 0.0, source }).and_then(|()| {
                check_configuration(model, q0).map_err(RunError::Configuration)?;
                match v0.iter().position(|v| !v.is_finite()) {
                    Some(index) => Err(self.blow_up("v", index, 0)),
                    None if steps == 0 => Ok(()),
                    None => self.check_mass(&mut workspace, q0, 0),
                }
            });
        let overflow = |fastest, _| self.blow_up("the energy", fastest, 0);
        let (ledger, q, v, start) =
            EnergyLedger::open_start(model, &mut workspace.dynamics, q0, v0, start, overflow);
        let mut run = Run {
            ledger,
            trajectory: Trajectory::new(model, self.samples_of(steps)),
            peak_torque: vec![0.0; model.nv()],
            steps: 0,
            interrupted: false,
            q,
            v,
        };
        match start.and_then(|()| self.advance(&mut run, steps, &mut workspace, controller, &mut observer)) {
            Ok(()) => Ok(run),
            Err(error) => Err(Box::new(RunFailure { error, until: run })),
        }
    }

    /// The loop: torque, sample, observer, step, books.
    fn advance(
        &self,
        run: &mut Run,
        steps: usize,
        workspace: &mut StepWorkspace,
        controller: &mut (impl Controller + ?Sized),
        observer: &mut impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunError> {
        let model = self.model;
        let mut tau = vec![0.0; model.nv()];
        let (mut q, mut v) = (run.q.clone(), run.v.clone());
        for done in 0..=steps {
            let time = done as f64 * self.step;
            controller.torque(time, &run.q, &run.v, &mut tau).map_err(|source| RunError::Controller {
                step: done,
                time,
                source,
            })?;
            if let Some(index) = tau.iter().position(|x| !x.is_finite()) {
                return Err(self.blow_up("the controller's torque", index, done));
            }
            let moment = Moment { step: done, time, q: &run.q, v: &run.v, tau: &tau, ledger: &run.ledger };
            let flow = observer(&moment);
            let last = done == steps || flow.is_break();
            if last || done == 0 || (self.sample_every > 0 && done % self.sample_every == 0) {
                run.trajectory.push(&moment);
            }
            if last {
                run.interrupted = done < steps;
                return Ok(());
            }
            if done > 0 {
                self.check_mass(workspace, &run.q, done)?;
            }
            for (peak, tau) in run.peak_torque.iter_mut().zip(&tau) {
                *peak = peak.max(tau.abs());
            }
            let forces = StepForces { tau: &tau, dissipation: self.dissipation };
            step(model, self.integrator, workspace, &forces, self.step, &mut q, &mut v)
                .map_err(|error| self.step_failed(error, done))?;
            self.check_state(&q, &v, done + 1)?;
            let (from, to) = ((&run.q[..], &run.v[..]), (&q[..], &v[..]));
            run.ledger
                .record_finite(model, &mut workspace.dynamics, from, to, &forces, self.step)
                .map_err(|(fastest, _)| self.blow_up("the energy", fastest, done + 1))?;
            run.q.copy_from_slice(&q);
            run.v.copy_from_slice(&v);
            run.steps = done + 1;
        }
        Ok(())
    }

    /// Refuses to step on from a configuration in which M is singular: one O(n) pass.
    fn check_mass(&self, workspace: &mut StepWorkspace, q: &[f64], step: usize) -> Result<(), RunError> {
        check_rank(self.model, &mut workspace.dynamics, q).map_err(|source| self.singular(source, step))
    }

    fn singular(&self, source: SingularMass, step: usize) -> RunError {
        RunError::SingularMass { step, time: step as f64 * self.step, source }
    }

    fn check_state(&self, q: &[f64], v: &[f64], step: usize) -> Result<(), RunError> {
        if let Some(index) = v.iter().position(|x| !x.is_finite()) {
            return Err(self.blow_up("v", index, step));
        }
        let Some(index) = q.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        Err(self.blow_up("q", self.first_coordinate_of(index), step))
    }

    /// The first entry in v of the joint that owns an entry of q.
    fn first_coordinate_of(&self, index: usize) -> usize {
        let owner = self.model.joints().iter().find(|j| (j.q_index..j.q_index + j.nq).contains(&index));
        owner.map_or(0, |joint| joint.v_index)
    }

    fn blow_up(&self, quantity: &'static str, index: usize, step: usize) -> RunError {
        let coordinate = self.model.coordinate_names().get(index).cloned().unwrap_or_default();
        RunError::NotFinite { quantity, coordinate, step, time: step as f64 * self.step }
    }

    fn step_failed(&self, error: IntegratorError, step: usize) -> RunError {
        match error {
            IntegratorError::Dynamics(DynamicsError::NonFinite { quantity, index }) => {
                let index = if quantity.starts_with('q') { self.first_coordinate_of(index) } else { index };
                self.blow_up(quantity, index, step)
            }
            // Inside the step.
            IntegratorError::Dynamics(DynamicsError::SingularMass { coordinate, pivot }) => {
                self.singular(SingularMass::at(self.model, coordinate, pivot), step)
            }
            source => RunError::Step { step, time: step as f64 * self.step, source },
        }
    }

    /// Samples a run of so many steps will keep; memory for a million is taken at once, for more as it comes.
    fn samples_of(&self, steps: usize) -> usize {
        (steps.checked_div(self.sample_every).unwrap_or(0) + 2).min(1_000_000)
    }
}

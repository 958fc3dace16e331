//! Adaptive runs and steps, controlled by a tolerance.

use std::sync::Arc;

use robot_dynamics_core::Workspace;
use robot_dynamics_integrators::IntegratorError;

use super::method::StepperKind;
use super::{Observer, Simulation};
use crate::motion::simulate::{AdaptiveRun, EventDetector, ExternalInputs};
use crate::{AdaptiveRecord, Controller, RunError, Trajectory};

impl Simulation {
    /// The record of adaptive steps since the last reset; `None` for other methods.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{AdaptiveOptions, SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).adaptive(AdaptiveOptions::default()).build()?;
    /// simulation.run_for(0.1)?;
    /// let record = simulation.adaptive_record().expect("steps are adaptive");
    /// assert!(record.statistics.accepted >= 100 && record.method.order() == 9); // each step ends within its millisecond
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn adaptive_record(&self) -> Option<&AdaptiveRecord> {
        match &self.stepper.kind {
            StepperKind::Adaptive(stepper) => Some(&stepper.record),
            _ => None,
        }
    }

    pub(super) fn is_adaptive(&self) -> bool {
        matches!(self.stepper.kind, StepperKind::Adaptive(_))
    }

    /// Advances by `steps` times the simulation's step with adaptive steps.
    pub(super) fn follow(
        &mut self,
        steps: usize,
        sample_every: usize,
        (controller, mut detector, observer): (
            Option<&mut dyn Controller>,
            EventDetector<'_, '_>,
            Option<Observer<'_>>,
        ),
    ) -> Result<(), RunError> {
        let model = Arc::clone(&self.model);
        let is_controlled = controller.is_some();
        if is_controlled {
            self.inputs.torques.fill(0.0);
        }
        let fixed = self.run_loop(&model, 0, self.base);
        self.begin_step(&fixed)?;
        let first = self.run.steps;
        let Self { stepper, workspace, run, memory, inputs, effort, limited, .. } = self;
        let StepperKind::Adaptive(stepper) = &mut stepper.kind else { return Ok(()) };
        let (wrenches, mut kinematics) = (&inputs.wrenches, Workspace::new(&model));
        let jacobian = &mut memory.jacobian;
        let mut add_wrenches = |q: &[f64], tau: &mut [f64]| {
            for wrench in wrenches {
                wrench.add_to(&model, &mut kinematics, q, jacobian, tau);
            }
        };
        let mut applied = ExternalInputs::held(&inputs.torques);
        applied.driven = stepper.driven_from(run.time);
        let start = run.time;
        applied.controller = controller.map(|controller| controller as &mut dyn Controller);
        applied.effort = effort.as_deref();
        if !wrenches.is_empty() {
            applied.wrenches = Some(&mut add_wrenches);
        }
        let mut course = AdaptiveRun {
            model: &model,
            stepper,
            workspace: workspace.dynamics(),
            run,
            dissipation: self.dissipates,
            sample_every,
            observer,
            limited,
            tau: &mut memory.tau,
            acceleration: &mut memory.acceleration,
        };
        let done = course.follow(steps, &|instant| fixed.time(first + instant), applied, &mut detector);
        if is_controlled {
            self.inputs.torques.copy_from_slice(&self.memory.tau);
        }
        if let Some(actuation) = &self.actuation {
            if let StepperKind::Adaptive(stepper) = &self.stepper.kind {
                self.activations[actuation.control_count()..].copy_from_slice(stepper.controller_states());
            }
            actuation.activate(&self.inputs.controls, self.run.time - start, &mut self.activations);
        }
        if self.run.time != fixed.time(self.run.steps) {
            self.base = (self.run.steps, self.run.time);
        }
        self.is_checked = false;
        done
    }

    /// Advances by one step with adaptive steps; on failure the simulation is unchanged.
    pub(super) fn step_adaptively(&mut self) -> Result<(), RunError> {
        let (run, stepper, base) = (self.run.clone(), self.stepper.clone(), self.base);
        let activations = self.activations.clone();
        let detector = EventDetector::start(&mut [], run.time, &run.q, &run.v)?;
        let done = match self.follow(1, 0, (None, detector, None)) {
            Ok(()) if self.run.interrupted => {
                let source = IntegratorError::Interrupted.into();
                Err(RunError::Step { step: run.steps, time: run.time, source })
            }
            done => done,
        };
        if done.is_err() {
            (self.run, self.stepper, self.base) = (run, stepper, base);
            self.activations = activations;
        } else {
            self.run.trajectory = Trajectory::new(&self.model, 0);
        }
        done
    }
}

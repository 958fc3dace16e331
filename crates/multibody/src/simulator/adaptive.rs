//! Runs and steps by a tolerance.

use std::sync::Arc;

use dynamics::IntegratorError;

use super::error::{MethodError, StepFailure};
use super::method::StepperKind;
use super::{Observer, Simulation};
use crate::motion::simulate::{AdaptiveCourse, AdaptiveStepError, Applied, Watch};
use crate::{AdaptiveRecord, Controller, RunError, Trajectory, Workspace};

impl Simulation {
    /// The record of adaptive steps since the last reset; `None` for other methods.
    ///
    /// ```
    /// use multibody::{AdaptiveOptions, Model, pendulum, simulator::SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).adaptive(AdaptiveOptions::default()).build()?;
    /// simulation.run_for(0.1)?;
    /// let record = simulation.adaptive_record().expect("steps are adaptive");
    /// assert!(record.statistics.accepted >= 100 && record.method.order() == 9); // no step goes across a millisecond here
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

    /// `steps` times the simulation's step by adaptive steps.
    pub(super) fn follow(
        &mut self,
        steps: usize,
        sample_every: usize,
        (controller, mut watch, observer): (Option<&mut dyn Controller>, Watch<'_, '_>, Option<Observer<'_>>),
    ) -> Result<(), StepFailure> {
        let model = Arc::clone(&self.model);
        let is_controlled = controller.is_some();
        if is_controlled {
            self.inputs.torques.fill(0.0);
        }
        let fixed = self.course(&model, 0, self.base);
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
        let mut applied = Applied::held(&inputs.torques);
        applied.driven = stepper.driven_from(run.time);
        let start = run.time;
        applied.controller = controller.map(|controller| controller as &mut dyn Controller);
        applied.effort = effort.as_deref();
        if !wrenches.is_empty() {
            applied.wrenches = Some(&mut add_wrenches);
        }
        let mut course = AdaptiveCourse {
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
        let done = course.follow(steps, &|instant| fixed.time(first + instant), applied, &mut watch);
        if is_controlled {
            self.inputs.torques.copy_from_slice(&self.memory.tau);
        }
        if let Some(actuation) = &self.actuation {
            actuation.activate(&self.inputs.controls, self.run.time - start, &mut self.activations);
        }
        if self.run.time != fixed.time(self.run.steps) {
            self.base = (self.run.steps, self.run.time);
        }
        self.is_checked = false;
        done.map_err(|error| error.map(MethodError::from))
    }

    /// One step by adaptive steps; where it fails, all is as before it.
    pub(super) fn step_adaptively(&mut self) -> Result<(), StepFailure> {
        let (run, stepper, base) = (self.run.clone(), self.stepper.clone(), self.base);
        let activations = self.activations.clone();
        let watch = Watch::start(&mut [], run.time, &run.q, &run.v)?;
        let done = match self.follow(1, 0, (None, watch, None)) {
            Ok(()) if self.run.interrupted => {
                let source = AdaptiveStepError::from(IntegratorError::Interrupted).into();
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

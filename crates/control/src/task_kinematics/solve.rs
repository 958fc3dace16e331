//! Configurations that reach the targets of all tasks.

use std::borrow::Borrow;

use robot_dynamics_core::{Model, Workspace, check_configuration, integrate};

use super::avoidance::Avoidance;
use super::controller::TaskKinematics;
use super::error::{TaskKinematicsError, unreached};
use super::levels::{Bounded, Inequalities, Levels, StepLaw};
use super::rows::{Place, TaskRows};
use super::solution::{TaskResidual, TaskSolution};
use crate::inverse_kinematics::InverseKinematicsOptions;
use crate::inverse_kinematics::bounds::Bounds;
use crate::inverse_kinematics::error::check_options;
use crate::inverse_kinematics::iteration::{Evaluation, Iteration, LeastSquares, Search};

/// The tasks as a least-squares problem: those of the first level.
struct TaskProblem<'a> {
    model: &'a Model,
    options: &'a InverseKinematicsOptions,
    tasks: &'a mut [TaskRows],
    level_numbers: &'a [usize],
    levels: &'a mut Levels,
    bounds: &'a Bounds,
    avoidance: Option<&'a mut Avoidance>,
    inequalities: &'a mut Inequalities,
    lower: &'a mut [f64],
    upper: &'a mut [f64],
    scratch: &'a mut [f64],
}

impl TaskProblem<'_> {
    fn first(&self) -> Option<usize> {
        self.level_numbers.first().copied()
    }

    fn is_met(&self, error: TaskResidual) -> bool {
        error.position <= self.options.position_tolerance && error.angle <= self.options.angle_tolerance
    }

    /// Computes the errors of the first level, or of all.
    fn evaluate_levels(&mut self, workspace: &mut Workspace, q: &[f64], all: bool) -> Evaluation {
        let first = self.first();
        let mut place = Place { model: self.model, workspace, q, scratch: self.scratch };
        let mut evaluation = Evaluation { squared: 0.0, is_found: true };
        for rows in self.tasks.iter_mut() {
            let is_first = Some(rows.task.level) == first;
            if is_first || all {
                rows.evaluate(&mut place);
            }
            if is_first {
                evaluation.squared += rows.squared();
                let TaskResidual { position, angle } = rows.error;
                evaluation.is_found &=
                    position <= self.options.position_tolerance && angle <= self.options.angle_tolerance;
            }
        }
        if evaluation.is_found
            && let Some(avoidance) = &mut self.avoidance
        {
            evaluation.is_found = avoidance.is_clear(self.model, workspace, q);
        }
        evaluation
    }

    /// Computes the Jacobians of the first level, or of all, and the bounds at q.
    fn linearize_levels(&mut self, workspace: &mut Workspace, q: &[f64], all: bool) {
        let first = self.first();
        let mut place = Place { model: self.model, workspace: &mut *workspace, q, scratch: self.scratch };
        for rows in self.tasks.iter_mut().filter(|rows| all || Some(rows.task.level) == first) {
            rows.linearize(&mut place);
        }
        self.bounds.write_room(q, self.lower, self.upper);
        self.inequalities.clear();
        if let Some(avoidance) = &mut self.avoidance {
            let bounds = (&*self.lower, &*self.upper);
            avoidance.write_rows((self.model, workspace), q, bounds, self.inequalities);
        }
    }

    /// δ of the first levels.
    fn solve(&mut self, levels: usize, damping: f64) -> Option<()> {
        let bounded = Bounded { lower: self.lower, upper: self.upper, inequalities: self.inequalities };
        let numbers = &self.level_numbers[..levels.min(self.level_numbers.len())];
        self.levels.solve(self.tasks, numbers, bounded, StepLaw::global(damping)).ok()
    }

    /// The sum of squares of the tasks after the first level.
    fn later_squared(&self) -> f64 {
        let first = self.first();
        self.tasks.iter().filter(|rows| Some(rows.task.level) != first).map(TaskRows::squared).sum()
    }

    /// Decreases the errors of the later levels while the first one stays within the tolerances.
    fn improve(&mut self, workspace: &mut Workspace, q: &mut [f64]) -> usize {
        let (mut trial, mut damping, mut iterations) = (q.to_vec(), LEAST, 0);
        while iterations < self.options.max_iterations && damping < MOST {
            iterations += 1;
            self.evaluate_levels(workspace, q, true);
            self.linearize_levels(workspace, q, true);
            let before = self.later_squared();
            if self.solve(self.level_numbers.len(), damping).is_none() {
                break;
            }
            integrate(self.model, q, &self.levels.x, &mut trial);
            self.bounds.clamp(&mut trial);
            let is_found = self.correct(workspace, &mut trial);
            let gain = before - self.later_squared();
            if is_found && gain > 0.0 {
                q.copy_from_slice(&trial);
                damping = (damping / 8.0).max(LEAST);
                if gain <= STATIONARY * before {
                    break;
                }
            } else {
                damping *= 8.0;
            }
        }
        iterations
    }

    /// Brings the first level back within the tolerances; the errors of all levels are then those at q.
    fn correct(&mut self, workspace: &mut Workspace, q: &mut [f64]) -> bool {
        for _ in 0..CORRECTIONS {
            let found = self.evaluate_levels(workspace, q, true);
            if found.is_found {
                return true;
            }
            self.linearize_levels(workspace, q, false);
            if self.solve(1, 0.0).is_none() {
                return false;
            }
            let start = q.to_vec();
            integrate(self.model, &start, &self.levels.x, q);
            self.bounds.clamp(q);
        }
        self.evaluate_levels(workspace, q, true).is_found
    }
}

/// The damping of steps of later levels, least and most.
const LEAST: f64 = 1e-9;
const MOST: f64 = 1e6;

/// The relative decrease of the later levels' errors below which they count as stationary.
const STATIONARY: f64 = 1e-9;

/// The most steps back to the targets of the first level.
const CORRECTIONS: usize = 5;

impl LeastSquares for TaskProblem<'_> {
    fn evaluate(&mut self, workspace: &mut Workspace, q: &[f64]) -> Evaluation {
        self.evaluate_levels(workspace, q, false)
    }

    fn accept(&mut self) {
        self.tasks.iter_mut().for_each(TaskRows::keep);
    }

    fn linearize(&mut self, workspace: &mut Workspace, q: &[f64]) {
        self.linearize_levels(workspace, q, false);
    }

    fn step(&mut self, damping: f64, step: &mut [f64]) -> Option<f64> {
        let first = self.first();
        self.tasks.iter_mut().for_each(TaskRows::restore);
        let own = |rows: &&TaskRows| Some(rows.task.level) == first;
        let squared: f64 = self.tasks.iter().filter(own).map(TaskRows::squared).sum();
        self.solve(1, 0.5 * damping * squared)?;
        step.copy_from_slice(&self.levels.x);
        Some(self.tasks.iter().filter(own).map(|rows| rows.promised(step)).sum())
    }
}

impl<M: Borrow<Model>> TaskKinematics<M> {
    /// A configuration within the position limits in which all tasks of the first level are within the
    /// tolerances.
    ///
    /// Damped least-squares steps minimize Σ w |e|² of these tasks, from the start and then from random
    /// configurations, as [`inverse_kinematics`](crate::inverse_kinematics) does. Then steps in the order of
    /// the levels decrease the errors of the later tasks. Links that
    /// [must stay apart](Self::avoid_collisions) are at least d_min apart in the result. Velocity and
    /// acceleration limits, gains and damping do not apply.
    ///
    /// ```
    /// use robot_dynamics::control::InverseKinematicsOptions;
    /// use robot_dynamics::control::task_kinematics::{KinematicObjective, KinematicTask, TaskKinematics};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    /// let model = robot_dynamics::load(file)?.model;
    /// let start = [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
    /// let mut kinematics = TaskKinematics::new(&model);
    /// let hand = model.frame_named("panda_link8")?;
    /// kinematics.add_task(KinematicObjective::pose(hand, [0.4, 0.2, 0.5]))?;
    /// let posture = KinematicObjective::Posture { target: start.to_vec() };
    /// kinematics.add_task(KinematicTask::new(posture).with_level(1))?;
    /// let found = kinematics.solve(&start, &InverseKinematicsOptions::default())?;
    /// let reached = model.frame_pose(&found.q, hand)?.translation;
    /// assert!((reached[0] - 0.4).abs() < 1e-9 && found.errors[0].position < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`TaskKinematicsError::Unreached`] with the tasks, the coordinates at their limits and the nearest
    /// configuration; other variants if an input is invalid.
    pub fn solve(
        &mut self,
        start: &[f64],
        options: &InverseKinematicsOptions,
    ) -> Result<TaskSolution, TaskKinematicsError> {
        check_options(options)?;
        self.check_tasks()?;
        check_configuration(self.model.borrow(), start).map_err(|error| error.of("the start's q"))?;
        self.levels.clear_guesses();
        let Self {
            model,
            workspace,
            tasks,
            level_numbers,
            levels,
            bounds,
            avoidance,
            inequalities,
            lower,
            upper,
            scratch,
            ..
        } = &mut *self;
        let model: &Model = (*model).borrow();
        let mut problem = TaskProblem {
            model,
            options,
            tasks,
            level_numbers,
            levels,
            bounds,
            avoidance: avoidance.as_mut(),
            inequalities,
            lower,
            upper,
            scratch,
        };
        let found = Iteration::new(model, options, bounds).search(&mut problem, workspace, start);
        let Search { mut q, evaluation, mut iterations, restarts } = found;
        if evaluation.is_found && problem.level_numbers.len() > 1 {
            iterations += problem.improve(workspace, &mut q);
        }
        let is_found = problem.evaluate_levels(workspace, &q, true).is_found;
        let errors = problem.tasks.iter().map(|rows| rows.error).collect();
        let solution = TaskSolution { q, errors, iterations, restarts };
        if is_found {
            return Ok(solution);
        }
        let first = problem.first();
        let missed = problem.tasks.iter().filter(|rows| Some(rows.task.level) == first);
        let mut missed: Vec<String> = missed
            .filter(|rows| !problem.is_met(rows.error))
            .map(|rows| unreached(&rows.task.objective.description(model), rows.error))
            .collect();
        if missed.is_empty() {
            missed.push("links are nearer than their least distance".to_owned());
        }
        Err(TaskKinematicsError::Unreached {
            robot: model.name().to_owned(),
            unreached: missed,
            limits: self.coordinates_at_limits(&solution.q),
            iterations: solution.iterations,
            restarts: solution.restarts,
            best: Box::new(solution),
        })
    }

    /// The names of the coordinates at a position limit.
    fn coordinates_at_limits(&self, q: &[f64]) -> Vec<String> {
        let names = self.model.borrow().coordinate_names();
        let at_limit =
            self.bounds.0.iter().filter(|bound| q[bound.q] <= bound.lower || q[bound.q] >= bound.upper);
        at_limit.map(|bound| names[bound.v].clone()).collect()
    }
}

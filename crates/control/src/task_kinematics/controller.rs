//! The object that holds the tasks, and its differential steps.

use std::borrow::Borrow;

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, check_configuration, check_vector, integrate};
use robot_dynamics_number::{InvalidInput, check_positive, check_result};
use robot_dynamics_simulation::ContactSet;

use super::avoidance::{Avoidance, CollisionAvoidance};
use super::error::TaskKinematicsError;
use super::levels::{Bounded, Inequalities, LevelError, Levels, StepLaw};
use super::limits::{KinematicLimits, StepBound};
use super::objective::{KinematicObjective, KinematicTask, check_weight};
use super::rows::{Place, TaskRows};
use super::solution::{KinematicLimit, KinematicStep, KinematicTaskId, LinearizedTask, TaskResidual};
use crate::inverse_kinematics::bounds::Bounds;

/// Inverse kinematics of one robot with several tasks: see the [module](super).
#[derive(Clone, Debug)]
pub struct TaskKinematics<M> {
    pub(super) model: M,
    pub(super) workspace: Workspace,
    pub(super) tasks: Vec<TaskRows>,
    limits: KinematicLimits,
    pub(super) bounds: Bounds,
    pub(super) avoidance: Option<Avoidance>,
    damping: f64,
    pub(super) level_numbers: Vec<usize>,
    pub(super) levels: Levels,
    pub(super) scratch: Vec<f64>,
    step_bounds: Vec<StepBound>,
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) inequalities: Inequalities,
    step: KinematicStep,
}

impl<'a> TaskKinematics<&'a Model> {
    /// Without tasks, with the [limits of the robot](KinematicLimits::of).
    pub fn new(model: &'a Model) -> Self {
        Self::owning(model)
    }
}

impl<M: Borrow<Model>> TaskKinematics<M> {
    /// [`new`](TaskKinematics::new) with a robot that the object stores: an `Arc<Model>`, a `Model`, or a
    /// reference.
    pub fn owning(robot: M) -> Self {
        let model: &Model = robot.borrow();
        let nv = model.nv();
        let mut kinematics = Self {
            workspace: Workspace::new(model),
            tasks: Vec::new(),
            bounds: KinematicLimits::of(model).bounds(model),
            limits: KinematicLimits::of(model),
            avoidance: None,
            damping: 0.0,
            level_numbers: Vec::new(),
            levels: Levels::default(),
            scratch: vec![0.0; 12 * nv],
            step_bounds: Vec::with_capacity(nv),
            lower: vec![f64::NEG_INFINITY; nv],
            upper: vec![f64::INFINITY; nv],
            inequalities: Inequalities::default(),
            step: KinematicStep {
                velocity: vec![0.0; nv],
                q: vec![0.0; model.nq()],
                ..KinematicStep::default()
            },
            model: robot,
        };
        kinematics.reserve();
        kinematics
    }

    /// The robot.
    pub fn model(&self) -> &Model {
        self.model.borrow()
    }

    /// Adds a task, or an objective at level 0 with weight 1 and gain 1.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number of the task is invalid.
    ///
    /// # Panics
    /// If a frame or a constraint belongs to another model.
    #[track_caller]
    pub fn add_task(&mut self, task: impl Into<KinematicTask>) -> Result<KinematicTaskId, InvalidInput> {
        let (task, model) = (task.into(), self.model.borrow());
        for frame in task.objective.frames() {
            model.frame_of(frame);
        }
        task.check(model)?;
        self.tasks.push(TaskRows::new(model, task));
        self.reserve();
        Ok(KinematicTaskId(self.tasks.len() - 1))
    }

    /// The objective of a task, to change its target. Another kind of objective needs another task.
    ///
    /// # Panics
    /// If the task belongs to an object with more tasks.
    #[track_caller]
    pub fn objective_mut(&mut self, task: KinematicTaskId) -> &mut KinematicObjective {
        &mut self.tasks[task.0].task.objective
    }

    /// The task.
    ///
    /// # Panics
    /// If the task belongs to an object with more tasks.
    #[track_caller]
    pub fn task(&self, task: KinematicTaskId) -> &KinematicTask {
        &self.tasks[task.0].task
    }

    /// The tasks, in the order in which they were added.
    pub fn tasks(&self) -> impl Iterator<Item = &KinematicTask> {
        self.tasks.iter().map(|rows| &rows.task)
    }

    /// Changes the weight of a task; with zero it has no influence.
    ///
    /// # Errors
    /// [`InvalidInput`] if the weight is negative or not finite.
    ///
    /// # Panics
    /// If the task belongs to an object with more tasks.
    #[track_caller]
    pub fn set_weight(&mut self, task: KinematicTaskId, weight: f64) -> Result<(), InvalidInput> {
        check_weight(weight)?;
        self.tasks[task.0].task.weight = weight;
        Ok(())
    }

    /// λ of ½ λ |Δq|² in every level of a differential step; 0 by default.
    ///
    /// # Errors
    /// [`InvalidInput`] if it is negative or not finite.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), InvalidInput> {
        check_weight(damping).map_err(|error| error.of("the damping"))?;
        self.damping = damping;
        Ok(())
    }

    /// Replaces the limits.
    ///
    /// # Errors
    /// [`InvalidInput`] if a list has the wrong length, or a limit is negative.
    pub fn set_limits(&mut self, limits: KinematicLimits) -> Result<(), InvalidInput> {
        let model = self.model.borrow();
        limits.check(model)?;
        self.bounds = limits.bounds(model);
        self.limits = limits;
        Ok(())
    }

    /// The limits.
    pub fn limits(&self) -> &KinematicLimits {
        &self.limits
    }

    /// Differential steps keep the links apart whose shapes may touch in a set of contacts
    /// ([`ContactSet::with_links`]).
    ///
    /// # Errors
    /// [`InvalidInput`] if a number of the avoidance is invalid.
    ///
    /// # Panics
    /// If the set belongs to another model.
    #[track_caller]
    pub fn avoid_collisions(
        &mut self,
        contacts: ContactSet,
        avoidance: CollisionAvoidance,
    ) -> Result<(), InvalidInput> {
        avoidance.check()?;
        self.avoidance = Some(Avoidance::new(self.model.borrow(), contacts, avoidance));
        self.reserve();
        Ok(())
    }

    /// Memory for all rows.
    fn reserve(&mut self) {
        let nv = self.model.borrow().nv();
        self.level_numbers = self.tasks.iter().map(|rows| rows.task.level).collect();
        self.level_numbers.sort_unstable();
        self.level_numbers.dedup();
        let rows = self.tasks.iter().map(|rows| rows.task.objective.most_rows(nv)).sum();
        let pairs = self.avoidance.as_ref().map_or(0, Avoidance::pair_count);
        self.levels = Levels::new(nv, rows, pairs, self.level_numbers.len());
        self.inequalities.rows.reserve(pairs * nv);
        self.inequalities.lower.reserve(pairs);
        self.step.errors = vec![TaskResidual::default(); self.tasks.len()];
    }

    /// The velocity of the next Δt \[s\] from q, after the velocity v, which the acceleration limits need. It
    /// minimizes
    ///
    /// > ½ Σ w |J Δq + α e|² + ½ (λ + Σ μ w |e|²) |Δq|²,  Δq = v Δt
    ///
    /// over the tasks of each level, within the limits. The working sets of the last call are the first
    /// guess. It does not allocate, except for shapes other than balls and capsules and for constraints of
    /// tendons.
    ///
    /// # Errors
    /// [`TaskKinematicsError`] if an input or a target is invalid, or the limits contradict each other.
    pub fn step(&mut self, q: &[f64], v: &[f64], dt: f64) -> Result<&KinematicStep, TaskKinematicsError> {
        let model: &Model = self.model.borrow();
        check_configuration(model, q)?;
        check_vector(model, "v", v)?;
        check_positive("the step", dt, "s")?;
        self.compute_rows(q)?;
        self.bound_step(q, v, dt);
        self.bound_distances(q);
        let law = StepLaw::differential(self.damping);
        let Self { levels, tasks, level_numbers, lower, upper, inequalities, .. } = &mut *self;
        let bounded = Bounded { lower, upper, inequalities };
        let solved = levels.solve(tasks, level_numbers, bounded, law);
        solved.map_err(|error| self.explained(error))?;
        let Self { levels, tasks, step, model, .. } = &mut *self;
        check_result("v", &levels.x)?;
        for (velocity, x) in step.velocity.iter_mut().zip(&levels.x) {
            *velocity = x / dt;
        }
        integrate((*model).borrow(), q, &levels.x, &mut step.q);
        for (error, rows) in step.errors.iter_mut().zip(tasks) {
            *error = rows.error;
        }
        step.steps = levels.steps;
        Ok(&self.step)
    }

    /// Checks the tasks, whose targets may have changed.
    pub(super) fn check_tasks(&self) -> Result<(), InvalidInput> {
        let model: &Model = self.model.borrow();
        for rows in &self.tasks {
            rows.task.check(model)?;
            if !rows.is_current(model) {
                return Err(InvalidInput::unmet("a task", "must keep its kind and its rows"));
            }
        }
        Ok(())
    }

    /// Errors and Jacobians at q.
    fn compute_rows(&mut self, q: &[f64]) -> Result<(), InvalidInput> {
        self.check_tasks()?;
        let Self { model, workspace, tasks, scratch, .. } = self;
        let mut place = Place { model: (*model).borrow(), workspace, q, scratch };
        for rows in tasks {
            rows.evaluate(&mut place);
            rows.linearize(&mut place);
            check_result("the Jacobian of a task", &rows.jacobian)?;
            check_result("the error of a task", &rows.residual)?;
        }
        Ok(())
    }

    /// The bounds of Δq from the limits.
    fn bound_step(&mut self, q: &[f64], v: &[f64], dt: f64) {
        let Self { bounds, limits, step_bounds, lower, upper, .. } = self;
        bounds.write_room(q, lower, upper);
        step_bounds.clear();
        for (dof, v0) in v.iter().enumerate() {
            let bound = StepBound::new(limits, dof, [lower[dof], upper[dof]], (*v0, dt));
            [lower[dof], upper[dof]] = bound.bounds;
            step_bounds.push(bound);
        }
    }

    /// The rows of the distances between links.
    fn bound_distances(&mut self, q: &[f64]) {
        let Self { model, workspace, avoidance, inequalities, step, lower, upper, .. } = self;
        inequalities.clear();
        step.distance = None;
        if let Some(avoidance) = avoidance {
            let (model, bounds) = ((*model).borrow(), (&lower[..], &upper[..]));
            step.distance = avoidance.write_rows((model, workspace), q, bounds, inequalities);
        }
    }

    /// The limit of a failure.
    fn explained(&self, error: LevelError) -> TaskKinematicsError {
        let limit = match error {
            LevelError::Bound { dof, is_upper } => {
                self.step_bounds[dof].kinds[usize::from(is_upper)].of_dof(dof)
            }
            LevelError::Inequality { row } => {
                match self.avoidance.as_ref().and_then(|avoidance| avoidance.links(row)) {
                    Some(links) => KinematicLimit::Distance { links },
                    None => return error.into(),
                }
            }
            _ => return error.into(),
        };
        TaskKinematicsError::Infeasible { limit }
    }

    /// √w e and √w J of each task at q, for checks and other solvers. It allocates.
    ///
    /// ```
    /// use robot_dynamics::control::task_kinematics::{KinematicObjective, TaskKinematics};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut kinematics = TaskKinematics::new(&model);
    /// kinematics.add_task(KinematicObjective::pose(model.frame_named("tip")?, [0.5, 0.0, 0.0]))?;
    /// let rows = &kinematics.linearized_tasks(&[0.0])?[0];
    /// assert_eq!((rows.residual.norm(), rows.jacobian[(2, 0)]), (0.0, -0.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if q or a target is invalid.
    pub fn linearized_tasks(&mut self, q: &[f64]) -> Result<Vec<LinearizedTask>, InvalidInput> {
        check_configuration(self.model.borrow(), q)?;
        self.compute_rows(q)?;
        let nv = self.model.borrow().nv();
        let of = |rows: &TaskRows| LinearizedTask {
            residual: DVector::from_column_slice(&rows.residual),
            jacobian: DMatrix::from_row_slice(rows.residual.len(), nv, &rows.jacobian),
        };
        Ok(self.tasks.iter().map(of).collect())
    }

    /// The last step.
    pub fn last_step(&self) -> &KinematicStep {
        &self.step
    }
}

//! The controller.

use std::borrow::Borrow;

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::{InvalidInput, check_number, check_result};
use robot_dynamics_simulation::motion::simulate::{check_controller_input, check_torque};
use robot_dynamics_simulation::{Controller, ControllerError};

use super::contact::HeldContact;
use super::error::WholeBodyError;
use super::levels::Levels;
use super::limits::WholeBodyLimits;
use super::objective::Objective;
use super::problem::{ContactSlot, Problem};
use super::program::WholeBodyProgram;
use super::solution::{ContactId, ContactPointForce, TaskId, WholeBodySolution};
use super::task::Task;
use crate::optimal::dense::add_matrix_vector;
use crate::quadratic_program::dot;

/// Whole-body control of one robot: see the [module](super).
#[derive(Clone, Debug)]
pub struct WholeBodyControl<M> {
    model: M,
    workspace: Workspace,
    contacts: Vec<ContactSlot>,
    tasks: Vec<Task>,
    limits: WholeBodyLimits,
    with_dissipation: bool,
    problem: Problem,
    levels: Levels,
    level_numbers: Vec<usize>,
    error: Vec<f64>,
    solution: WholeBodySolution,
}

impl<'a> WholeBodyControl<&'a Model> {
    /// A controller without contacts and tasks, with the [limits of the robot](WholeBodyLimits::of).
    pub fn new(model: &'a Model) -> Self {
        Self::owning(model)
    }
}

impl<M: Borrow<Model>> WholeBodyControl<M> {
    /// [`new`](WholeBodyControl::new) with a robot that the controller stores: an `Arc<Model>`, a `Model`, or
    /// a reference.
    pub fn owning(robot: M) -> Self {
        let model: &Model = robot.borrow();
        let mut control = Self {
            workspace: Workspace::new(model),
            contacts: Vec::new(),
            tasks: Vec::new(),
            limits: WholeBodyLimits::of(model),
            with_dissipation: false,
            problem: Problem::new(model),
            levels: Levels::default(),
            level_numbers: Vec::new(),
            error: vec![0.0; model.nv()],
            solution: WholeBodySolution::default(),
            model: robot,
        };
        control.reserve();
        control
    }

    /// Compensates the joints' damping and friction.
    #[must_use]
    pub fn with_dissipation(mut self) -> Self {
        self.with_dissipation = true;
        self
    }

    /// Replaces the limits.
    ///
    /// # Errors
    /// [`InvalidInput`] if a list has the wrong length, or a limit is negative.
    pub fn set_limits(&mut self, limits: WholeBodyLimits) -> Result<(), InvalidInput> {
        limits.check(self.model.borrow())?;
        self.limits = limits;
        Ok(())
    }

    /// The limits.
    pub fn limits(&self) -> &WholeBodyLimits {
        &self.limits
    }

    /// Adds a contact, which is held.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number of its geometry is not finite.
    ///
    /// # Panics
    /// If the frame belongs to another model.
    #[track_caller]
    pub fn add_contact(&mut self, contact: HeldContact) -> Result<ContactId, InvalidInput> {
        self.model.borrow().frame_of(contact.frame);
        contact.check()?;
        self.contacts.push(ContactSlot { contact, is_active: true });
        self.reserve();
        Ok(ContactId(self.contacts.len() - 1))
    }

    /// Holds a contact, or releases it: a released contact has no force and moves freely. It does not
    /// allocate.
    ///
    /// # Panics
    /// If the contact belongs to a controller with more contacts.
    #[track_caller]
    pub fn hold_contact(&mut self, contact: ContactId, is_held: bool) {
        let slot = &mut self.contacts[contact.0];
        if slot.is_active != is_held {
            slot.is_active = is_held;
            self.levels.clear_guesses();
        }
    }

    /// Adds a task with a weight to level 0.
    ///
    /// # Errors
    /// [`InvalidInput`] if the weight is negative or not finite.
    ///
    /// # Panics
    /// If a frame belongs to another model.
    #[track_caller]
    pub fn add_task(&mut self, objective: Objective, weight: f64) -> Result<TaskId, InvalidInput> {
        self.add_task_at(0, objective, weight)
    }

    /// Adds a task to a level. A task does not change the errors of tasks at levels with smaller numbers.
    ///
    /// # Errors
    /// As [`add_task`](Self::add_task).
    ///
    /// # Panics
    /// As [`add_task`](Self::add_task).
    #[track_caller]
    pub fn add_task_at(
        &mut self,
        level: usize,
        objective: Objective,
        weight: f64,
    ) -> Result<TaskId, InvalidInput> {
        check_weight(weight)?;
        if let Some(frame) = objective.frame() {
            self.model.borrow().frame_of(frame);
        }
        self.tasks.push(Task { objective, weight, level });
        self.reserve();
        Ok(TaskId(self.tasks.len() - 1))
    }

    /// The objective of a task, to change its reference or its gains. Another kind of objective, or one with
    /// more rows, makes the next solution allocate.
    ///
    /// # Panics
    /// If the task belongs to a controller with more tasks.
    #[track_caller]
    pub fn objective_mut(&mut self, task: TaskId) -> &mut Objective {
        &mut self.tasks[task.0].objective
    }

    /// Changes the weight of a task; with zero it has no influence.
    ///
    /// # Errors
    /// [`InvalidInput`] if the weight is negative or not finite.
    ///
    /// # Panics
    /// If the task belongs to a controller with more tasks.
    #[track_caller]
    pub fn set_weight(&mut self, task: TaskId, weight: f64) -> Result<(), InvalidInput> {
        check_weight(weight)?;
        self.tasks[task.0].weight = weight;
        Ok(())
    }

    /// The last solution.
    pub fn solution(&self) -> &WholeBodySolution {
        &self.solution
    }

    /// The quadratic program of the last call of [`solve`](Self::solve), for checks and other solvers. It
    /// allocates.
    pub fn program(&self) -> WholeBodyProgram {
        WholeBodyProgram::of(&self.problem)
    }

    /// Reserves the memory of all parts.
    fn reserve(&mut self) {
        let model: &Model = self.model.borrow();
        let nv = model.nv();
        self.problem.reserve(model, &self.contacts, &self.tasks);
        let Problem { dynamics, equations, bounded, tasks, points, .. } = &self.problem;
        let columns = nv + 3 * points.capacity();
        debug_assert!(dynamics.data.capacity() >= nv * columns, "D has memory");
        let rows = |matrix: &super::matrix::Matrix| matrix.data.capacity() / columns.max(1);
        self.level_numbers = self.tasks.iter().map(|task| task.level).collect();
        self.level_numbers.sort_unstable();
        self.level_numbers.dedup();
        let levels = self.level_numbers.len();
        self.levels = Levels::new(columns, rows(equations), rows(bounded), rows(tasks), levels);
        let solution = &mut self.solution;
        solution.torque.resize(nv, 0.0);
        solution.acceleration.resize(nv, 0.0);
        solution.task_errors.resize(self.tasks.len(), 0.0);
        solution.forces = Vec::with_capacity(points.capacity());
        solution.active_limits = Vec::with_capacity(columns);
    }

    /// Torques, accelerations and forces at a state. The working sets of the last call are the first guess.
    /// It does not allocate.
    ///
    /// # Errors
    /// [`WholeBodyError`] if the state or a reference is invalid, or no motion satisfies the dynamics, the
    /// contacts and the limits. The last solution is then unspecified.
    pub fn solve(&mut self, q: &[f64], v: &[f64]) -> Result<&WholeBodySolution, WholeBodyError> {
        let model: &Model = self.model.borrow();
        check_controller_input(model, 0.0, q, v)?;
        let Self { workspace, problem, levels, contacts, tasks, limits, error, .. } = self;
        problem.assemble((model, workspace), (q, v), contacts, limits, self.with_dissipation);
        problem.assemble_tasks((model, workspace), (q, v), tasks, error)?;
        check_result("M", &problem.dynamics.data)?;
        check_result("C v + g", &problem.bias)?;
        levels.solve(problem, &self.level_numbers)?;
        self.write_solution()?;
        Ok(&self.solution)
    }

    fn write_solution(&mut self) -> Result<(), WholeBodyError> {
        let model: &Model = self.model.borrow();
        let Self { problem, solution, levels, .. } = self;
        let (nv, x) = (model.nv(), &levels.x);
        check_result("q̈", x)?;
        solution.acceleration.copy_from_slice(&x[..nv]);
        solution.torque.copy_from_slice(&problem.bias);
        add_matrix_vector(&problem.dynamics.data, x, &mut solution.torque);
        for (tau, is_actuated) in solution.torque.iter_mut().zip(model.actuated_dofs()) {
            if !is_actuated {
                *tau = 0.0;
            }
        }
        solution.forces.clear();
        for (point, f) in problem.points.iter().zip(x[nv..].chunks_exact(3)) {
            solution.forces.push(ContactPointForce {
                contact: point.contact,
                point: point.point,
                position: point.position,
                force: core::array::from_fn(|k| (0..3).map(|j| point.basis[j][k] * f[j]).sum()),
            });
        }
        solution.active_limits.clear();
        solution.active_limits.extend(levels.active_limits(problem));
        for (error, rows) in solution.task_errors.iter_mut().zip(&problem.task_rows) {
            let squares = (rows.first..rows.first + rows.count).map(|row| {
                let residual = dot(problem.tasks.row(row), x) - problem.task_values[row];
                residual * residual
            });
            *error = squares.sum::<f64>().sqrt();
        }
        solution.steps = levels.steps;
        Ok(check_torque(&solution.torque)?)
    }
}

fn check_weight(weight: f64) -> Result<(), InvalidInput> {
    check_number("the weight", weight)?;
    if weight < 0.0 {
        return Err(InvalidInput::out_of_range("the weight", weight, "", "zero or positive"));
    }
    Ok(())
}

impl<M: Borrow<Model>> Controller for WholeBodyControl<M> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        check_number("t", t)?;
        tau.copy_from_slice(&self.solve(q, v)?.torque);
        Ok(())
    }
}

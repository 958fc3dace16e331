//! The equations, limits and tasks of a state, as dense rows over x = (q̈, f).

use robot_dynamics_core::{
    Model, ReferenceFrame, bias, dissipation, frame_bias_acceleration, frame_jacobian, frame_pose,
    frame_velocity, mass_matrix,
};
use robot_dynamics_simulation::ControllerError;

use super::contact::{ContactGeometry, HeldContact, cross};
use super::limits::WholeBodyLimits;
use super::matrix::Matrix;
use super::solution::{ContactId, Limit};
use super::state::State;
use super::task::Task;

/// A contact, and whether it is held.
#[derive(Clone, Debug)]
pub(super) struct ContactSlot {
    pub(super) contact: HeldContact,
    pub(super) is_active: bool,
}

/// A point with a force: three columns after those of q̈, along t₁, t₂ and n.
#[derive(Clone, Copy, Debug)]
pub(super) struct ForcePoint {
    pub(super) contact: ContactId,
    pub(super) point: usize,
    pub(super) position: [f64; 3],
    pub(super) basis: [[f64; 3]; 3],
}

/// The rows of a task.
#[derive(Clone, Copy, Debug)]
pub(super) struct TaskRows {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) weight: f64,
    pub(super) level: usize,
}

/// E x = e, l ≤ C x ≤ u, and the rows A x − b of the tasks.
#[derive(Clone, Debug, Default)]
pub(super) struct Problem {
    /// D and h with τ = D x + h.
    pub(super) dynamics: Matrix,
    pub(super) bias: Vec<f64>,
    pub(super) equations: Matrix,
    pub(super) equation_values: Vec<f64>,
    pub(super) bounded: Matrix,
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
    pub(super) limits: Vec<Limit>,
    pub(super) tasks: Matrix,
    pub(super) task_values: Vec<f64>,
    pub(super) task_rows: Vec<TaskRows>,
    pub(super) points: Vec<ForcePoint>,
    mass: Vec<f64>,
    jacobian: Vec<f64>,
    /// The index in q of degrees of freedom with a coordinate of their own.
    coordinates: Vec<Option<usize>>,
}

impl Problem {
    pub(super) fn new(model: &Model) -> Self {
        let nv = model.nv();
        let mut coordinates = vec![None; nv];
        for joint in model.joints().iter().filter(|joint| (joint.nq, joint.nv) == (1, 1)) {
            coordinates[joint.v_index] = Some(joint.q_index);
        }
        Self {
            bias: vec![0.0; nv],
            mass: vec![0.0; nv * nv],
            jacobian: vec![0.0; 6 * nv],
            coordinates,
            ..Self::default()
        }
    }

    /// Reserves memory, so that [`assemble`](Self::assemble) does not allocate.
    pub(super) fn reserve(&mut self, model: &Model, contacts: &[ContactSlot], tasks: &[Task]) {
        let nv = model.nv();
        let points: usize = contacts.iter().map(|slot| slot.contact.points()).sum();
        let motion: usize = contacts.iter().map(|slot| slot.contact.motion_rows()).sum();
        let sides: usize = contacts.iter().map(|slot| slot.contact.points() * (slot.contact.sides + 1)).sum();
        let columns = nv + 3 * points;
        let rows: usize = tasks.iter().map(|task| task.objective.most_rows(nv).max(3 * points)).sum();
        self.dynamics = Matrix::with_capacity(nv, columns);
        self.equations = Matrix::with_capacity(nv + motion, columns);
        self.bounded = Matrix::with_capacity(2 * nv + sides, columns);
        self.tasks = Matrix::with_capacity(rows, columns);
        self.equation_values = Vec::with_capacity(nv + motion);
        self.lower = Vec::with_capacity(2 * nv + sides);
        self.upper = Vec::with_capacity(2 * nv + sides);
        self.limits = Vec::with_capacity(2 * nv + sides);
        self.task_values = Vec::with_capacity(rows);
        self.task_rows = Vec::with_capacity(tasks.len());
        self.points = Vec::with_capacity(points);
    }

    /// The number of variables.
    pub(super) fn variables(&self) -> usize {
        self.dynamics.columns
    }

    /// Computes everything but the tasks.
    pub(super) fn assemble(
        &mut self,
        state: (&Model, &mut robot_dynamics_core::Workspace),
        (q, v): (&[f64], &[f64]),
        contacts: &[ContactSlot],
        limits: &WholeBodyLimits,
        with_dissipation: bool,
    ) {
        let (model, workspace) = state;
        let nv = model.nv();
        let active = || contacts.iter().enumerate().filter(|(_, slot)| slot.is_active);
        let columns = nv + 3 * active().map(|(_, slot)| slot.contact.points()).sum::<usize>();
        self.dynamics.reset(nv, columns);
        self.equations.reset(0, columns);
        self.equation_values.clear();
        self.points.clear();
        bias(model, workspace, q, v, &mut self.bias);
        if with_dissipation {
            dissipation(model, v, &mut self.jacobian[..nv]);
            self.bias.iter_mut().zip(&self.jacobian).for_each(|(h, b)| *h += b);
        }
        mass_matrix(model, workspace, q, &mut self.mass);
        for (row, mass) in self.mass.chunks_exact(nv.max(1)).enumerate() {
            self.dynamics.row_mut(row)[..nv].copy_from_slice(mass);
        }
        for (index, slot) in active() {
            self.add_contact((model, &mut *workspace), (q, v), (ContactId(index), &slot.contact));
        }
        for i in (0..nv).filter(|i| !model.actuated_dofs()[*i]) {
            let Self { equations, dynamics, .. } = self;
            equations.push_row().copy_from_slice(dynamics.row(i));
            self.equation_values.push(-self.bias[i]);
        }
        self.write_limits(model, (q, v), contacts, limits);
    }

    /// Writes −Jᵀ of the points of a contact to D, and its motion to the equations.
    fn add_contact(
        &mut self,
        (model, workspace): (&Model, &mut robot_dynamics_core::Workspace),
        (q, v): (&[f64], &[f64]),
        (id, contact): (ContactId, &HeldContact),
    ) {
        let (nv, aligned, frame) = (model.nv(), ReferenceFrame::LocalWorldAligned, contact.frame);
        let pose = frame_pose(model, workspace, q, frame);
        let velocity = frame_velocity(model, workspace, q, v, frame, aligned);
        let rate = frame_bias_acceleration(model, workspace, q, v, frame, aligned);
        frame_jacobian(model, workspace, q, frame, aligned, &mut self.jacobian);
        let basis = contact.basis();
        let along = |offset: &[f64; 3]| {
            core::array::from_fn(|i| (0..3).map(|j| pose.rotation[i][j] * offset[j]).sum::<f64>())
        };
        let first = self.points.len();
        let mut add = |point: usize, arm: [f64; 3]| {
            let position = core::array::from_fn(|k| pose.translation[k] + arm[k]);
            let column = nv + 3 * self.points.len();
            self.points.push(ForcePoint { contact: id, point, position, basis });
            for (k, t) in basis.iter().enumerate() {
                // tᵀ(J_linear − [arm]ₓ J_angular) = (t, arm × t) J.
                let moment = cross(arm, *t);
                for i in 0..nv {
                    let entry: f64 = (0..3)
                        .map(|a| {
                            t[a] * self.jacobian[a * nv + i] + moment[a] * self.jacobian[(3 + a) * nv + i]
                        })
                        .sum();
                    self.dynamics.row_mut(i)[column + k] = -entry;
                }
            }
        };
        let (spin, fall) = (velocity.angular, rate.angular);
        let moving = |arm: [f64; 3], centripetal: [f64; 3]| {
            let (swept, turned) = (cross(spin, arm), cross(fall, arm));
            core::array::from_fn(|k| {
                let speed = velocity.linear[k] + swept[k];
                -contact.damping * speed - (rate.linear[k] + turned[k] + centripetal[k])
            })
        };
        match &contact.geometry {
            ContactGeometry::Point(offset) => {
                let arm = along(offset);
                add(0, arm);
                let value: [f64; 3] = moving(arm, cross(spin, cross(spin, arm)));
                self.hold_point(nv, first, value);
            }
            ContactGeometry::Ball(radius) => {
                let arm = contact.normal.map(|n| -radius * n);
                add(0, arm);
                let value = moving(arm, [0.0; 3]);
                self.hold_point(nv, first, value);
            }
            ContactGeometry::Face(corners) => {
                corners.iter().enumerate().for_each(|(point, corner)| add(point, along(corner)));
                let linear: [f64; 3] = moving([0.0; 3], [0.0; 3]);
                for k in 0..6 {
                    let row = &self.jacobian[k * nv..(k + 1) * nv];
                    self.equations.push_row()[..nv].copy_from_slice(row);
                    let turn = |k: usize| -contact.damping * spin[k] - fall[k];
                    self.equation_values.push(if k < 3 { linear[k] } else { turn(k - 3) });
                }
            }
        }
    }

    /// The motion of a point along its basis; its Jacobian is in D.
    fn hold_point(&mut self, nv: usize, point: usize, value: [f64; 3]) {
        for (k, t) in self.points[point].basis.iter().enumerate() {
            let row = self.equations.push_row();
            for i in 0..nv {
                row[i] = -self.dynamics.row(i)[nv + 3 * point + k];
            }
            self.equation_values.push((0..3).map(|a| t[a] * value[a]).sum());
        }
    }

    fn push_limit(&mut self, limit: Limit, [lower, upper]: [f64; 2]) -> &mut [f64] {
        self.limits.push(limit);
        self.lower.push(lower);
        self.upper.push(upper);
        self.bounded.push_row()
    }

    fn write_limits(
        &mut self,
        model: &Model,
        (q, v): (&[f64], &[f64]),
        contacts: &[ContactSlot],
        limits: &WholeBodyLimits,
    ) {
        let nv = model.nv();
        self.bounded.reset(0, self.dynamics.columns);
        self.limits.clear();
        self.lower.clear();
        self.upper.clear();
        for dof in 0..nv {
            let most = limits.torque[dof];
            if model.actuated_dofs()[dof] && most.is_finite() {
                let h = self.bias[dof];
                self.push_limit(Limit::Torque { dof }, [-most - h, most - h]);
                let Self { bounded, dynamics, .. } = self;
                bounded.row_mut(bounded.rows - 1).copy_from_slice(dynamics.row(dof));
            }
        }
        for dof in 0..nv {
            let own = self.coordinates[dof].map(|index| q[index]);
            let bounds = limits.acceleration_bounds(dof, own, v[dof]);
            if bounds.iter().any(|bound| bound.is_finite()) {
                self.push_limit(Limit::Acceleration { dof }, bounds)[dof] = 1.0;
            }
        }
        for index in 0..self.points.len() {
            let ForcePoint { contact: id, point, .. } = self.points[index];
            let contact = &contacts[id.0].contact;
            let column = nv + 3 * index;
            let limit = Limit::NormalForce { contact: id, point };
            self.push_limit(limit, contact.normal_force)[column + 2] = 1.0;
            let slope = contact.friction * (core::f64::consts::PI / contact.sides as f64).cos();
            for side in 0..contact.sides {
                let (sin, cos) = (core::f64::consts::TAU * side as f64 / contact.sides as f64).sin_cos();
                let limit = Limit::Friction { contact: id, point, side };
                let row = self.push_limit(limit, [f64::NEG_INFINITY, 0.0]);
                row[column..column + 3].copy_from_slice(&[cos, sin, -slope]);
            }
        }
    }

    /// Computes the rows of the tasks with a weight.
    pub(super) fn assemble_tasks(
        &mut self,
        (model, workspace): (&Model, &mut robot_dynamics_core::Workspace),
        (q, v): (&[f64], &[f64]),
        tasks: &[Task],
        error: &mut Vec<f64>,
    ) -> Result<(), ControllerError> {
        let columns = self.dynamics.columns;
        self.tasks.reset(0, columns);
        self.task_values.clear();
        self.task_rows.clear();
        let Self { dynamics, bias, jacobian, tasks: rows, task_values, .. } = self;
        let mut state = State { model, workspace, q, v, dynamics, bias, jacobian, error };
        for task in tasks {
            let first = rows.rows;
            if task.weight > 0.0 {
                task.objective.write(&mut state, rows, task_values)?;
            }
            let (count, weight, level) = (rows.rows - first, task.weight, task.level);
            self.task_rows.push(TaskRows { first, count, weight, level });
        }
        Ok(())
    }
}

//! The errors of tasks, and their Jacobians.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Workspace, center_of_mass, center_of_mass_jacobian, difference,
    frame_jacobian, frame_pose,
};
use robot_dynamics_description::Pose;
use robot_dynamics_simulation::constraints::PositionRows;

use super::objective::{KinematicObjective, KinematicTask};
use super::solution::TaskResidual;
use crate::optimal::each_quaternion_block;
use crate::quadratic_program::dot;

/// A task, and its last error and Jacobian.
#[derive(Clone, Debug)]
pub(super) struct TaskRows {
    pub(super) task: KinematicTask,
    /// The most rows of its kind.
    most_rows: usize,
    constraints: Option<PositionRows>,
    /// √w e, and √w J; rows of weight zero are left out.
    pub(super) residual: Vec<f64>,
    pub(super) jacobian: Vec<f64>,
    /// The residual from which steps of a search start.
    kept: Vec<f64>,
    /// The errors without weights.
    pub(super) error: TaskResidual,
}

/// The robot, its configuration, and scratch of 12 nv numbers.
pub(super) struct Place<'a> {
    pub(super) model: &'a Model,
    pub(super) workspace: &'a mut Workspace,
    pub(super) q: &'a [f64],
    pub(super) scratch: &'a mut [f64],
}

impl TaskRows {
    pub(super) fn new(model: &Model, task: KinematicTask) -> Self {
        let rows = task.objective.most_rows(model.nv());
        let constraints = match &task.objective {
            KinematicObjective::Constraints(set) => Some(PositionRows::new(model, set)),
            _ => None,
        };
        Self {
            task,
            most_rows: rows,
            constraints,
            residual: Vec::with_capacity(rows),
            jacobian: Vec::with_capacity(rows * model.nv()),
            kept: Vec::with_capacity(rows),
            error: TaskResidual::default(),
        }
    }

    /// Whether the memory fits the task, whose objective may have changed.
    pub(super) fn is_current(&self, model: &Model) -> bool {
        self.most_rows >= self.task.objective.most_rows(model.nv())
            && self.constraints.is_some() == matches!(self.task.objective, KinematicObjective::Constraints(_))
    }

    /// √w |e|, squared.
    pub(super) fn squared(&self) -> f64 {
        self.residual.iter().map(|e| e * e).sum()
    }

    /// Keeps the residual.
    pub(super) fn keep(&mut self) {
        self.kept.clone_from(&self.residual);
    }

    /// Restores the residual that was kept.
    pub(super) fn restore(&mut self) {
        self.residual.clone_from(&self.kept);
    }

    /// |√w (e + J δ)|².
    pub(super) fn promised(&self, step: &[f64]) -> f64 {
        let rows = self.residual.iter().zip(self.jacobian.chunks_exact(step.len().max(1)));
        rows.map(|(e, row)| (e + dot(row, step)).powi(2)).sum()
    }

    /// Computes √w e.
    pub(super) fn evaluate(&mut self, place: &mut Place<'_>) {
        self.residual.clear();
        self.error = TaskResidual::default();
        let Place { model, workspace, q, scratch } = place;
        let weight = self.task.weight;
        match &self.task.objective {
            KinematicObjective::Pose { frame, reference, target, weights } => {
                let relative = relative_pose(place, *frame, *reference, target);
                let linear = relative.translation;
                let turns = weights[3..].iter().any(|w| *w > 0.0);
                let angular = if turns { rotation_of(&relative).log().1 } else { [0.0; 3] };
                let e = [linear, angular];
                push(&mut self.residual, weight, weights, e.as_flattened());
                self.error.position = norm(masked(linear, &weights[..3]));
                self.error.angle = norm(masked(angular, &weights[3..]));
            }
            KinematicObjective::CenterOfMass { target, weights } => {
                let c = center_of_mass(model, workspace, q);
                let e: [f64; 3] = core::array::from_fn(|k| c[k] - target[k]);
                push(&mut self.residual, weight, weights, &e);
                self.error.position = norm(masked(e, weights));
            }
            KinematicObjective::Posture { target } => {
                let nv = model.nv();
                difference(model, target, q, &mut scratch[..nv]);
                for (e, _) in scratch.iter().zip(model.actuated_dofs()).filter(|(_, moves)| **moves) {
                    self.residual.push(weight.sqrt() * e);
                    self.error.angle = self.error.angle.max(e.abs());
                }
            }
            KinematicObjective::LookAt { frame, axis, point } => {
                let (a, d, _) = axis_and_direction(place, *frame, axis, point);
                let e: [f64; 3] = (a - d).into();
                push(&mut self.residual, weight, &[1.0; 3], &e);
                self.error.angle = 2.0 * (0.5 * norm(e)).min(1.0).asin();
            }
            KinematicObjective::Constraints(_) => {
                let Self { constraints, residual, error, .. } = self;
                let Some(rows) = constraints else { return };
                rows.place(model, workspace, q);
                rows.each(|phi, _| {
                    residual.push(weight.sqrt() * phi);
                    error.position = error.position.max(phi.abs());
                });
            }
        }
    }

    /// Computes √w J at the q of the last [`evaluate`](Self::evaluate).
    pub(super) fn linearize(&mut self, place: &mut Place<'_>) {
        let nv = place.model.nv();
        self.jacobian.clear();
        self.jacobian.resize(self.residual.len() * nv, 0.0);
        let weight = self.task.weight;
        match &self.task.objective {
            KinematicObjective::Pose { frame, reference, target, weights } => {
                write_pose(place, (*frame, *reference), target, (weight, weights), &mut self.jacobian);
            }
            KinematicObjective::CenterOfMass { weights, .. } => {
                let Place { model, workspace, q, scratch } = place;
                center_of_mass_jacobian(model, workspace, q, &mut scratch[..3 * nv]);
                let rows = weights.iter().zip(scratch.chunks_exact(nv.max(1))).filter(|(w, _)| **w > 0.0);
                for (to, (w, from)) in self.jacobian.chunks_exact_mut(nv.max(1)).zip(rows) {
                    let scale = (weight * w).sqrt();
                    to.iter_mut().zip(from).for_each(|(to, from)| *to = scale * from);
                }
            }
            KinematicObjective::Posture { target } => {
                write_posture(place, target, weight, &mut self.jacobian);
            }
            KinematicObjective::LookAt { frame, axis, point } => {
                write_look_at(place, *frame, (axis, point), weight, &mut self.jacobian);
            }
            KinematicObjective::Constraints(_) => {
                let Self { constraints, jacobian, .. } = self;
                let Some(rows) = constraints else { return };
                let mut to = jacobian.chunks_exact_mut(nv.max(1));
                rows.each(|_, terms| {
                    let row = to.next().unwrap_or_default();
                    for &(k, factor) in terms {
                        row[k] = weight.sqrt() * factor;
                    }
                });
            }
        }
    }
}

/// Appends √w e of the rows that have a weight.
fn push(residual: &mut Vec<f64>, weight: f64, weights: &[f64], e: &[f64]) {
    let rows = weights.iter().zip(e).filter(|(w, _)| **w > 0.0);
    residual.extend(rows.map(|(w, e)| (weight * w).sqrt() * e));
}

/// The entries of rows that have a weight.
fn masked(e: [f64; 3], weights: &[f64]) -> [f64; 3] {
    core::array::from_fn(|k| if weights[k] > 0.0 { e[k] } else { 0.0 })
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The rotation alone.
fn rotation_of(pose: &Pose) -> Pose {
    Pose { translation: [0.0; 3], ..*pose }
}

/// `target_from_frame`.
fn relative_pose(place: &mut Place<'_>, frame: FrameId, reference: Option<FrameId>, target: &Pose) -> Pose {
    let Place { model, workspace, q, .. } = place;
    let target = match reference {
        Some(reference) => frame_pose(model, workspace, q, reference).compose(target),
        None => *target,
    };
    target.inverse().compose(&frame_pose(model, workspace, q, frame))
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The rows R_gᵀ(ṗ − ṗ_r − ω_r × (p − p_r)) and D R_fᵀ(ω − ω_r): the rates of the error, where g is the
/// target, f the frame, r the reference, and D the derivative of the logarithm.
fn write_pose(
    place: &mut Place<'_>,
    (frame, reference): (FrameId, Option<FrameId>),
    target: &Pose,
    (weight, weights): (f64, &[f64; 6]),
    rows: &mut [f64],
) {
    let nv = place.model.nv();
    let aligned = ReferenceFrame::LocalWorldAligned;
    let Place { model, workspace, q, scratch } = place;
    let pose = frame_pose(model, workspace, q, frame);
    let (own, base) = scratch.split_at_mut(6 * nv);
    frame_jacobian(model, workspace, q, frame, aligned, own);
    let mut goal = *target;
    if let Some(reference) = reference {
        let carrier = frame_pose(model, workspace, q, reference);
        goal = carrier.compose(target);
        frame_jacobian(model, workspace, q, reference, aligned, base);
        let lever = Vector3::from(pose.translation) - Vector3::from(carrier.translation);
        for k in 0..nv {
            let spin = Vector3::new(base[3 * nv + k], base[4 * nv + k], base[5 * nv + k]);
            let carried = spin.cross(&lever);
            for i in 0..3 {
                own[i * nv + k] -= base[i * nv + k] + carried[i];
                own[(i + 3) * nv + k] -= spin[i];
            }
        }
    }
    let by_linear = matrix(&goal.rotation).transpose();
    let mut by_angular = Matrix3::zeros();
    if weights[3..].iter().any(|w| *w > 0.0) {
        let derivative = rotation_of(&goal.inverse().compose(&pose)).log_derivative();
        let derivative = Matrix3::from_fn(|i, j| derivative[i + 3][j + 3]);
        by_angular = derivative * matrix(&pose.rotation).transpose();
    }
    let kept = weights.iter().enumerate().filter(|(_, w)| **w > 0.0);
    for (to, (row, w)) in rows.chunks_exact_mut(nv.max(1)).zip(kept) {
        let scale = (weight * w).sqrt();
        let (by, first) = if row < 3 { (by_linear.row(row), 0) } else { (by_angular.row(row - 3), 3) };
        for i in 0..3 {
            let factor = scale * by[i];
            let from = &own[(first + i) * nv..(first + i + 1) * nv];
            to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
        }
    }
}

/// The derivative of q ⊖ q\*: the identity, and that of the logarithm for joints with a quaternion.
fn write_posture(place: &mut Place<'_>, target: &[f64], weight: f64, rows: &mut [f64]) {
    let (model, scale) = (place.model, weight.sqrt());
    let (nv, actuated) = (model.nv(), model.actuated_dofs());
    let moving = (0..nv).filter(|k| actuated[*k]);
    for (row, k) in rows.chunks_exact_mut(nv.max(1)).zip(moving) {
        row[k] = scale;
    }
    each_quaternion_block(model, [target, place.q], |first, size, block| {
        let before = actuated[..first].iter().filter(|moves| **moves).count();
        if actuated[first] {
            for row in 0..size {
                let to = &mut rows[(before + row) * nv + first..][..size];
                let own = &block[row + 6 - size][6 - size..];
                to.iter_mut().zip(own).for_each(|(to, own)| *to = scale * own);
            }
        }
    });
}

/// The axis and the direction in the world, and the distance of the point.
fn axis_and_direction(
    place: &mut Place<'_>,
    frame: FrameId,
    axis: &[f64; 3],
    point: &[f64; 3],
) -> (Vector3<f64>, Vector3<f64>, f64) {
    let pose = frame_pose(place.model, place.workspace, place.q, frame);
    let away = Vector3::from(*point) - Vector3::from(pose.translation);
    let distance = away.norm();
    // At the point itself every direction is right.
    let own = Vector3::from(pose.rotate(*axis));
    (own, if distance > 0.0 { away / distance } else { own }, distance)
}

/// The rows of ȧ − ḋ = ω × a + (1 − d dᵀ) ṗ / |x − p|.
fn write_look_at(
    place: &mut Place<'_>,
    frame: FrameId,
    (axis, point): (&[f64; 3], &[f64; 3]),
    weight: f64,
    rows: &mut [f64],
) {
    let (a, d, distance) = axis_and_direction(place, frame, axis, point);
    let Place { model, workspace, q, scratch } = place;
    let (nv, scale) = (model.nv(), weight.sqrt());
    let jacobian = &mut scratch[..6 * nv];
    frame_jacobian(model, workspace, q, frame, ReferenceFrame::LocalWorldAligned, jacobian);
    let inverse = if distance > 0.0 { 1.0 / distance } else { 0.0 };
    for k in 0..nv {
        let column = |first: usize| Vector3::from_fn(|i, _| jacobian[(first + i) * nv + k]);
        let (velocity, spin) = (column(0), column(3));
        let rate = spin.cross(&a) + (velocity - d * d.dot(&velocity)) * inverse;
        for i in 0..3 {
            rows[i * nv + k] = scale * rate[i];
        }
    }
}

//! The error of one frame, and its steps.

use nalgebra::{Matrix6, Vector6};
use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian, frame_pose};
use robot_dynamics_description::Pose;

use super::bounds::Bounds;
use super::damped_step::DampedStep;
use super::iteration::{Evaluation, LeastSquares};
use super::{FrameTarget, InverseKinematicsOptions};

/// The least λ, relative to the trace of JₑJₑᵀ, with which JₑJₑᵀ + λ 1 can be factored in any pose.
const ROUNDING: f64 = 1e-14;

/// e at a configuration, and the two distances.
#[derive(Clone, Copy)]
pub(super) struct FrameError {
    e: Vector6<f64>,
    pub position: f64,
    pub angle: f64,
    /// `target_from_frame`.
    relative: Pose,
}

/// The error of a frame as a least-squares problem.
pub(super) struct FrameProblem<'a> {
    model: &'a Model,
    frame: FrameId,
    target: &'a FrameTarget,
    options: &'a InverseKinematicsOptions,
    bounds: &'a Bounds,
    damped: DampedStep,
    jacobian: Vec<f64>,
    current: FrameError,
    last: FrameError,
}

impl<'a> FrameProblem<'a> {
    pub(super) fn new(
        model: &'a Model,
        (frame, target): (FrameId, &'a FrameTarget),
        options: &'a InverseKinematicsOptions,
        bounds: &'a Bounds,
    ) -> Self {
        let nv = model.nv();
        let none = FrameError { e: Vector6::zeros(), position: 0.0, angle: 0.0, relative: Pose::IDENTITY };
        Self {
            model,
            frame,
            target,
            options,
            bounds,
            damped: DampedStep::new(nv),
            jacobian: vec![0.0; 6 * nv],
            current: none,
            last: none,
        }
    }

    /// e: log(T\*⁻¹T), or p − p\* with zeros.
    pub(super) fn error(&self, workspace: &mut Workspace, q: &[f64]) -> FrameError {
        let pose = frame_pose(self.model, workspace, q, self.frame);
        match self.target {
            FrameTarget::Pose(target) => {
                let relative = target.inverse().compose(&pose);
                let ([x, y, z], [a, b, c]) = relative.log();
                let angle = norm([a, b, c]);
                let position = norm(relative.translation);
                FrameError { e: Vector6::new(x, y, z, a, b, c), position, angle, relative }
            }
            FrameTarget::Position(target) => {
                let [x, y, z]: [f64; 3] = core::array::from_fn(|k| pose.translation[k] - target[k]);
                let e = Vector6::new(x, y, z, 0.0, 0.0, 0.0);
                FrameError { e, position: norm([x, y, z]), angle: 0.0, relative: Pose::IDENTITY }
            }
        }
    }
}

impl LeastSquares for FrameProblem<'_> {
    fn evaluate(&mut self, workspace: &mut Workspace, q: &[f64]) -> Evaluation {
        self.last = self.error(workspace, q);
        let FrameError { e, position, angle, .. } = &self.last;
        let is_found = *position <= self.options.position_tolerance && *angle <= self.options.angle_tolerance;
        Evaluation { squared: e.norm_squared(), is_found }
    }

    fn accept(&mut self) {
        self.current = self.last;
    }

    /// Jₑ and the distances of each coordinate from its limits at q.
    fn linearize(&mut self, workspace: &mut Workspace, q: &[f64]) {
        let (nv, rows) = (self.model.nv(), &mut self.jacobian);
        let by_twist = match self.target {
            FrameTarget::Pose(_) => {
                frame_jacobian(self.model, workspace, q, self.frame, ReferenceFrame::Local, rows);
                let derivative = self.current.relative.log_derivative();
                Matrix6::from_fn(|i, j| derivative[i][j])
            }
            FrameTarget::Position(_) => {
                let axes = ReferenceFrame::LocalWorldAligned;
                frame_jacobian(self.model, workspace, q, self.frame, axes, rows);
                Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
            }
        };
        for (k, column) in self.damped.jacobian.iter_mut().enumerate() {
            *column = by_twist * Vector6::from_fn(|i, _| rows[i * nv + k]);
        }
        for bound in &self.bounds.0 {
            let at = q[bound.q];
            self.damped.room[bound.v] = (bound.lower - at, bound.upper - at);
        }
    }

    fn step(&mut self, damping: f64, step: &mut [f64]) -> Option<f64> {
        let e = &self.current.e;
        let trace: f64 = self.damped.jacobian.iter().map(Vector6::norm_squared).sum();
        let promised = self.damped.solve(e, 0.5 * damping * e.norm_squared() + ROUNDING * trace)?;
        step.copy_from_slice(&self.damped.step);
        Some(promised.norm_squared())
    }
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

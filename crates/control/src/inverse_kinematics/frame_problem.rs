//! The iteration from one start.

use nalgebra::{Matrix6, Vector6};
use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian, frame_pose, integrate};
use robot_dynamics_description::Pose;

use super::bounds::Bounds;
use super::damped_step::DampedStep;
use super::{FrameTarget, InverseKinematicsOptions, InverseKinematicsSolution};

/// The initial μ and its bounds; beyond the largest, a step does not change q.
const FIRST_DAMPING: f64 = 1.0;
const LEAST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e16;

/// The least λ, relative to the trace of JₑJₑᵀ, with which JₑJₑᵀ + λ 1 can be factored in any pose.
const ROUNDING: f64 = 1e-14;

/// An attempt with a `Short` budget ends if |e|² stays above this fraction of itself over `STAGNATION_STEPS`
/// steps.
const STAGNATION: f64 = 0.9;
const STAGNATION_STEPS: usize = 10;

/// When an attempt ends without success.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum IterationBudget {
    /// At slow convergence, because another start may be better.
    Short,
    /// When no step reduces the error.
    Long,
}

/// The result of an attempt.
pub(super) struct AttemptResult {
    pub solution: InverseKinematicsSolution,
    pub is_found: bool,
    /// |e|².
    squared_error: f64,
}

impl AttemptResult {
    /// The better of this result and one from a random start.
    pub(super) fn nearer(self, mut other: Self) -> Self {
        other.solution.restarts = 1;
        self.joined(other)
    }

    /// The better of this result and its continuation.
    pub(super) fn joined(self, other: Self) -> Self {
        let iterations = self.solution.iterations + other.solution.iterations;
        let restarts = self.solution.restarts + other.solution.restarts;
        let other_wins = other.is_found || other.squared_error < self.squared_error;
        let mut best = if other_wins { other } else { self };
        (best.solution.iterations, best.solution.restarts) = (iterations, restarts);
        best
    }
}

/// e at a configuration, and the two distances.
struct Error {
    e: Vector6<f64>,
    position: f64,
    angle: f64,
    /// `target_from_frame`.
    relative: Pose,
}

/// The data that all attempts of one call share.
pub(super) struct Attempt<'a> {
    model: &'a Model,
    frame: FrameId,
    target: &'a FrameTarget,
    options: &'a InverseKinematicsOptions,
    bounds: Bounds,
    damped: DampedStep,
    jacobian: Vec<f64>,
    q: Vec<f64>,
    trial: Vec<f64>,
}

impl<'a> Attempt<'a> {
    pub(super) fn new(
        model: &'a Model,
        frame: FrameId,
        target: &'a FrameTarget,
        options: &'a InverseKinematicsOptions,
    ) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        Self {
            model,
            frame,
            target,
            options,
            bounds: Bounds::new(model),
            damped: DampedStep::new(nv),
            jacobian: vec![0.0; 6 * nv],
            q: vec![0.0; nq],
            trial: vec![0.0; nq],
        }
    }

    /// Iterates from a start until the frame reaches its target, or the limit of steps or of patience is
    /// reached.
    pub(super) fn run(
        &mut self,
        workspace: &mut Workspace,
        start: &[f64],
        patience: IterationBudget,
    ) -> AttemptResult {
        self.q.copy_from_slice(start);
        self.bounds.clamp(&mut self.q);
        let mut error = self.error(workspace, &self.q);
        let mut damping = FIRST_DAMPING;
        let (mut iterations, mut mark) = (0, error.e.norm_squared());
        let mut is_new = true;
        while !self.is_found(&error) && iterations < self.options.max_iterations && damping <= MOST_DAMPING {
            if is_new {
                self.linearize(workspace, &error);
            }
            iterations += 1;
            let gained = self.try_step(workspace, &error, damping);
            is_new = gained.is_some();
            match gained {
                // Adapt the damping to the ratio of actual and predicted reduction.
                Some((next, share)) => {
                    if share > 0.75 {
                        damping = (damping / 4.0).max(LEAST_DAMPING);
                    } else if share < 0.25 {
                        damping *= 4.0;
                    }
                    std::mem::swap(&mut self.q, &mut self.trial);
                    error = next;
                }
                None => damping *= 8.0,
            }
            if patience == IterationBudget::Short && iterations % STAGNATION_STEPS == 0 {
                let squared = error.e.norm_squared();
                if squared > STAGNATION * mark {
                    break;
                }
                mark = squared;
            }
        }
        let is_found = self.is_found(&error);
        let solution = InverseKinematicsSolution {
            q: self.q.clone(),
            position_error: error.position,
            angle_error: error.angle,
            iterations,
            restarts: 0,
        };
        AttemptResult { solution, is_found, squared_error: error.e.norm_squared() }
    }

    fn is_found(&self, error: &Error) -> bool {
        error.position <= self.options.position_tolerance && error.angle <= self.options.angle_tolerance
    }

    /// The error after a step, in `trial`, and its reduction relative to that of the linear model; `None`
    /// without a reduction.
    fn try_step(&mut self, workspace: &mut Workspace, error: &Error, damping: f64) -> Option<(Error, f64)> {
        let squared = error.e.norm_squared();
        let trace: f64 = self.damped.jacobian.iter().map(Vector6::norm_squared).sum();
        let promised = self.damped.solve(&error.e, 0.5 * damping * squared + ROUNDING * trace)?;
        integrate(self.model, &self.q, &self.damped.step, &mut self.trial);
        self.bounds.clamp(&mut self.trial);
        let next = self.error(workspace, &self.trial);
        let (gain, promise) = (squared - next.e.norm_squared(), squared - promised.norm_squared());
        // NaN fails this test, too.
        (gain > 0.0 && promise > 0.0).then(|| (next, gain / promise))
    }

    /// e: log(T\*⁻¹T), or p − p\* with zeros.
    fn error(&self, workspace: &mut Workspace, q: &[f64]) -> Error {
        let pose = frame_pose(self.model, workspace, q, self.frame);
        match self.target {
            FrameTarget::Pose(target) => {
                let relative = target.inverse().compose(&pose);
                let ([x, y, z], [a, b, c]) = relative.log();
                let angle = norm([a, b, c]);
                let position = norm(relative.translation);
                Error { e: Vector6::new(x, y, z, a, b, c), position, angle, relative }
            }
            FrameTarget::Position(target) => {
                let [x, y, z]: [f64; 3] = core::array::from_fn(|k| pose.translation[k] - target[k]);
                let e = Vector6::new(x, y, z, 0.0, 0.0, 0.0);
                Error { e, position: norm([x, y, z]), angle: 0.0, relative: Pose::IDENTITY }
            }
        }
    }

    /// Jₑ and the distances of each coordinate from its limits at q.
    fn linearize(&mut self, workspace: &mut Workspace, error: &Error) {
        let (nv, rows) = (self.model.nv(), &mut self.jacobian);
        let by_twist = match self.target {
            FrameTarget::Pose(_) => {
                frame_jacobian(self.model, workspace, &self.q, self.frame, ReferenceFrame::Local, rows);
                let derivative = error.relative.log_derivative();
                Matrix6::from_fn(|i, j| derivative[i][j])
            }
            FrameTarget::Position(_) => {
                frame_jacobian(
                    self.model,
                    workspace,
                    &self.q,
                    self.frame,
                    ReferenceFrame::LocalWorldAligned,
                    rows,
                );
                Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
            }
        };
        for (k, column) in self.damped.jacobian.iter_mut().enumerate() {
            *column = by_twist * Vector6::from_fn(|i, _| rows[i * nv + k]);
        }
        for bound in &self.bounds.0 {
            let at = self.q[bound.q];
            self.damped.room[bound.v] = (bound.lower - at, bound.upper - at);
        }
    }
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

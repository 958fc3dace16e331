//! Detection of divergence, and a step that would avoid it.

use nalgebra::DMatrix;
use robot_dynamics_core::{Model, Workspace, mass_matrix};

use super::divergence_cause::DivergenceCause;
use super::energy_account::fastest;
use super::run::RunLoop;
use super::{Run, RunError, Stepper};

/// A coordinate that moves further than this in a step has lost the digits of its angle \[rad or m\], and the
/// run cannot continue.
pub(super) const LOST: f64 = 1e8;

/// If a step fails after one in which a coordinate moved further than this, the failure is attributed to
/// divergence \[rad or m\].
pub(super) const GROWN: f64 = 10.0;

/// A step resolves the motion if no coordinate moves further than this \[rad or m\].
const RESOLVED: f64 = 0.1;

impl RunLoop<'_> {
    /// Whether a step at v moves a coordinate beyond the limit.
    pub fn is_lost(&self, v: &[f64]) -> bool {
        v.iter().any(|v| v.abs() * self.step > LOST)
    }

    /// The error of a step from the current state, replaced by divergence if the motion had grown before.
    pub fn named<S: Stepper>(&self, stepper: &S, run: &Run, error: RunError) -> RunError {
        let has_grown = run.v.iter().any(|v| v.abs() * self.step > GROWN);
        match error {
            RunError::Step { ref source, .. } if source.is_interruption() => error,
            RunError::NotFinite { step, .. }
            | RunError::SingularMass { step, .. }
            | RunError::Step { step, .. }
                if run.steps > 0 && has_grown =>
            {
                self.diverged(stepper, run, &run.v, step)
            }
            error => error,
        }
    }

    /// The error of divergence at velocity v after a number of steps.
    pub(super) fn diverged<S: Stepper>(&self, stepper: &S, run: &Run, v: &[f64], step: usize) -> RunError {
        let index = fastest(v);
        let coordinate = self.model.coordinate_names().get(index).cloned().unwrap_or_default();
        let (suggested_step, cause) = self.suggest(stepper, run);
        let time = self.time(step);
        RunError::Diverged { coordinate, speed: v[index], step, time, suggested_step, cause }
    }

    fn suggest<S: Stepper>(&self, stepper: &S, run: &Run) -> (f64, DivergenceCause) {
        let (model, h) = (self.model, self.step);
        let start = (!run.trajectory.is_empty()).then(|| run.trajectory.sample(0));
        let mut gains = Gains::new(model.nv());
        stepper.explicit_gains(model, self.dissipation, &mut gains.stiffness, &mut gains.damping);
        let q = start.map_or(&run.q[..], |start| start.q);
        let by_stiffness = gains.stable_step(model, q).map_or(f64::INFINITY, |limit| 0.5 * limit);
        let speed = start.map_or(0.0, |start| start.v.iter().fold(0.0, |most: f64, v| most.max(v.abs())));
        let by_speed = RESOLVED / speed;
        if by_stiffness.min(by_speed) >= h {
            return (0.1 * h, DivergenceCause::Unknown);
        }
        if by_stiffness < by_speed {
            (by_stiffness, DivergenceCause::Stiffness)
        } else {
            (by_speed, DivergenceCause::Speed)
        }
    }
}

/// The nv×nv gains K and D of forces −K δq − D v.
struct Gains {
    stiffness: Vec<f64>,
    damping: Vec<f64>,
}

impl Gains {
    fn new(nv: usize) -> Self {
        Self { stiffness: vec![0.0; nv * nv], damping: vec![0.0; nv * nv] }
    }

    /// The longest stable step of explicit methods, from the eigenvalues ω² of M⁻¹K and λ of M⁻¹D. It solves
    /// h²ω² + 2hλ = 4, the limit of semi-implicit Euler steps. It is also within the limits hω ≤ 2 and hλ ≤ 2
    /// of Runge–Kutta rows of order 2 and higher. **(HNW II, §IV.2)**
    fn stable_step(&self, model: &Model, q: &[f64]) -> Option<f64> {
        let nv = model.nv();
        let mut mass = vec![0.0; nv * nv];
        mass_matrix(model, &mut Workspace::new(model), q, &mut mass);
        let factor = DMatrix::from_row_slice(nv, nv, &mass).cholesky()?;
        let largest = |gains: &[f64]| {
            let half = factor.l().solve_lower_triangular(&DMatrix::from_row_slice(nv, nv, gains))?;
            let scaled = factor.l().solve_lower_triangular(&half.transpose())?;
            Some(scaled.symmetric_eigenvalues().max().max(0.0))
        };
        let (square, rate) = (largest(&self.stiffness)?, largest(&self.damping)?);
        let limit = 4.0 / (rate + (rate * rate + 4.0 * square).sqrt());
        limit.is_finite().then_some(limit)
    }
}

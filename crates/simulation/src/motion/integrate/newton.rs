//! Newton's method for the middle velocity, if fixed-point iteration fails.
//!
//! Fixed-point iteration v ← v + c(v), c = M⁻¹r with M of the first middle, converges with the factor
//! h·(rates of the motion). It diverges if that exceeds one, as on long chains with fast stiff modes.
//! Newton's method approximates ∂c/∂v ≈ −1 + O(h) by difference quotients, which take nv evaluations of O(n).
//! It halves the step until the next correction is smaller. Source: Deuflhard, *Newton Methods for Nonlinear
//! Problems* (2004), §3.3.

use robot_dynamics_core::Model;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_integrators::IntegratorError;

use super::forces::StepForces;
use super::midpoint::{evaluate_middle, place_middle};
use super::newton_memory::Newton;
use super::rounding::{is_rounding, largest, rounding_scale};
use super::vectors::add_scaled;
use super::workspace::StepWorkspace;

/// The limit of corrections.
const MAX_CORRECTIONS: usize = 60;

/// The smallest fraction of a correction that is tried.
const SHORTEST: f64 = 1.0 / 64.0;

/// Solves for the middle velocity from the initial guess in `workspace.newton.start`, with the factor of the
/// first middle's M. The results are those of [`solve_middle`](super::variational). `failed` is the error of
/// the fixed-point iteration, which is returned if this method fails too.
///
/// The accepted solution is the one that tends to v₀ as h → 0. The test is that det(−∂c/∂v) > 0, and that no
/// hinge turns by 2 rad in a step.
pub(super) fn solve_by_newton(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    failed: IntegratorError,
) -> Result<(), IntegratorError> {
    let mut newton = core::mem::replace(&mut workspace.newton, Newton::new(0));
    let found = newton.run(model, workspace, forces, h);
    workspace.newton = newton;
    found.ok_or(failed)
}

impl Newton {
    fn run(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
    ) -> Option<()> {
        self.v.copy_from_slice(&self.start);
        let size = self.rest_at(model, workspace, forces, h)?;
        // The last evaluation was at the initial guess.
        let scale = rounding_scale(model, workspace, h);
        if !(size.is_finite() && scale.is_finite()) {
            return None;
        }
        self.rest.copy_from_slice(&workspace.residual);
        self.take_slope(model, workspace, forces, h, scale)?;
        self.correction.copy_from_slice(&self.rest);
        self.slope.solve(&mut self.correction);
        let mut part = 1.0;
        for _ in 0..MAX_CORRECTIONS {
            let size = largest(&self.correction);
            add_scaled(&mut self.v, part, &self.correction);
            let left = self.rest_at(model, workspace, forces, h);
            let solved = left.is_some() && {
                let StepWorkspace { residual, .. } = &mut *workspace;
                self.rest.copy_from_slice(residual);
                self.slope.solve(residual);
                true
            };
            let left = if solved { largest(&workspace.residual) } else { f64::INFINITY };
            // False for NaN.
            if left <= (1.0 - 0.5 * part) * size {
                if left <= 4.0 * f64::EPSILON * scale {
                    return self.accept(model, workspace, forces, h);
                }
                if part < 1.0 || left > 0.1 * size {
                    self.take_slope(model, workspace, forces, h, scale)?;
                    self.correction.copy_from_slice(&self.rest);
                    self.slope.solve(&mut self.correction);
                } else {
                    self.correction.copy_from_slice(&workspace.residual);
                }
                part = (2.0 * part).min(1.0);
                continue;
            }
            if solved && part == 1.0 {
                // `solve` overwrote the residual.
                evaluate_middle(model, workspace, forces, h);
                if is_rounding(model, workspace, h) {
                    return self.accept(model, workspace, forces, h);
                }
            }
            add_scaled(&mut self.v, -part, &self.correction);
            part *= 0.5;
            if part < SHORTEST {
                return None;
            }
        }
        None
    }

    /// c at `self.v`, written to `workspace.residual`, and its size; `None` if a rotation is too large.
    fn rest_at(
        &self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
    ) -> Option<f64> {
        workspace.v.copy_from_slice(&self.v);
        place_middle(model, workspace, h)?;
        evaluate_middle(model, workspace, forces, h);
        let StepWorkspace { factor, residual, .. } = workspace;
        factor.solve(residual);
        Some(largest(residual))
    }

    /// −∂c/∂v at `self.v`, where c is `self.rest`.
    fn take_slope(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        scale: f64,
    ) -> Option<()> {
        // A difference quotient has half the digits of its terms.
        let shift = f64::EPSILON.cbrt() * scale;
        for j in 0..self.v.len() {
            let own = self.v[j];
            self.v[j] += shift;
            let moved = self.v[j] - own;
            let size = self.rest_at(model, workspace, forces, h);
            self.v[j] = own;
            size.filter(|size| size.is_finite())?;
            let quotients = self.rest.iter().zip(&workspace.residual).map(|(a, b)| (a - b) / moved);
            self.slope.set_column(j, quotients);
        }
        self.slope.factor().then_some(())
    }

    /// Stores the middle, momentum and force of the solution, if it is accepted.
    fn accept(
        &self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
    ) -> Option<()> {
        self.rest_at(model, workspace, forces, h)?;
        stays_short(model, &workspace.v, h).then_some(())
    }
}

/// Whether every hinge turns by less than 2 rad in a step of length h.
pub(super) fn stays_short(model: &Model, v: &[f64], h: f64) -> bool {
    model.dofs.iter().all(|dof| {
        let motion = model.bodies[dof.body].motion;
        let turns = motion.chart() == Chart::Line && motion.turns();
        // False for NaN.
        !turns || (h * dof.ratio * v[dof.coordinate]).abs() < 2.0
    })
}

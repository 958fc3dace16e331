//! The structure-preserving rows on any tree: the variational midpoint step and its compositions.
//!
//! One step with a middle configuration q_m and a velocity v is q₀ = q_m ⊖ ½hv, q₁ = q_m ⊕ ½hv. Its action is
//! L_d = h L(q_m, v). Hamilton's principle for L_d defines a map (q₀,p₀) → (q₁,p₁), p = M v. The map is
//! symplectic for every robot, because a discrete action generates it **(HLW §VI.6)**, and it is reversible.
//! For plain coordinates it is the step of `dynamics::variational_midpoint_step`:
//!
//! ```text
//! M(q_m) v = p₀ + ½h F,  p₁ = p₀ + h F,  F = ∂K/∂q − g + τ − b.
//! ```
//!
//! For rotations ⊕ is the half turn of `retraction.rs`. A floating joint moves the center of mass of its own
//! link along a straight line and rotates about it. This is R³×SO(3), not a screw motion of SE(3). Momenta
//! that belong to a symmetry of the robot are conserved to round-off. With a floating base and τ = 0 these
//! are the total linear momentum (without gravity) and the total angular momentum, in world axes. A single
//! free body also conserves K.

use robot_dynamics_core::configuration::manifold::{
    CoordinateRange, coordinate_ranges, quaternion_at, vector_at,
};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, dissipation};
use robot_dynamics_integrators::{IntegratorError, check_computed};
use robot_dynamics_number::algebra::V3;

use super::forces::StepForces;
use super::midpoint::{about_center, center, damping, evaluate_middle, moment_about_center, place_middle};
use super::momentum::momentum_and_kinetic_gradient;
use super::newton::{solve_by_newton, stays_short};
use super::retraction::HalfTurn;
use super::rounding::{is_rounding, largest, rounding_scale};
use super::vectors::add_scaled;
use super::workspace::StepWorkspace;

/// The limit of iterations of an implicit step. Each one reduces the error by a factor of about h·(rates of
/// the motion), so a useful step needs fewer than ten.
pub(crate) const MAX_ITERATIONS: usize = 100;

/// The number of changes without a decrease that end the fixed-point iteration; one or two may occur by
/// chance.
pub(crate) const MAX_STALLS: usize = 3;

/// Takes midpoint steps of these fractions of h from (q, v) to (q, v) through (q, p). Writes q and v only
/// after success.
pub(super) fn compose(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    (h, fractions): (f64, &[f64]),
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), IntegratorError> {
    begin(model, workspace, forces, q, v);
    for part in fractions.iter().map(|fraction| fraction * h) {
        solve_middle(model, workspace, forces, part)?;
        finish(model, workspace, part);
    }
    if let Err(error) = velocity_of_momentum(model, workspace) {
        return Err(run_away(model, workspace, error, q, h, MAX_ITERATIONS));
    }
    q.copy_from_slice(&workspace.q_start);
    v.copy_from_slice(&workspace.v);
    Ok(())
}

/// Computes `q_start`, `p_start` = M(q) v, `v` and `held` of a step from (q, v).
pub(crate) fn begin(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    q: &[f64],
    v: &[f64],
) {
    workspace.q_start.copy_from_slice(q);
    workspace.v.copy_from_slice(v);
    let StepWorkspace { dynamics, p_start, slope, .. } = &mut *workspace;
    momentum_and_kinetic_gradient(model, dynamics, q, v, p_start, slope);
    hold_forces(model, workspace, forces, v);
}

/// The error for a singular M or a number that is not finite in an iteration from `start`. If M(start) is
/// regular, the iteration diverged, and the model is not at fault.
pub(crate) fn run_away(
    model: &Model,
    workspace: &mut StepWorkspace,
    error: IntegratorError,
    start: &[f64],
    step: f64,
    iterations: usize,
) -> IntegratorError {
    let StepWorkspace { dynamics, factor, .. } = workspace;
    match factor.factor(model, dynamics, start) {
        Ok(()) => IntegratorError::NotConverged { residual: f64::INFINITY, iterations, step },
        Err(_) => error,
    }
}

/// `held` = τ − friction·sign v₀, the constant forces of the step.
///
/// With the sign inside the implicit equation, there would be no solution where a joint comes to rest.
pub(crate) fn hold_forces(model: &Model, workspace: &mut StepWorkspace, forces: &StepForces<'_>, v: &[f64]) {
    let StepWorkspace { held, force, .. } = workspace;
    held.copy_from_slice(forces.tau);
    if forces.dissipation {
        dissipation(model, v, force);
        add_scaled(held, -1.0, force);
        damping(model, v, force);
        add_scaled(held, 1.0, force);
    }
}

/// Solves for the middle velocity `v`; the results are also `q` (the middle), `force` (F there) and
/// `momentum`.
fn solve_middle(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
) -> Result<(), IntegratorError> {
    let StepWorkspace { newton, v, .. } = &mut *workspace;
    newton.start.copy_from_slice(v);
    match iterate(model, workspace, forces, h) {
        Err(failed @ IntegratorError::NotConverged { .. })
            if stays_short(model, &workspace.newton.start, h) =>
        {
            solve_by_newton(model, workspace, forces, h, failed)
        }
        done => done,
    }
}

/// Fixed-point iteration v ← v + M⁻¹(wanted p − p(v)), with M of the first middle throughout. The residual
/// determines the solution; M affects only the convergence.
fn iterate(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
) -> Result<(), IntegratorError> {
    let not_converged =
        |residual, iterations| IntegratorError::NotConverged { residual, iterations, step: h };
    let mut scale = 0.0;
    let mut last_change = f64::INFINITY;
    let mut stalls = 0;
    for iterations in 1..=MAX_ITERATIONS {
        place_middle(model, workspace, h).ok_or_else(|| not_converged(f64::INFINITY, iterations))?;
        if iterations == 1 {
            let StepWorkspace { dynamics, factor, q, .. } = &mut *workspace;
            if let Err(error) = factor.factor(model, dynamics, q) {
                let start = workspace.q_start.clone();
                return Err(run_away(model, workspace, error, &start, h, iterations));
            }
        }
        evaluate_middle(model, workspace, forces, h);
        if iterations == 1 {
            scale = rounding_scale(model, workspace, h);
            // The forces or velocities overflow; no change would be small relative to them.
            if !scale.is_finite() {
                return Err(not_converged(f64::INFINITY, iterations));
            }
        }
        // For an ill-conditioned robot the changes stop decreasing above the rounding of v.
        if stalls >= MAX_STALLS && is_rounding(model, workspace, h) {
            return Ok(());
        }
        let StepWorkspace { factor, residual, v, .. } = &mut *workspace;
        factor.solve(residual);
        // A divergent iteration ends in infinities: the step is too long.
        let change = largest(residual);
        if !change.is_finite() || stalls >= MAX_STALLS {
            return Err(not_converged(change / scale, iterations));
        }
        add_scaled(v, 1.0, residual);
        // At round-off the changes are below it or stop decreasing.
        if change <= 4.0 * f64::EPSILON * scale
            || (change >= last_change && change <= 1e3 * f64::EPSILON * scale)
        {
            place_middle(model, workspace, h).ok_or_else(|| not_converged(f64::INFINITY, iterations))?;
            return Ok(());
        }
        stalls += usize::from(change >= last_change);
        last_change = change;
    }
    Err(not_converged(last_change / scale, MAX_ITERATIONS))
}

/// Computes `end` = q₁ of the step with middle `q` and velocity `v`.
///
/// A mimic joint repeats the stretch of its leader and writes the same values again.
pub(crate) fn place_end(model: &Model, (q, v): (&[f64], &[f64]), h: f64, end: &mut [f64]) {
    for (body, CoordinateRange { chart, q: i, v: k }) in model.bodies.iter().zip(coordinate_ranges(model)) {
        match chart {
            Chart::Line => end[i] = q[i] + 0.5 * h * v[k],
            Chart::Rotation => {
                let turn = HalfTurn::new(vector_at(v, k), h).expect("place_middle refused longer turns");
                let turned = quaternion_at(q, i).times(turn.quaternion()).normalized();
                end[i..i + 4].copy_from_slice(&turned.to_xyzw());
            }
            Chart::Placement => {
                let (u, w) = (vector_at(v, k), vector_at(v, k + 3));
                let turn = HalfTurn::new(w, h).expect("place_middle refused longer turns");
                let c = center(body);
                let middle = quaternion_at(q, i + 3);
                let turned = middle.times(turn.quaternion()).normalized();
                let moved = V3::new(middle.rotate(((u + w.cross(c)) * (0.5 * h) + c).array()));
                let position = vector_at(q, i) + moved - V3::new(turned.rotate(c.array()));
                end[i..i + 3].copy_from_slice(&position.array());
                end[i + 3..i + 7].copy_from_slice(&turned.to_xyzw());
            }
        }
    }
}

/// Advances from the solved middle to the end: `q_start` ← q₁, `p_start` ← p₁.
pub(crate) fn finish(model: &Model, workspace: &mut StepWorkspace, h: f64) {
    place_end(model, (&workspace.q, &workspace.v), h, &mut workspace.q_start);
    let StepWorkspace { p_start, v, momentum, force, .. } = workspace;
    for (body, CoordinateRange { chart, v: k, .. }) in model.bodies.iter().zip(coordinate_ranges(model)) {
        match chart {
            // Handled below: a mimic joint repeats the stretch of its leader, but p must advance once.
            Chart::Line => {}
            Chart::Rotation => {
                let turn = HalfTurn::new(vector_at(v, k), h).expect("place_middle refused longer turns");
                let p = turn.end_momentum(vector_at(p_start, k), vector_at(force, k), h);
                p_start[k..k + 3].copy_from_slice(&p.array());
            }
            Chart::Placement => {
                let turn = HalfTurn::new(vector_at(v, k + 3), h).expect("place_middle refused longer turns");
                let c = center(body);
                let moment = moment_about_center(c, v, momentum, force, k);
                let linear = turn.end_momentum(vector_at(p_start, k), vector_at(force, k), h);
                let angular = turn.end_momentum(about_center(c, p_start, k), moment, h) + c.cross(linear);
                p_start[k..k + 3].copy_from_slice(&linear.array());
                p_start[k + 3..k + 6].copy_from_slice(&angular.array());
            }
        }
    }
    // Plain coordinates, once each: p₁ = p₀ + h F.
    for k in 0..model.nv {
        if workspace.is_plain[k] {
            workspace.p_start[k] += h * workspace.force[k];
        }
    }
}

/// `v` = M(q₁)⁻¹ p₁, refined once against the p(v) from which the next step starts. Without the refinement
/// the factor's rounding error, similar in every step, would accumulate.
pub(crate) fn velocity_of_momentum(
    model: &Model,
    workspace: &mut StepWorkspace,
) -> Result<(), IntegratorError> {
    let StepWorkspace { dynamics, factor, q_start, v, p_start, momentum, slope, residual, .. } = workspace;
    factor.factor(model, dynamics, q_start)?;
    v.copy_from_slice(p_start);
    factor.solve(v);
    momentum_and_kinetic_gradient(model, dynamics, q_start, v, momentum, slope);
    for ((r, p), m) in residual.iter_mut().zip(&*p_start).zip(&*momentum) {
        *r = p - m;
    }
    factor.solve(residual);
    add_scaled(v, 1.0, residual);
    check_computed("v", v)
}

//! A time step that stays on the constraint.

use dynamics::Integrator;

use super::error::{check_entries, check_number};
use super::variational::variational_step;
use super::{
    ConstrainedMotionError, ConstraintDrift, ConstraintOptions, ConstraintSet, constrained_forward_dynamics,
    project_position, project_velocity,
};
use crate::model::length::check_length;
use crate::motion::integrate::displacement_rate;
use crate::motion::integrate::variational::yoshida_parts;
use crate::{Model, StepForces, StepWorkspace, Workspace, constraint_drift, dissipation, integrate};

/// What is done about drift after each step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriftCorrection {
    /// Nothing; with [`Baumgarte`](super::Baumgarte) in the options the acceleration pulls back.
    None,
    /// v ← P v.
    Velocity,
    /// q onto φ = 0 to this tolerance \[m or rad\], then v ← P v.
    Position {
        /// The largest |φ| allowed.
        tolerance: f64,
    },
}

/// What a constrained step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedStepReport {
    /// φ and A v at the end of the step before the correction: the drift of this step. A variational row moves
    /// its momentum along Aᵀ at the end; here is A v before that.
    pub drift: ConstraintDrift,
    /// φ and A v after it.
    pub corrected: ConstraintDrift,
    /// The kinetic energy that v ← P v took out \[J\]; 0 in a variational row, where it is no correction.
    pub energy_removed: f64,
    /// The rank of A at the start of the step.
    pub rank: usize,
}

/// One step of the constrained motion on the manifold, τ held, by the row of `options.integrator`.
///
/// | row | order | the constraint | energy |
/// | --- | --- | --- | --- |
/// | `rk4` | 4 | broken by O(h⁵) in a step, then corrected | drifts |
/// | `variational-midpoint` | 2 | φ = 0 and A v = 0 at the end of every step, to rounding | stays within O(h²) |
/// | `variational-yoshida4` | 4 | the same | stays within O(h⁴) |
///
/// Of `rk4` the stages are those of the tree's row, the acceleration that of [`constrained_forward_dynamics`].
/// In continuous time the constraint keeps itself. Because P v and n = (1−P) v are orthogonal in M the velocity
/// projection changes K by exactly −½ nᵀM n = O(h¹⁰).
///
/// The variational rows hold φ = 0 by multipliers in the discrete action and end on A v = 0 (RATTLE), whatever
/// the correction; they need a start on the constraint. **(HLW §VII.1.4)** Rows without φ (no slip, rolling) follow
/// the discrete Lagrange–d'Alembert principle with A v = 0 at the middle and at the end: the step is reversible and
/// keeps them, yet nothing is symplectic, and energy is kept to the order only.
///
/// On an error q and v stay as they were. It allocates.
///
/// # Errors
/// As [`constrained_forward_dynamics`] at any stage, and as [`project_position`];
/// [`ConstrainedMotionError::BadStep`] where `h` is not positive and finite;
/// [`ConstrainedMotionError::StepNotConverged`] where a variational step is too long or starts far off the
/// constraint; [`ConstrainedMotionError::NoSuchStep`].
///
/// # Panics
/// If a slice has the wrong length.
#[allow(clippy::too_many_arguments)] // model, memory, law, options, forces, step, state
pub fn constrained_step(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    correction: DriftCorrection,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstrainedMotionError> {
    check_step(model, options, correction, forces, h, q, v)?;
    if options.integrator == Integrator::RungeKutta4 {
        runge_kutta_step(model, workspace, set, options, correction, forces, h, q, v)
    } else {
        implicit_step(model, &mut StepWorkspace::new(model), set, options, forces, h, q, v)
    }
}

/// [`constrained_step`] in memory that has room for every row.
#[allow(clippy::too_many_arguments)] // as constrained_step
pub(super) fn step_in(
    model: &Model,
    workspace: &mut StepWorkspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    correction: DriftCorrection,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstrainedMotionError> {
    check_step(model, options, correction, forces, h, q, v)?;
    if options.integrator == Integrator::RungeKutta4 {
        runge_kutta_step(model, &mut workspace.dynamics, set, options, correction, forces, h, q, v)
    } else {
        implicit_step(model, workspace, set, options, forces, h, q, v)
    }
}

/// Refuses what no row takes, and what this one does not.
fn check_step(
    model: &Model,
    options: &ConstraintOptions,
    correction: DriftCorrection,
    forces: &StepForces<'_>,
    h: f64,
    q: &[f64],
    v: &[f64],
) -> Result<(), ConstrainedMotionError> {
    if !(h > 0.0 && h.is_finite()) {
        return Err(ConstrainedMotionError::BadStep { step: h });
    }
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), model.nv());
    check_length("tau", forces.tau.len(), model.nv());
    for (quantity, values) in [("q", q), ("v", v), ("tau", forces.tau)] {
        check_entries(quantity, values)?;
    }
    options.check()?;
    if let DriftCorrection::Position { tolerance } = correction {
        check_number("the tolerance", tolerance)?;
    }
    match options.integrator {
        Integrator::RungeKutta4 => Ok(()),
        Integrator::VariationalMidpoint | Integrator::VariationalYoshida4 => match options.stabilization {
            None => Ok(()),
            Some(_) => Err(ConstrainedMotionError::StabilizedVariationalStep),
        },
        integrator => Err(ConstrainedMotionError::NoSuchStep { integrator }),
    }
}

/// A variational row.
#[allow(clippy::too_many_arguments)] // as constrained_step
fn implicit_step(
    model: &Model,
    workspace: &mut StepWorkspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstrainedMotionError> {
    let yoshida = yoshida_parts(h);
    let parts = if options.integrator == Integrator::VariationalYoshida4 { &yoshida[..] } else { &[h] };
    let done = variational_step(model, workspace, set, options, forces, parts, q, v)?;
    let corrected = constraint_drift(model, &mut workspace.dynamics, set, q, v);
    Ok(ConstrainedStepReport {
        drift: ConstraintDrift { position: corrected.position, velocity: done.velocity_before },
        corrected,
        energy_removed: 0.0,
        rank: done.rank,
    })
}

/// The classical Runge–Kutta row; then the correction.
#[allow(clippy::too_many_arguments)] // as constrained_step
fn runge_kutta_step(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    correction: DriftCorrection,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<ConstrainedStepReport, ConstrainedMotionError> {
    let nv = model.nv();
    let mut rank = None;
    let mut theta = vec![0.0; nv];
    let mut v_stage = v.to_vec();
    let (mut theta_sum, mut v_sum) = (vec![0.0; nv], vec![0.0; nv]);
    let mut q_stage = q.to_vec();
    let mut tau = vec![0.0; nv];
    let mut acceleration = vec![0.0; nv];
    // (where the stage is reached from the one before, as a fraction of h; its weight in the sum)
    for (reach, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        for k in 0..nv {
            theta[k] *= reach * h;
            v_stage[k] = v[k] + reach * h * acceleration[k];
        }
        integrate(model, q, &theta, &mut q_stage);
        tau.copy_from_slice(forces.tau);
        if forces.dissipation {
            dissipation(model, &v_stage, &mut acceleration);
            tau.iter_mut().zip(&acceleration).for_each(|(tau, b)| *tau -= b);
        }
        let motion = constrained_forward_dynamics(model, workspace, set, options, &q_stage, &v_stage, &tau)?;
        acceleration.copy_from_slice(motion.acceleration.as_slice());
        rank.get_or_insert(motion.rank);
        displacement_rate(model, &mut theta, &v_stage);
        for k in 0..nv {
            theta_sum[k] += weight * h / 6.0 * theta[k];
            v_sum[k] += weight * h / 6.0 * acceleration[k];
        }
    }
    integrate(model, q, &theta_sum, &mut q_stage);
    v_stage.iter_mut().zip(&*v).zip(&v_sum).for_each(|((end, v), sum)| *end = v + sum);
    check_entries("v after the step", &v_stage)?;
    check_entries("q after the step", &q_stage)?;

    let drift = constraint_drift(model, workspace, set, &q_stage, &v_stage);
    if let DriftCorrection::Position { tolerance } = correction {
        project_position(model, workspace, set, options, tolerance, &mut q_stage)?;
    }
    let (mut corrected, mut energy_removed) = (drift, 0.0);
    if correction != DriftCorrection::None {
        energy_removed = project_velocity(model, workspace, set, options, &q_stage, &mut v_stage)?;
        corrected = constraint_drift(model, workspace, set, &q_stage, &v_stage);
    }
    q.copy_from_slice(&q_stage);
    v.copy_from_slice(&v_stage);
    Ok(ConstrainedStepReport { drift, corrected, energy_removed, rank: rank.unwrap_or(0) })
}

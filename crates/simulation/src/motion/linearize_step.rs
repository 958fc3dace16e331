//! The exact derivatives A and B of one explicit step: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ.
//!
//! The chain rule is applied to the stages, with the derivatives of forward dynamics and of q ⊕ Θ. **(HLW
//! §III.4)** Cost: O(nv² depth) for each stage, and products of nv×3nv matrices.
//!
//! δq has nv numbers, also with quaternions. The sign of a friction force is held constant. Variational rows
//! solve an equation and are refused; `differences` serves every other stepper.

mod checks;
mod differences;
pub(crate) mod displacement;
pub(super) mod product;
pub mod results;
mod stepper;
mod with_parameters;

use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::{
    ForwardDynamicsDerivativesMut, Model, Workspace, check_rank, dissipation_derivative, forward_dynamics,
    forward_dynamics_derivatives, integrate,
};
use robot_dynamics_integrators::{Integrator, IntegratorError, Stage, StepScheme, check_computed};

use self::checks::check_inputs;
use self::displacement::{add_identity, rate_change, retraction_change};
use self::product::multiply_changes;
use crate::StepForces;
use crate::motion::RobotState;
use crate::motion::integrate::net_force;
use crate::motion::integrate::stage_memory::most_stages;
use crate::motion::integrate::vectors::{scale, start_from, sum_stages};
use crate::motion::simulate::StepError;

pub use self::differences::linearize_by_differences;
pub use self::results::{LinearizationMethod, LinearizedStep, LinearizedStepWithParameters, LinearizedSteps};
pub use self::stepper::linearize_stepper;
pub use self::with_parameters::linearize_stepper_with_parameters;

/// Scratch for [`linearize_step`] on one model.
///
/// A field `…_change` holds the derivative of one vector by (δq, δv, δτ) at the start: a matrix of nv rows
/// and 3nv columns.
#[derive(Clone, Debug)]
pub struct LinearizeStepWorkspace {
    dynamics: Workspace,
    /// q, v and the displacement from the start of a stage; the rates of the displacement and the
    /// accelerations of all stages.
    q: Vec<f64>,
    v: Vec<f64>,
    displacement: Vec<f64>,
    rates: Vec<f64>,
    accelerations: Vec<f64>,
    force: Vec<f64>,
    damping: Vec<f64>,
    /// ∂a/∂q, ∂a/∂v, ∂a/∂τ.
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
    by_force: Vec<f64>,
    /// The derivatives of all these vectors.
    q_change: Vec<f64>,
    v_change: Vec<f64>,
    displacement_change: Vec<f64>,
    rate_changes: Vec<f64>,
    acceleration_changes: Vec<f64>,
}

impl LinearizeStepWorkspace {
    /// Allocates the memory for this model; nothing else allocates.
    pub fn new(model: &Model) -> Self {
        let (nv, stages) = (model.nv, most_stages());
        let (vector, square, change) = (|| vec![0.0; nv], || vec![0.0; nv * nv], || vec![0.0; 3 * nv * nv]);
        Self {
            dynamics: Workspace::new(model),
            q: vec![0.0; model.nq],
            v: vector(),
            displacement: vector(),
            rates: vec![0.0; stages * nv],
            accelerations: vec![0.0; stages * nv],
            force: vector(),
            damping: vector(),
            by_position: square(),
            by_velocity: square(),
            by_force: square(),
            q_change: change(),
            v_change: change(),
            displacement_change: change(),
            rate_changes: vec![0.0; stages * 3 * nv * nv],
            acceleration_changes: vec![0.0; stages * 3 * nv * nv],
        }
    }
}

/// The exact derivatives A and B of one [`step`](crate::step): (δq₁, δv₁) = A (δq₀, δv₀) + B δτ.
///
/// A is 2nv×2nv and B is 2nv×nv, row-major. δq is the displacement of [`integrate`](robot_dynamics_core::integrate()): q₀ ⊕
/// δq₀ maps to q₁ ⊕ δq₁, with nv numbers even if q has quaternions. [`forward_dynamics_derivatives`] gives
/// the derivatives of the accelerations. The chain rule applies to the stages of a Runge–Kutta step, and to q
/// ⊕ Θ by
///
/// > q ⊕ (Θ + δΘ) = (q ⊕ Θ) ⊕ J(Θ) δΘ,  (q ⊕ δq) ⊕ Θ = (q ⊕ Θ) ⊕ e^(−ad Θ) δq,  J(Θ) = Σ (−ad Θ)ᵏ/(k+1)!
///
/// **(HLW §III.4)** Damping follows v; the sign of the friction is held constant.
///
/// ```
/// use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// use robot_dynamics::simulation::{Integrator, StepForces};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (n, h) = (model.nv(), 1e-3);
/// let (tau, v) = (vec![0.0; n], vec![0.1; n]);
/// let forces = StepForces::new(&tau, true);
/// let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
/// let mut workspace = LinearizeStepWorkspace::new(&model);
/// let row = Integrator::ExplicitEuler;
/// let state = RobotState { q: &neutral(&model), v: &v };
/// let derivatives = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// linearize_step(&model, row, &mut workspace, &forces, h, state, derivatives)?;
/// // An explicit Euler step moves by h v₀ for any force: the upper half of B is zero.
/// assert!(b[..n * n].iter().all(|&x| x == 0.0) && b[n * n..].iter().any(|&x| x != 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`StepError`] if an input, an acceleration or a result is not finite, if `h` is not
///   positive, or if M(q) is singular, with the names of the joints.
/// - [`StepError::NotDifferentiable`] for the variational rows.
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn linearize_step(
    model: &Model,
    integrator: Integrator,
    workspace: &mut LinearizeStepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    RobotState { q, v }: RobotState<'_>,
    mut out: LinearizedStep<'_>,
) -> Result<(), StepError> {
    check_inputs(model, forces, h, RobotState { q, v }, &out)?;
    if model.nv() == 0 {
        return Ok(());
    }
    check_rank(model, &mut workspace.dynamics, q)?;
    match integrator.scheme() {
        StepScheme::Explicit(stages) => explicit(model, workspace, stages, forces, h, q, v)?,
        StepScheme::Variational(_) => return Err(StepError::NotDifferentiable { integrator }),
    }
    check_computed("the derivative of q", &workspace.q_change)?;
    check_computed("the derivative of v", &workspace.v_change)?;
    out.write_changes(model.nv, &workspace.q_change, &workspace.v_change);
    Ok(())
}

/// The changes of q₁ and v₁, written to `q_change` and `v_change`, from the stages of
/// [`explicit_step`](crate::motion::integrate::explicit) and their changes.
fn explicit(
    model: &Model,
    w: &mut LinearizeStepWorkspace,
    stages: &[Stage],
    forces: &StepForces<'_>,
    h: f64,
    q: &[f64],
    v: &[f64],
) -> Result<(), IntegratorError> {
    let (n, square) = (model.nv, 3 * model.nv * model.nv);
    let v_row = |w: &mut LinearizeStepWorkspace, k: &dyn Fn(usize) -> f64, count| {
        sum_stages(count, k, &w.accelerations, &mut w.v);
        start_from(v, h, &mut w.v);
        sum_stages(count, k, &w.acceleration_changes, &mut w.v_change);
        scale(h, &mut w.v_change);
        add_identity(&mut w.v_change, n, 1, 1.0);
    };
    let q_row = |w: &mut LinearizeStepWorkspace, k: &dyn Fn(usize) -> f64, count| {
        sum_stages(count, k, &w.rates, &mut w.displacement);
        scale(h, &mut w.displacement);
        sum_stages(count, k, &w.rate_changes, &mut w.displacement_change);
        scale(h, &mut w.displacement_change);
        retraction_change(model, &w.displacement, &w.displacement_change, &mut w.q_change);
    };
    for (i, stage) in stages.iter().enumerate() {
        // Whether q, or v, is that of the start, with Θ = 0.
        let (q_stays, v_stays) = (stage.q_row.is_empty(), stage.v_row.is_empty());
        if v_stays {
            w.v.copy_from_slice(v);
            write_identity(&mut w.v_change, n, 1);
        } else {
            v_row(w, &|j| stage.v_row[j], stage.v_row.len());
        }
        if q_stays {
            w.q.copy_from_slice(q);
            write_identity(&mut w.q_change, n, 0);
        } else {
            q_row(w, &|j| stage.q_row[j], stage.q_row.len());
            integrate(model, q, &w.displacement, &mut w.q);
        }
        if Stage::needs_acceleration(stages, i) {
            accelerate(model, w, forces, i, q_stays && v_stays)?;
        }
        if !Stage::needs_rate(stages, i) {
            continue;
        }
        let (rate, change) = (i * n..(i + 1) * n, i * square..(i + 1) * square);
        if q_stays {
            w.rates[rate].copy_from_slice(&w.v);
            w.rate_changes[change].copy_from_slice(&w.v_change);
        } else {
            displacement_rate(model, &w.displacement, &w.v, &mut w.rates[rate]);
            let (theta, v) = ((&w.displacement[..], &w.displacement_change[..]), (&w.v[..], &w.v_change[..]));
            rate_change(model, theta, v, &mut w.rate_changes[change]);
        }
    }
    v_row(w, &|j| stages[j].v_weight, stages.len());
    q_row(w, &|j| stages[j].q_weight, stages.len());
    Ok(())
}

/// a at stage `i` for (q, v), and its change δa = ∂a/∂q δq + (∂a/∂v − M⁻¹ ∂b/∂v) δv + M⁻¹ δτ. At the start δq
/// and δv are identity columns.
fn accelerate(
    model: &Model,
    w: &mut LinearizeStepWorkspace,
    forces: &StepForces<'_>,
    i: usize,
    is_start: bool,
) -> Result<(), IntegratorError> {
    let (n, width) = (model.nv, 3 * model.nv);
    let acceleration = &mut w.accelerations[i * n..(i + 1) * n];
    let change = &mut w.acceleration_changes[i * n * width..(i + 1) * n * width];
    net_force(model, forces, &w.v, &mut w.force);
    forward_dynamics(model, &mut w.dynamics, &w.q, &w.v, &w.force, acceleration);
    check_computed("the acceleration", acceleration)?;
    let (by_q, by_v, by_tau) = (&mut w.by_position, &mut w.by_velocity, &mut w.by_force);
    let out = ForwardDynamicsDerivativesMut { by_position: by_q, by_velocity: by_v, by_force: by_tau };
    forward_dynamics_derivatives(model, &mut w.dynamics, &w.q, &w.v, &w.force, out);
    if forces.dissipation {
        dissipation_derivative(model, &mut w.damping);
        for (row, inverse) in by_v.chunks_exact_mut(n).zip(by_tau.chunks_exact(n)) {
            for ((x, m), damping) in row.iter_mut().zip(inverse).zip(&w.damping) {
                *x -= m * damping;
            }
        }
    }
    if !is_start {
        multiply_changes(&[(by_q, &w.q_change), (by_v, &w.v_change)], width, change);
    }
    for (i, change) in change.chunks_exact_mut(width).enumerate() {
        let row = i * n..(i + 1) * n;
        if is_start {
            change[..n].copy_from_slice(&by_q[row.clone()]);
            change[n..2 * n].copy_from_slice(&by_v[row.clone()]);
            change[2 * n..].copy_from_slice(&by_tau[row]);
        } else {
            change[2 * n..].iter_mut().zip(&by_tau[row]).for_each(|(x, by_tau)| *x += by_tau);
        }
    }
    Ok(())
}

/// Writes the change of δq (`part` 0) or of δv (`part` 1), which is the identity.
fn write_identity(change: &mut [f64], n: usize, part: usize) {
    change.fill(0.0);
    add_identity(change, n, part, 1.0);
}

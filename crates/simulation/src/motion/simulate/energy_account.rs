//! The energy account of a run on a tree.

use robot_dynamics_core::algorithms::energy::energies;
use robot_dynamics_core::configuration::displacement_rate::bracket;
use robot_dynamics_core::configuration::manifold::{coordinate_ranges, vector_at};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, Workspace, difference, dissipation, neutral};
use robot_dynamics_integrators::EnergyAccount;
use robot_dynamics_number::algebra::V3;

use crate::{StepForces, StepWorkspace};

/// Starts an energy account at (q, v) with E₀ = K + V.
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, Workspace, neutral};
/// use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, energy_account};
/// use robot_dynamics::simulation::{StateTransition, record_step, step};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (mut q, mut v, tau) = (neutral(&model), vec![0.1; model.nv()], vec![0.5; model.nv()]);
/// let mut energy_account = energy_account(&model, &mut Workspace::new(&model), &q, &v);
/// let mut workspace = StepWorkspace::new(&model);
/// let forces = StepForces::new(&tau, true);
/// for _ in 0..100 {
///     let start = (q.clone(), v.clone());
///     step(&model, Integrator::RungeKutta4, &mut workspace, &forces, 1e-4, &mut q, &mut v)?;
///     let transition =
///         StateTransition { from: (&start.0, &start.1), to: (&q, &v), forces: &forces, h: 1e-4 };
///     record_step(&model, &mut workspace, &mut energy_account, transition);
/// }
/// // The work of the motors minus the dissipation of the joints is the change of the energy.
/// assert!(energy_account.work() != 0.0 && energy_account.max_imbalance() < 1e-9 * energy_account.scale());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
#[doc(alias = "energy_ledger")]
pub fn energy_account(model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) -> EnergyAccount {
    let (kinetic, potential) = energies(model, workspace, q, v);
    EnergyAccount::new(kinetic, potential)
}

/// A step from one state to another, as the energy account records it.
#[derive(Clone, Copy, Debug)]
pub struct StateTransition<'a> {
    /// (q, v) at the start.
    pub from: (&'a [f64], &'a [f64]),
    /// (q, v) at the end.
    pub to: (&'a [f64], &'a [f64]),
    /// The forces of the step.
    pub forces: &'a StepForces<'a>,
    /// The length of the step \[s\].
    pub h: f64,
}

/// Records one step under the forces of the step.
///
/// The work of the held τ is τ·∫v dt. For coordinates without quaternions ∫v dt = q₁ − q₀, exact along any
/// path. For quaternion joints it is q₁ ⊖ q₀ − h²/12 \[v₀,v₁\], the Magnus expansion up to O(h⁵) **(HLW
/// §IV.7)**. Simpson's rule gives ∫ b·v dt on the parabola for v with this integral. Both have order 4, the
/// highest order in the table of integrators.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// use robot_dynamics::simulation::{StateTransition, StepForces, StepWorkspace, energy_account};
/// use robot_dynamics::simulation::{record_step, step};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // One step with a motor of 30 N·m: its work τ (q₁ − q₀) appears in K + V.
/// let (mut q, mut v, forces) = ([0.0], [0.0], StepForces::new(&[30.0], false));
/// let mut energy_account = energy_account(&model, &mut Workspace::new(&model), &q, &v);
/// let w = &mut StepWorkspace::new(&model);
/// step(&model, robot_dynamics::simulation::Integrator::RungeKutta4, w, &forces, 1e-3, &mut q, &mut v)?;
/// let transition = StateTransition { from: (&[0.0], &[0.0]), to: (&q, &v), forces: &forces, h: 1e-3 };
/// record_step(&model, w, &mut energy_account, transition);
/// assert!((energy_account.work() - 30.0 * q[0]).abs() < 1e-15);
/// assert!(energy_account.imbalance().abs() < 1e-13); // the step's error is O(h⁵)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length.
#[track_caller]
pub fn record_step(
    model: &Model,
    workspace: &mut StepWorkspace,
    energy_account: &mut EnergyAccount,
    transition: StateTransition<'_>,
) {
    let (q, v) = transition.to;
    let energies = energies(model, &mut workspace.dynamics, q, v);
    record_energies(model, workspace, energy_account, transition, energies);
}

/// [`record_step`] with given K and V at the step's end.
pub(crate) fn record_energies(
    model: &Model,
    workspace: &mut StepWorkspace,
    energy_account: &mut EnergyAccount,
    transition: StateTransition<'_>,
    (kinetic, potential): (f64, f64),
) {
    displace(model, workspace, transition);
    let StateTransition { from: (_, v0), to: (_, v1), forces, h } = transition;
    let StepWorkspace { displacement, v: middle, force, .. } = workspace;
    let work = energy_account.work() + dot(forces.tau, displacement);
    let mut dissipated = energy_account.dissipated();
    if forces.dissipation {
        let mut power = |v: &[f64]| {
            dissipation(model, v, force);
            dot(force, v)
        };
        dissipated += (power(v0) + 4.0 * power(middle) + power(v1)) * (h / 6.0);
    }
    energy_account.enter(kinetic, potential, work, dissipated);
}

/// K and V at the step's end. Writes ∫v dt to the workspace's `displacement`, and v in the middle of the step
/// to its `v`.
pub fn end_energies(
    model: &Model,
    workspace: &mut StepWorkspace,
    transition: StateTransition<'_>,
) -> (f64, f64) {
    displace(model, workspace, transition);
    let (q, v) = transition.to;
    energies(model, &mut workspace.dynamics, q, v)
}

/// Writes ∫v dt to the workspace's `displacement`, and v in the middle of the step to its `v`.
fn displace(model: &Model, workspace: &mut StepWorkspace, transition: StateTransition<'_>) {
    let StateTransition { from: (q0, v0), to: (q1, v1), h, .. } = transition;
    let StepWorkspace { displacement, v: middle, .. } = workspace;
    difference(model, q0, q1, displacement);
    take_off_commutators(model, displacement, (v0, v1), h);
    for k in 0..v0.len() {
        middle[k] = 1.5 / h * displacement[k] - 0.25 * (v0[k] + v1[k]);
    }
}

/// The energy account of a run from (q, v), with the state. For an invalid start it returns the error with
/// the account of the neutral configuration at rest. If E₀ is not finite, `overflow` creates the error from
/// the fastest coordinate and E₀.
pub(crate) fn open_start<E>(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    v: &[f64],
    start: Result<(), E>,
    overflow: impl FnOnce(usize, f64) -> E,
) -> (EnergyAccount, Vec<f64>, Vec<f64>, Result<(), E>) {
    let error = match start {
        Ok(()) => {
            let energy_account = energy_account(model, workspace, q, v);
            if energy_account.start().is_finite() {
                return (energy_account, q.to_vec(), v.to_vec(), Ok(()));
            }
            overflow(fastest(v), energy_account.start())
        }
        Err(error) => error,
    };
    let (q, v) = (neutral(model), vec![0.0; model.nv()]);
    (energy_account(model, workspace, &q, &v), q, v, Err(error))
}

/// ∫v dt of quaternion joints from their q₁ ⊖ q₀.
fn take_off_commutators(model: &Model, displacement: &mut [f64], (v0, v1): (&[f64], &[f64]), h: f64) {
    let factor = -h * h / 12.0;
    let mut add = |k: usize, x: V3<f64>| {
        let sum = vector_at(displacement, k).add_scaled(factor, x);
        displacement[k..k + 3].copy_from_slice(&sum.array());
    };
    for stretch in coordinate_ranges(model) {
        let k = stretch.v;
        match stretch.chart {
            Chart::Line => {}
            Chart::Rotation => add(k, vector_at(v0, k).cross(vector_at(v1, k))),
            Chart::Placement => {
                let at = |v| (vector_at(v, k), vector_at(v, k + 3));
                let (linear, angular) = bracket(at(v0), at(v1));
                add(k, linear);
                add(k + 3, angular);
            }
        }
    }
}

/// The fastest coordinate: squares overflow before velocities do.
pub fn fastest(v: &[f64]) -> usize {
    (0..v.len()).max_by(|&i, &j| v[i].abs().total_cmp(&v[j].abs())).unwrap_or(0)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

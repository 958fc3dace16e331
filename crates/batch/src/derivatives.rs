//! Derivatives of dynamics on batches: several tables of results.

use robot_dynamics_core::derivatives::{ForwardDynamicsSlopes, InverseDynamicsSlopes};
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_number::StateLanes;
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};

use super::bad_states::BadStateSet;
use super::block::{
    self, Block, OverLanes, add_poison, bad_lanes, make_room, poison_lanes, read, scatter_all,
};
use super::compute::{Tables, check_table, check_workspace};
use super::native::{Number, natively};
use super::share::for_each_block;
use super::within::call;
use super::workspace::BlockMemory;
use super::{BadStates, BatchFloat, BatchWorkspace};

/// The most blocks in a chunk: about ten microseconds of work.
const BLOCKS_PER_CHUNK: usize = 8;

/// ∂τ/∂q and ∂τ/∂v of each state; see [`inverse_dynamics_derivatives`](robot_dynamics_core::inverse_dynamics_derivatives).
///
/// q is \[batch\]\[nq\]; v and a are \[batch\]\[nv\]; the derivatives are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // τ = m l² a − m g l cos q, so ∂τ/∂q = m g l sin q.
/// let (q, v, a, mut by_q, mut by_v) = ([0.0, 0.3], [1.0; 2], [2.0; 2], [0.0; 2], [1.0; 2]);
/// let workspace = &mut BatchWorkspace::<f64>::new(&model);
/// batch::inverse_dynamics_derivatives(&model, workspace, &q, &v, &a, &mut by_q, &mut by_v)?;
/// assert!((0..2).all(|state| (by_q[state] - 2.0 * 9.81 * 0.5 * q[state].sin()).abs() < 1e-14));
/// assert!(by_v.iter().all(|by_v| by_v.abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "computeRNEADerivatives")]
#[allow(clippy::too_many_arguments)] // as `inverse_dynamics`, with two results
#[track_caller]
pub fn inverse_dynamics_derivatives<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    a: &[T],
    by_position: &mut [T],
    by_velocity: &mut [T],
) -> Result<(), BadStates> {
    let tables = Tables { names: ["q", "v", "a"], widths: [model.nq, model.nv, model.nv], rows: [q, v, a] };
    T::derivatives(model, workspace, false, &tables, [by_position, by_velocity, &mut []])
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂τ = M⁻¹ of each state; see
/// [`forward_dynamics_derivatives`](robot_dynamics_core::forward_dynamics_derivatives).
///
/// q is \[batch\]\[nq\]; v and tau are \[batch\]\[nv\]; the derivatives are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²): the derivatives are −(g/l) sin q, 0 and 1/(m l²).
/// let (q, v, tau) = ([0.0, 0.3], [1.0; 2], [0.7; 2]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// let workspace = &mut BatchWorkspace::<f64>::new(&model);
/// batch::forward_dynamics_derivatives(&model, workspace, &q, &v, &tau, &mut by_q, &mut by_v, &mut by_tau)?;
/// assert!((0..2).all(|state| (by_q[state] + 9.81 / 0.5 * q[state].sin()).abs() < 1e-13));
/// assert!(by_tau.iter().all(|by_tau| (by_tau - 1.0 / (2.0 * 0.25)).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result, including those with a singular M; all other
/// results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "computeABADerivatives")]
#[allow(clippy::too_many_arguments)] // as `forward_dynamics`, with three results
#[track_caller]
pub fn forward_dynamics_derivatives<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    tau: &[T],
    by_position: &mut [T],
    by_velocity: &mut [T],
    by_force: &mut [T],
) -> Result<(), BadStates> {
    let tables =
        Tables { names: ["q", "v", "tau"], widths: [model.nq, model.nv, model.nv], rows: [q, v, tau] };
    T::derivatives(model, workspace, true, &tables, [by_position, by_velocity, by_force])
}

/// The derivatives of forward dynamics, or of inverse dynamics with two results.
#[track_caller]
pub(super) fn compute<T: BatchFloat + Number, const FORWARD: bool>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    tables: &Tables<'_, T>,
    results: [&mut [T]; 3],
) -> Result<(), BadStates> {
    check_workspace(model, workspace);
    let batch = tables.count(model);
    let size = model.nv * model.nv;
    check_table("the derivative by q", results[0].len(), batch, size);
    check_table("the derivative by v", results[1].len(), batch, size);
    check_table("the derivative by tau", results[2].len(), batch, if FORWARD { size } else { 0 });
    if results[0].is_empty() {
        return Ok(());
    }
    let again = |block: &mut BlockMemory, rows: [&[T]; 3], results: [&mut [T]; 3]| {
        let mut bits = 0;
        block::run(block, Lanewise::<T, FORWARD> { model, states: 1, rows, results, bad: &mut bits });
        bits == 0
    };
    let function = if FORWARD {
        NativeFunction::ForwardDynamicsDerivatives
    } else {
        NativeFunction::InverseDynamicsDerivatives
    };
    let results = match natively(model, workspace, function, tables, results, &again) {
        Ok(result) => return result,
        Err(results) => results,
    };
    let bad = BadStateSet::default();
    for_each_block(workspace, batch, BLOCKS_PER_CHUNK, results, &|block, first, states, results| {
        let rows = tables.rows(first, states);
        let mut bits = 0;
        block::run(block, Lanewise::<T, FORWARD> { model, states, rows, results, bad: &mut bits });
        bad.add(bits, first);
    });
    bad.into_result(batch)
}

/// The derivatives of one block of states.
struct Lanewise<'a, T, const FORWARD: bool> {
    model: &'a Model,
    states: usize,
    rows: [&'a [T]; 3],
    results: [&'a mut [T]; 3],
    bad: &'a mut u32,
}

impl<T: BatchFloat, const FORWARD: bool> LaneKernel<OverLanes, T> for Lanewise<'_, T, FORWARD> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, states, rows, results, bad } = self;
        let Block { workspace, input, output, .. } = block;
        let size = model.nv * model.nv;
        make_room(output, 3 * size);
        let ([q, v, third], mut poison) = read::<N, H>(rows, states, input);
        let (by_position, rest) = output.split_at_mut(size);
        let (by_velocity, by_force) = rest.split_at_mut(size);
        let wrenches = &[][..];
        if FORWARD {
            let tau = third;
            call::<H, _, _>(
                &mut workspace.tree,
                ForwardDynamicsSlopes { model, q, v, tau, wrenches, by_position, by_velocity, by_force },
            );
        } else {
            let a = third;
            call::<H, _, _>(
                &mut workspace.tree,
                InverseDynamicsSlopes { model, q, v, a, wrenches, by_position, by_velocity },
            );
        }
        let output = &mut output[..if FORWARD { 3 } else { 2 } * size];
        add_poison(&mut poison, output, 1);
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, output);
        }
        for (result, output) in results.into_iter().zip(output.chunks_exact(size)) {
            scatter_all::<N, H>(output, result, size, states);
        }
    }
}

//! The pullback of rollouts of batches.

#[cfg(feature = "native")]
mod native;

use core::marker::PhantomData;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use robot_dynamics_core::{Model, Workspace, parameter_count};
use robot_dynamics_integrators::{Stage, StepScheme};
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};
use robot_dynamics_number::{Float, StateLanes};
use robot_dynamics_simulation::Rollout;
use robot_dynamics_simulation::motion::pullback::course::{RolloutInputs, memory_size, pull_back};
use robot_dynamics_simulation::motion::pullback::stages::{Accelerations, At, Cotangents};

use super::{Outcome, RolloutError, RolloutProgress, Shared, Torques};
use crate::bad_states::states_of;
use crate::block::{Block, OverLanes, add_poison, bad_lanes, gather, make_room, poison_lanes, scatter_all};
use crate::compute::{check_table, check_workspace};
use crate::native::Number;
use crate::pullback::{ForwardPullback, pull_forward};
use crate::recursions::accelerate;
use crate::share::for_each_block;
use crate::{BatchFloat, BatchWorkspace, block};

/// The gradient of a loss along each state's rollout; see
/// [`rollout_pullback`](robot_dynamics_simulation::rollout_pullback). It maps cotangents of the rollout's
/// states to those of the initial state, the forces and the parameters.
///
/// - (`q`, `v`) are the initial states, \[batch\]\[nq\] and \[batch\]\[nv\].
/// - `by_position` and `by_velocity`, \[batch\]\[nv\], hold the gradients by the final states, and receive
///   those by the initial states.
/// - `trajectory` holds the gradients by the recorded states, \[batch\]\[samples\]\[nv\] each; empty without
///   a stride.
/// - `by_force` is overwritten. It has the shape of the torques: \[batch\]\[nv\] if they are held,
///   \[batch\]\[steps\]\[nv\] if each step has its own, and empty without torques.
/// - `parameters` is empty or \[batch\]\[[`parameter_count`]\], one row per state, and overwritten.
///
/// Cotangents of configurations have nv numbers, along the displacements of [`integrate`](robot_dynamics_core::integrate())
/// at that configuration.
///
/// The states are recomputed from a checkpoint at every `spacing`-th step; 0 selects √steps, and `spacing` =
/// steps stores all states. See
/// [`RolloutPullbackWorkspace::new`](robot_dynamics_simulation::RolloutPullbackWorkspace::new), which gives
/// the memory per state. A thread holds one block of lanes, or 32 states with machine code. The states are
/// those of [`rollout`](crate::rollout), bit for bit if machine code takes the steps of both or of neither.
/// With cotangents of parameters the recursions take the steps here, and the states may differ by rounding.
///
/// `progress` is called occasionally from any thread. If it breaks, the states that are not complete keep
/// their `by_position` and `by_velocity`, and their other results are unspecified.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, Rollout, Torques, rollout_pullback};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// use std::ops::ControlFlow;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let integrator = Integrator::SemiImplicitEuler;
/// let how = Rollout::new(integrator, 0.01, 50).with_dissipation(false);
/// // The final speed of three swings, by the torque held over each.
/// let (q, v, tau) = ([0.0, 0.5, 1.0], [0.0; 3], [0.1; 3]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0; 3], [1.0; 3], [0.0; 3]);
/// let (w, go_on) = (&mut BatchWorkspace::<f64>::new(&model), |_| ControlFlow::Continue(()));
/// let (held, results) = (Torques::Held(&tau), (&mut by_q[..], &mut by_v[..]));
/// rollout_pullback(
///     &model, w, &how, 0, held, &q, &v, (&[], &[]), results, &mut by_tau, &mut [], &go_on,
/// )?;
/// assert!(by_tau.iter().all(|x| *x > 0.0 && *x < 50.0 * 0.01 / 0.5)); // h/(m l²) per step at most, reduced by gravity
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid. [`RolloutError::Policy`] if a policy gives
/// the torques, because its derivatives by the state are unknown.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[allow(clippy::too_many_arguments)] // the arguments of a rollout, its cotangents and results
#[track_caller]
pub fn rollout_pullback<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    spacing: usize,
    torques: Torques<'_, T>,
    q: &[T],
    v: &[T],
    trajectory: (&[T], &[T]),
    (by_position, by_velocity): (&mut [T], &mut [T]),
    by_force: &mut [T],
    parameters: &mut [T],
    progress: &(dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
) -> Result<(), RolloutError> {
    let given = PullbackInputs { spacing, torques, q, v, trajectory };
    let results = [by_position, by_velocity, by_force, parameters];
    T::rollout_pullback(model, workspace, rollout, &given, results, progress)
}

/// The inputs of a rollout's pullback.
pub struct PullbackInputs<'a, T> {
    spacing: usize,
    torques: Torques<'a, T>,
    q: &'a [T],
    v: &'a [T],
    trajectory: (&'a [T], &'a [T]),
}

/// The implementation of [`rollout_pullback`], compiled in this crate.
#[track_caller]
pub(crate) fn compute<T: BatchFloat + Number>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    given: &PullbackInputs<'_, T>,
    results: [&mut [T]; 4],
    progress: &(dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
) -> Result<(), RolloutError> {
    check_workspace(model, workspace);
    let (h, nq, nv, integrator) = (rollout.step, model.nq, model.nv, rollout.integrator);
    if !(h > 0.0 && h.is_finite()) {
        return Err(RolloutError::BadStep { step: h });
    }
    let StepScheme::Explicit(stages) = integrator.scheme() else {
        return Err(RolloutError::Implicit { integrator });
    };
    let PullbackInputs { torques, q, v, trajectory, .. } = *given;
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    check_table("the cotangent of the trajectory's q", trajectory.0.len(), batch, rollout.samples() * nv);
    check_table("the cotangent of the trajectory's v", trajectory.1.len(), batch, rollout.samples() * nv);
    let force_width = match torques {
        Torques::Zero => 0,
        Torques::Held(tau) => {
            check_table("tau", tau.len(), batch, nv);
            nv
        }
        Torques::EachStep(tau) => {
            check_table("tau", tau.len(), batch, rollout.steps * nv);
            rollout.steps * nv
        }
        Torques::Policy(_) => return Err(RolloutError::Policy),
    };
    check_table("the cotangent of q", results[0].len(), batch, nv);
    check_table("the cotangent of v", results[1].len(), batch, nv);
    check_table("the cotangent of tau", results[2].len(), batch, force_width);
    let parameters = if results[3].is_empty() { 0 } else { parameter_count(model) };
    check_table("the parameters", results[3].len(), batch, parameters);
    if batch == 0 || nv == 0 {
        return Ok(());
    }
    let shared = Shared {
        progress,
        done: AtomicU64::new(0),
        total: batch as u64 * rollout.steps as u64,
        cancelled: AtomicBool::new(false),
    };
    let outcome = Outcome::default();
    let spacing = rollout.spacing(given.spacing);
    #[cfg(feature = "native")]
    let results = {
        let (way, how) = ((rollout, stages, spacing), (&shared, &outcome));
        match native::pull_back_natively(model, workspace, way, given, results, how) {
            Ok(()) => return outcome.into_result(batch),
            Err(results) => results,
        }
    };
    for_each_block(workspace, batch, 1, results, &|block, first, states, results| {
        let (mut bits, mut finished) = (0, false);
        if !shared.cancelled.load(Ordering::Relaxed) {
            let outputs = (&mut bits, &mut finished);
            let (stages, shared) = ((stages, spacing), &shared);
            block::run(
                block,
                Backward { model, rollout, stages, given, first, states, results, shared, outputs },
            );
        }
        outcome.add(bits, finished, first..first + states);
    });
    outcome.into_result(batch)
}

/// The backward pass of one block.
struct Backward<'a, T> {
    model: &'a Model,
    rollout: &'a Rollout,
    /// The stages, and the number of steps between checkpoints.
    stages: (&'a [Stage], usize),
    given: &'a PullbackInputs<'a, T>,
    first: usize,
    states: usize,
    results: [&'a mut [T]; 4],
    shared: &'a Shared<'a>,
    /// A bit for each bad state, and whether all reached the start.
    outputs: (&'a mut u32, &'a mut bool),
}

impl<T: Float> LaneKernel<OverLanes, T> for Backward<'_, T> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self {
            model,
            rollout,
            stages: (stages, spacing),
            given,
            first,
            states,
            results,
            shared,
            outputs,
        } = self;
        let Block { workspace, input, .. } = block;
        let (nq, nv, hardware) = (model.nq, model.nv, PhantomData::<H>);
        let [by_position, by_velocity, force_rows, parameter_rows] = results;
        let (bad, finished) = outputs;
        let size = memory_size(model, rollout, stages.len(), spacing);
        let parameter_width = parameter_rows.len() / states;
        make_room(input, nq + 5 * nv + parameter_width + size);
        let mut rest = &mut input[..];
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        let (q, v, by_q, by_v) = (take(nq), take(nv), take(nv), take(nv));
        let (by_force, part) = (take(nv), take(nv));
        let (parameters, memory) = (take(parameter_width), take(size));
        gather::<N, H>(&given.q[first * nq..], nq, states, q);
        gather::<N, H>(&given.v[first * nv..], nv, states, v);
        gather::<N, H>(by_position, nv, states, by_q);
        gather::<N, H>(by_velocity, nv, states, by_v);
        by_force.fill(N::zero());
        parameters.fill(N::zero());
        let mut poison = N::zero();
        for numbers in [&*q, &*v, &*by_q, &*by_v] {
            add_poison(&mut poison, numbers, 1);
        }
        let mut course =
            Lanes { rollout, given, first, states, by_force, part, force_rows, poison, shared, hardware };
        let mut accelerations = BlockAccelerations { workspace, hardware };
        let way = (rollout, stages, spacing);
        let sides = (&mut accelerations, &mut course);
        if !pull_back(model, way, sides, memory, (q, v), (by_q, by_v), parameters) {
            return;
        }
        let Lanes { mut poison, by_force, force_rows, .. } = course;
        for numbers in [&*by_q, &*by_v, &*by_force, &*parameters] {
            add_poison(&mut poison, numbers, 1);
        }
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            for numbers in [&mut *by_q, &mut *by_v, &mut *by_force, &mut *parameters] {
                poison_lanes(*bad, numbers);
            }
            spoil(*bad, force_rows, states);
        }
        scatter_all::<N, H>(by_q, by_position, nv, states);
        scatter_all::<N, H>(by_v, by_velocity, nv, states);
        if matches!(given.torques, Torques::Held(_)) {
            scatter_all::<N, H>(by_force, force_rows, nv, states);
        }
        if parameter_width != 0 {
            scatter_all::<N, H>(parameters, parameter_rows, parameter_width, states);
        }
        *finished = true;
    }
}

/// Writes NaN to the rows of bad states.
#[cold]
#[inline(never)]
fn spoil<T: Float>(bad: u32, rows: &mut [T], states: usize) {
    let width = rows.len() / states;
    for state in states_of(bad, 0) {
        rows[state * width..(state + 1) * width].fill(T::from_f64(f64::NAN));
    }
}

/// The forces and cotangents of a block's rollout.
struct Lanes<'a, N: StateLanes, H> {
    rollout: &'a Rollout,
    given: &'a PullbackInputs<'a, N::Float>,
    first: usize,
    states: usize,
    /// The sum of the cotangents of held forces.
    by_force: &'a mut [N],
    part: &'a mut [N],
    force_rows: &'a mut [N::Float],
    poison: N,
    shared: &'a Shared<'a>,
    hardware: PhantomData<H>,
}

impl<N: StateLanes, H: Hardware> RolloutInputs<N> for Lanes<'_, N, H> {
    #[inline(always)]
    fn torque(&mut self, step: usize, tau: &mut [N]) {
        let n = tau.len();
        match self.given.torques {
            Torques::Zero | Torques::Policy(_) => tau.fill(N::zero()),
            Torques::Held(rows) => gather::<N, H>(&rows[self.first * n..], n, self.states, tau),
            Torques::EachStep(rows) => {
                let start = (self.first * self.rollout.steps + step) * n;
                gather::<N, H>(&rows[start..], self.rollout.steps * n, self.states, tau);
            }
        }
    }

    #[inline(always)]
    fn add_cotangents(&mut self, sample: usize, by_position: &mut [N], by_velocity: &mut [N]) {
        let (n, samples) = (by_position.len(), self.rollout.samples());
        let start = (self.first * samples + sample) * n;
        for (rows, to) in [(self.given.trajectory.0, by_position), (self.given.trajectory.1, by_velocity)] {
            gather::<N, H>(&rows[start..], samples * n, self.states, self.part);
            for k in 0..n {
                to[k] += self.part[k];
            }
        }
    }

    #[inline(always)]
    fn take(&mut self, step: usize, by_force: &[N]) {
        let n = by_force.len();
        add_poison(&mut self.poison, by_force, 1);
        match self.given.torques {
            Torques::Zero | Torques::Policy(_) => {}
            Torques::Held(_) => {
                for k in 0..n {
                    self.by_force[k] += by_force[k];
                }
            }
            Torques::EachStep(_) => {
                let rows = &mut self.force_rows[step * n..];
                scatter_all::<N, H>(by_force, rows, self.rollout.steps * n, self.states);
            }
        }
    }

    #[inline(always)]
    fn go_on(&mut self, steps: usize) -> bool {
        self.shared.go_on((self.states * steps) as u64)
    }
}

/// Forward dynamics of a block.
struct BlockAccelerations<'a, N: StateLanes, H> {
    workspace: &'a mut Workspace<N>,
    hardware: PhantomData<H>,
}

impl<N: StateLanes, H: Hardware> Accelerations<N> for BlockAccelerations<'_, N, H> {
    #[inline(always)]
    fn accelerate(&mut self, model: &Model, q: &[N], v: &[N], tau: &[N], a: &mut [N]) {
        accelerate::<N, H>(model, self.workspace, q, v, tau, a);
    }

    #[inline(always)]
    fn pull_back(&mut self, model: &Model, at: At<'_, N>, to: Cotangents<'_, N>) {
        let At { q, v, tau, cotangent } = at;
        let Cotangents { acceleration, by_position, by_velocity, by_force, parameters } = to;
        let to = ForwardPullback { acceleration, by_position, by_velocity, by_force, parameters };
        pull_forward::<N, H>(model, self.workspace, [q, v, tau, cotangent], to);
    }
}

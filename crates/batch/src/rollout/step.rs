//! The steps of one block.

use core::convert::Infallible;
use core::marker::PhantomData;

use robot_dynamics_core::algorithms::dissipation::dissipate;
use robot_dynamics_core::configuration::retraction::move_along;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::Stage;
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};
use robot_dynamics_number::{Float, Scalar, StateLanes};
use robot_dynamics_simulation::Rollout;
use robot_dynamics_simulation::motion::integrate::explicit::{StageSystem, explicit_step};
use robot_dynamics_simulation::motion::integrate::stage_memory::StageMemory;

use super::job::Job;
use super::progress::SharedProgress;
use super::torques::{PolicyInput, PolicyRows, Torques};
use crate::block::{
    Block, BlockStorage, add_poison, bad_lanes, gather, make_room, poison_lanes, scatter_all,
};
use crate::computation::recursions::accelerate;

/// The number of steps between calls of the progress callback.
pub(super) const STEPS_PER_LOOK: usize = 64;

/// A rollout of one block.
pub(super) struct BlockRollout<'a, T> {
    pub model: &'a Model,
    pub rollout: &'a Rollout,
    pub stages: &'a [Stage],
    pub torques: Torques<'a, T>,
    pub job: Job<'a, T>,
    pub shared: &'a SharedProgress<'a>,
    /// A bit for each bad state, and whether all reached the end.
    pub outputs: (&'a mut u32, &'a mut bool),
}

/// A block's state and the memory of a step.
struct BlockState<'a, S> {
    q: &'a mut [S],
    v: &'a mut [S],
    tau: &'a mut [S],
    force: &'a mut [S],
    memory: StageMemory<'a, S>,
}

impl<'a, S> BlockState<'a, S> {
    /// The number of entries that a rollout needs for each state.
    fn size(model: &Model, stages: usize) -> usize {
        model.nq + 3 * model.nv + StageMemory::<S>::size(model, stages)
    }

    fn new(model: &Model, stages: usize, memory: &'a mut [S]) -> Self {
        let (nq, nv) = (model.nq, model.nv);
        let mut rest = memory;
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        let (q, v, tau, force) = (take(nq), take(nv), take(nv), take(nv));
        Self { q, v, tau, force, memory: StageMemory::new(model, stages, rest) }
    }
}

impl<T: Float> LaneKernel<BlockStorage, T> for BlockRollout<'_, T> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, rollout, stages, torques, job, shared, outputs } = self;
        let Block { workspace, input: memory, .. } = block;
        make_room(memory, BlockState::<N>::size(model, stages.len()));
        let (nq, nv, states) = (model.nq, model.nv, job.states);
        let (bad, finished) = outputs;
        let h = N::from_f64(rollout.step);
        let mut at = BlockState::new(model, stages.len(), memory);
        gather::<N, H>(job.q, nq, states, at.q);
        gather::<N, H>(job.v, nv, states, at.v);
        match torques {
            Torques::Held(tau) => gather::<N, H>(&tau[job.first * nv..], nv, states, at.tau),
            Torques::Zero | Torques::EachStep(_) | Torques::Policy(_) => at.tau.fill(N::zero()),
        }
        let mut rows = PolicyRows { q: Vec::new(), v: Vec::new(), tau: Vec::new() };
        if matches!(torques, Torques::Policy(_)) {
            rows = make_rows(states, (nq, nv));
        }
        let samples = rollout.samples();
        let mut looked = 0;
        for done in 0..rollout.steps {
            if done == looked + STEPS_PER_LOOK {
                looked = done;
                if !shared.go_on((states * STEPS_PER_LOOK) as u64) {
                    return;
                }
            }
            match torques {
                Torques::Zero | Torques::Held(_) => {}
                Torques::EachStep(tau) => {
                    let start = (job.first * rollout.steps + done) * nv;
                    gather::<N, H>(&tau[start..], rollout.steps * nv, states, at.tau);
                }
                Torques::Policy(policy) => {
                    let PolicyRows { q, v, tau } = &mut rows;
                    scatter_all::<N, H>(at.q, q, nq, states);
                    scatter_all::<N, H>(at.v, v, nv, states);
                    let (first, time) = (job.first, done as f64 * rollout.step);
                    policy(PolicyInput { first, states, step: done, time, q, v }, tau);
                    gather::<N, H>(tau, nv, states, at.tau);
                }
            }
            advance::<N, H>(model, workspace, (stages, rollout.dissipation), h, &mut at);
            if rollout.stride != 0 && (done + 1) % rollout.stride == 0 {
                let sample = (done + 1) / rollout.stride - 1;
                scatter_all::<N, H>(at.q, &mut job.q_trajectory[sample * nq..], samples * nq, states);
                scatter_all::<N, H>(at.v, &mut job.v_trajectory[sample * nv..], samples * nv, states);
            }
        }
        let mut poison = N::zero();
        add_poison(&mut poison, at.q, 1);
        add_poison(&mut poison, at.v, 1);
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, at.q);
            poison_lanes(*bad, at.v);
        }
        scatter_all::<N, H>(at.q, job.q, nq, states);
        scatter_all::<N, H>(at.v, job.v, nv, states);
        *finished = true;
        shared.go_on((states * (rollout.steps - looked)) as u64);
    }
}

/// Allocates the rows for a policy.
#[inline(never)]
fn make_rows<T: Float>(states: usize, (nq, nv): (usize, usize)) -> PolicyRows<T> {
    let zeros = |count: usize| vec![T::zero(); count];
    PolicyRows { q: zeros(states * nq), v: zeros(states * nv), tau: zeros(states * nv) }
}

/// A block of states under constant forces.
struct BlockMotion<'a, N: Scalar, H> {
    model: &'a Model,
    workspace: &'a mut Workspace<N>,
    dissipation: bool,
    tau: &'a [N],
    /// τ − b(v).
    force: &'a mut [N],
    hardware: PhantomData<H>,
}

impl<N: StateLanes, H: Hardware> StageSystem<N> for BlockMotion<'_, N, H> {
    type Error = Infallible;

    #[inline(always)]
    fn move_along(&self, q: &[N], displacement: &[N], moved: &mut [N]) {
        move_along(self.model, q, displacement, moved);
    }

    #[inline(always)]
    fn accelerate(&mut self, q: &[N], v: &[N], acceleration: &mut [N]) -> Result<(), Infallible> {
        let Self { model, workspace, dissipation, tau, force, .. } = self;
        if *dissipation {
            dissipate(model, v, force);
            for k in 0..force.len() {
                force[k] = tau[k] - force[k];
            }
        } else {
            force.copy_from_slice(tau);
        }
        accelerate::<N, H>(model, workspace, q, v, force, acceleration);
        Ok(())
    }
}

/// One step of a row with explicit stages.
#[inline(always)]
fn advance<N: StateLanes, H: Hardware>(
    model: &Model,
    workspace: &mut Workspace<N>,
    (stages, dissipation): (&[Stage], bool),
    h: N,
    at: &mut BlockState<'_, N>,
) {
    let BlockState { q, v, tau, force, memory } = at;
    let hardware = PhantomData::<H>;
    let mut motion = BlockMotion { model, workspace, dissipation, tau, force, hardware };
    let Ok(()) = explicit_step(model, stages, &mut motion, h, memory, (q, v));
    q.copy_from_slice(memory.q);
    v.copy_from_slice(memory.v);
}

//! The backward pass of one block.

use core::marker::PhantomData;

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::Stage;
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};
use robot_dynamics_number::{Float, StateLanes};
use robot_dynamics_simulation::Rollout;
use robot_dynamics_simulation::motion::pullback::checkpoints::{RolloutInputs, memory_size, pull_back};
use robot_dynamics_simulation::motion::pullback::stages::{Accelerations, Cotangents, PullbackPoint};

use super::inputs::RolloutPullbackInputs;
use crate::block::{
    Block, BlockStorage, add_poison, bad_lanes, gather, make_room, poison_lanes, scatter_all,
};
use crate::computation::pullback::{ForwardPullback, pull_forward};
use crate::computation::recursions::accelerate;
use crate::rollout::bad_rows::spoil;
use crate::rollout::progress::SharedProgress;
use crate::rollout::torques::Torques;

/// The backward pass of one block.
pub(super) struct Backward<'a, T> {
    pub(super) model: &'a Model,
    pub(super) rollout: &'a Rollout,
    /// The stages, and the number of steps between checkpoints.
    pub(super) stages: (&'a [Stage], usize),
    pub(super) given: &'a RolloutPullbackInputs<'a, T>,
    pub(super) first: usize,
    pub(super) states: usize,
    pub(super) results: [&'a mut [T]; 4],
    pub(super) shared: &'a SharedProgress<'a>,
    /// A bit for each bad state, and whether all reached the start.
    pub(super) outputs: (&'a mut u32, &'a mut bool),
}

impl<T: Float> LaneKernel<BlockStorage, T> for Backward<'_, T> {
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

/// The forces and cotangents of a block's rollout.
struct Lanes<'a, N: StateLanes, H> {
    rollout: &'a Rollout,
    given: &'a RolloutPullbackInputs<'a, N::Float>,
    first: usize,
    states: usize,
    /// The sum of the cotangents of held forces.
    by_force: &'a mut [N],
    part: &'a mut [N],
    force_rows: &'a mut [N::Float],
    poison: N,
    shared: &'a SharedProgress<'a>,
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
        for (rows, to) in [
            (self.given.trajectory.by_position, by_position),
            (self.given.trajectory.by_velocity, by_velocity),
        ] {
            gather::<N, H>(&rows[start..], samples * n, self.states, self.part);
            for k in 0..n {
                to[k] += self.part[k];
            }
        }
    }

    #[inline(always)]
    fn record(&mut self, step: usize, by_force: &[N]) {
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
    fn pull_back(&mut self, model: &Model, at: PullbackPoint<'_, N>, to: Cotangents<'_, N>) {
        let PullbackPoint { q, v, tau, cotangent } = at;
        let Cotangents { acceleration, by_position, by_velocity, by_force, parameters } = to;
        let to = ForwardPullback { acceleration, by_position, by_velocity, by_force, parameters };
        pull_forward::<N, H>(model, self.workspace, [q, v, tau, cotangent], to);
    }
}

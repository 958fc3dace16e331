//! Explicit steps of several simulations in the lanes of registers, with the bits of each alone.

use core::convert::Infallible;
use core::marker::PhantomData;
use std::sync::Arc;

use dynamics::{Integrator, Method, Scalar};
use number::dispatch::{Hardware, LaneKernel, LaneMemory, Make};
use number::sine::RANGE;
use number::{Form, Lone, StateLanes, Unfused};

use crate::algorithms::dissipation::dissipate;
use crate::algorithms::energy::Energies;
use crate::algorithms::forward_dynamics::ArticulatedBodies;
use crate::algorithms::rank::check_rank;
use crate::batch::block::{gather, make_room, scatter_all};
use crate::batch::within::call;
use crate::joint::Motion as JointMotion;
use crate::motion::integrate::explicit::{Motion, StageMemory, explicit_step};
use crate::scratch::workspace::Workspace;
use crate::simulator::side_by_side::{StepEnergies, StepStart};
use crate::space::retraction::move_along;
use crate::{Model, neutral};

/// Steps of as many simulations as a register has lanes, of which the first `states` stand in the tables.
#[derive(Debug)]
pub(super) struct LaneSteps {
    model: Arc<Model>,
    memory: LaneMemory<OverLanes>,
    states: usize,
    /// Rows of q, v and τ where the step starts, of q and v at its end, and the energies.
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    q_end: Vec<f64>,
    v_end: Vec<f64>,
    energies: Vec<f64>,
    /// N of each degree of freedom ([`rank`](crate::algorithms::rank)), where it is the same in all configurations; else empty.
    extents: Vec<f64>,
}

/// The outcome of a step in lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LaneStep {
    /// Whether it has the bits of single steps: not where an angle is beyond the range of the lanes' sine.
    pub(super) is_same: bool,
    /// Whether M is regular where the step starts, beyond doubt: the single steps' own test would find the same.
    pub(super) is_regular: bool,
}

impl LaneSteps {
    pub(super) fn new(model: &Arc<Model>) -> Self {
        let memory = LaneMemory::new::<f64>(crate::InstructionSet::best(), &Maker(model));
        let lanes = memory.lanes();
        let table = |width: usize| vec![0.0; lanes * width];
        let (nq, nv) = (model.nq, model.nv);
        Self {
            model: Arc::clone(model),
            memory,
            states: 0,
            q: table(nq),
            v: table(nv),
            tau: table(nv),
            q_end: table(nq),
            v_end: table(nv),
            energies: table(4),
            extents: constant_extents(model),
        }
    }

    /// The robot.
    pub(super) fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// How many simulations go side by side.
    pub(super) fn lanes(&self) -> usize {
        self.memory.lanes()
    }

    /// Takes all states out.
    pub(super) fn clear(&mut self) {
        self.states = 0;
    }

    /// Puts a state in the next lane.
    pub(super) fn push(&mut self, start: &StepStart<'_>) {
        let StepStart { q, v, tau } = *start;
        let k = self.states;
        self.q[k * q.len()..][..q.len()].copy_from_slice(q);
        self.v[k * v.len()..][..v.len()].copy_from_slice(v);
        self.tau[k * v.len()..][..v.len()].copy_from_slice(tau);
        self.states += 1;
    }

    /// Takes a step of each state.
    pub(super) fn step(&mut self, row: Integrator, dissipation: bool, h: f64) -> LaneStep {
        let Self { model, memory, states, q, v, tau, q_end, v_end, energies, extents } = self;
        let mut outcome = LaneStep::default();
        let Method::Explicit(stages) = row.method() else { return outcome };
        memory.run(Step {
            model,
            stages,
            dissipation,
            h,
            states: *states,
            start: (q, v, tau),
            end: (q_end, v_end, energies),
            extents,
            outcome: &mut outcome,
        });
        outcome
    }

    /// The end of a lane's step.
    pub(super) fn end(&self, lane: usize) -> ((&[f64], &[f64]), StepEnergies) {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let (q, v) = (&self.q_end[lane * nq..][..nq], &self.v_end[lane * nv..][..nv]);
        let energies = &self.energies[4 * lane..];
        let [kinetic, potential, work, dissipated] = [energies[0], energies[1], energies[2], energies[3]];
        ((q, v), StepEnergies { kinetic, potential, work, dissipated })
    }
}

/// N of each degree of freedom where joints are hinges alone, whose bodies' origins keep their distances; else nothing.
fn constant_extents(model: &Model) -> Vec<f64> {
    if model.bodies.iter().any(|body| body.motion != JointMotion::Revolute) {
        return Vec::new();
    }
    let mut workspace = Workspace::new(model);
    // It leaves √N behind.
    let _ = check_rank(model, &mut workspace, &neutral(model));
    workspace.rank.root.iter().map(|root| root * root).collect()
}

/// A pivot d that is more than N over this tells that M is regular: its square is 70 times the bound of `check_rank` for pivots that need no further look.
const CLEAR: f64 = 2000.0;

/// A block over each number.
struct OverLanes;

impl Form for OverLanes {
    type Over<S: Scalar> = Block<S>;
}

/// The memory of steps.
struct Block<S: Scalar> {
    workspace: Workspace<Lone<S>>,
    /// The arguments and results of recursions.
    recursion: Vec<Lone<S>>,
    /// The state, the forces and the stages.
    stages: Vec<Unfused<S>>,
    /// As they are read from tables and written to them.
    rows: Vec<S>,
}

struct Maker<'a>(&'a Model);

impl Make<OverLanes> for Maker<'_> {
    fn make<S: Scalar>(&self) -> Block<S> {
        Block {
            workspace: Workspace::scratch(self.0),
            recursion: Vec::new(),
            stages: Vec::new(),
            rows: Vec::new(),
        }
    }
}

/// One step of a block: rows of q, v and τ; of q and v at the end, and K, V, the work and the losses of each state.
struct Step<'a> {
    model: &'a Model,
    stages: &'a [dynamics::Stage],
    dissipation: bool,
    h: f64,
    states: usize,
    start: (&'a [f64], &'a [f64], &'a [f64]),
    end: (&'a mut [f64], &'a mut [f64], &'a mut [f64]),
    extents: &'a [f64],
    outcome: &'a mut LaneStep,
}

impl LaneKernel<OverLanes, f64> for Step<'_> {
    #[inline(always)]
    fn run<N: StateLanes<Float = f64>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, stages, dissipation, h, states, start, end, extents, outcome } = self;
        let Block { workspace, recursion, stages: memory, rows } = block;
        let n = model.nv;
        make_room(rows, n.max(4));
        make_room(recursion, 4 * n);
        make_room(memory, 6 * n + StageMemory::<Unfused<N>>::size(model, stages.len()));
        let mut rest = &mut memory[..];
        let mut take = || rest.split_off_mut(..n).unwrap_or_default();
        let (q, v, tau, force, displacement, middle) = (take(), take(), take(), take(), take(), take());
        read::<N, H>(start.0, states, rows, q);
        read::<N, H>(start.1, states, rows, v);
        read::<N, H>(start.2, states, rows, tau);
        let mut ends = StageMemory::new(model, stages.len(), rest);
        let hardware = PhantomData::<H>;
        let starts_at_q = stages.first().is_some_and(|stage| stage.q_row.is_empty());
        let mut motion = SideBySide {
            model,
            workspace,
            recursion,
            dissipation,
            tau,
            force,
            is_near: true,
            extents: if starts_at_q { extents } else { &[] },
            is_regular: false,
            hardware,
        };
        let h = Unfused(N::from_f64(h));
        let Ok(()) = explicit_step(model, stages, &mut motion, h, &mut ends, (q, v));
        let (q_end, v_end) = (&*ends.q, &*ends.v);
        let (kinetic, potential) = motion.energies(q_end, v_end);
        *outcome = LaneStep { is_same: motion.is_near, is_regular: motion.is_regular };
        // The account of `record_step`.
        for k in 0..n {
            displacement[k] = q_end[k] - q[k];
        }
        let three_halves = Unfused::<N>::from_f64(1.5) / h;
        for k in 0..n {
            middle[k] = three_halves * displacement[k] - (v[k] + v_end[k]).scale(0.25);
        }
        let mut dissipated = Unfused::zero();
        if dissipation {
            let first = power(model, v, force);
            let second = power(model, middle, force);
            let third = power(model, v_end, force);
            dissipated = (first + second.scale(4.0) + third) * (h / Unfused::from_f64(6.0));
        }
        let energies = [kinetic, potential, dot(tau, displacement).0, dissipated.0];
        write::<N, H>(q_end, rows, states, end.0);
        write::<N, H>(v_end, rows, states, end.1);
        scatter_all::<N, H>(&energies, end.2, 4, states);
    }
}

/// From rows of a table, by way of the memory `rows`.
#[inline(always)]
fn read<N: StateLanes<Float = f64>, H: Hardware>(
    table: &[f64],
    states: usize,
    rows: &mut [N],
    to: &mut [Unfused<N>],
) {
    let n = to.len();
    gather::<N, H>(table, n, states, &mut rows[..n]);
    for k in 0..n {
        to[k] = Unfused(rows[k]);
    }
}

/// The reverse of [`read`].
#[inline(always)]
fn write<N: StateLanes<Float = f64>, H: Hardware>(
    from: &[Unfused<N>],
    rows: &mut [N],
    states: usize,
    table: &mut [f64],
) {
    let n = from.len();
    for k in 0..n {
        rows[k] = from[k].0;
    }
    scatter_all::<N, H>(&rows[..n], table, n, states);
}

/// b(v)·v.
#[inline(always)]
fn power<S: Scalar>(model: &Model, v: &[S], force: &mut [S]) -> S {
    dissipate(model, v, force);
    dot(force, v)
}

#[inline(always)]
fn dot<S: Scalar>(a: &[S], b: &[S]) -> S {
    let mut sum = S::zero();
    for (a, b) in a.iter().zip(b) {
        sum += *a * *b;
    }
    sum
}

/// States under held forces.
struct SideBySide<'a, N: Scalar, H> {
    model: &'a Model,
    workspace: &'a mut Workspace<Lone<N>>,
    recursion: &'a mut [Lone<N>],
    dissipation: bool,
    tau: &'a [Unfused<N>],
    /// τ − b(v).
    force: &'a mut [Unfused<N>],
    /// Whether all angles are within the range of the sine.
    is_near: bool,
    /// N of each degree of freedom, to be compared with its pivot in the first stage; empty afterwards.
    extents: &'a [f64],
    is_regular: bool,
    hardware: PhantomData<H>,
}

impl<N: StateLanes, H: Hardware> SideBySide<'_, N, H> {
    /// K and V.
    #[inline(always)]
    fn energies(&mut self, q: &[Unfused<N>], v: &[Unfused<N>]) -> (N, N) {
        let (mut kinetic, mut potential) = (Lone::zero(), Lone::zero());
        let (at, rest) = self.recursion.split_at_mut(q.len());
        let rate = &mut rest[..v.len()];
        for k in 0..v.len() {
            (at[k], rate[k]) = (Lone(q[k].0), Lone(v[k].0));
            self.is_near &= q[k].0.all_within(RANGE);
        }
        let (model, energies) = (self.model, (&mut kinetic, &mut potential));
        call::<H, _, _>(&mut self.workspace.tree, Energies { model, q: at, v: rate, energies });
        (kinetic.0, potential.0)
    }
}

impl<N: StateLanes, H: Hardware> Motion<Unfused<N>> for SideBySide<'_, N, H> {
    type Error = Infallible;

    #[inline(always)]
    fn move_along(&self, q: &[Unfused<N>], displacement: &[Unfused<N>], moved: &mut [Unfused<N>]) {
        move_along(self.model, q, displacement, moved);
    }

    #[inline(always)]
    fn accelerate(
        &mut self,
        q: &[Unfused<N>],
        v: &[Unfused<N>],
        acceleration: &mut [Unfused<N>],
    ) -> Result<(), Infallible> {
        let Self {
            model, workspace, recursion, dissipation, tau, force, is_near, extents, is_regular, ..
        } = self;
        let n = v.len();
        let (at, rest) = recursion.split_at_mut(n);
        let (rate, rest) = rest.split_at_mut(n);
        let (net, result) = rest.split_at_mut(n);
        if *dissipation {
            dissipate(model, v, force);
            for k in 0..n {
                force[k] = tau[k] - force[k];
            }
        } else {
            force.copy_from_slice(tau);
        }
        for k in 0..n {
            (at[k], rate[k], net[k]) = (Lone(q[k].0), Lone(v[k].0), Lone(force[k].0));
            *is_near &= q[k].0.all_within(RANGE);
        }
        let recursion =
            ArticulatedBodies { model, q: at, v: rate, tau: net, wrenches: &[], acceleration: result };
        call::<H, _, _>(&mut workspace.tree, recursion);
        if !extents.is_empty() {
            *is_regular = true;
            for (pivot, extent) in workspace.tree.inertias.pivot.iter().zip(*extents) {
                // 0 < N/d < CLEAR.
                let ratio = pivot.inverse.0 * N::from_f64(*extent) - N::from_f64(0.5 * CLEAR);
                *is_regular &= ratio.all_within(0.5 * CLEAR);
            }
            *extents = &[];
        }
        for k in 0..n {
            acceleration[k] = Unfused(result[k].0);
        }
        Ok(())
    }
}

//! The steps of one block.

use dynamics::{Integrator, Scalar};
use number::dispatch::{Hardware, LaneKernel};
use number::{Float, StateLanes};

use super::{Job, Rollout, Shared, Torques};
use crate::Model;
use crate::batch::block::{
    Block, OverLanes, add_poison, bad_lanes, gather, make_room, poison_lanes, scatter_all,
};
use crate::batch::recursions::accelerate;
use crate::batch::retraction::{move_along, store, vector};
use crate::joint::Chart;
use crate::scratch::workspace::Workspace;
use crate::space::configuration::{Stretch, stretches};
use crate::spatial::algebra::V3;

/// Steps between two looks at the progress callback.
const STEPS_PER_LOOK: usize = 64;

/// A rollout of one block.
pub(super) struct Advance<'a, T> {
    pub model: &'a Model,
    pub rollout: &'a Rollout,
    pub torques: Torques<'a, T>,
    pub job: Job<'a, T>,
    pub shared: &'a Shared<'a>,
    /// The bits of the bad states, and whether all have come to the end.
    pub outputs: (&'a mut u32, &'a mut bool),
}

/// Numbers of each state that a rollout needs.
fn memory_size(model: &Model) -> usize {
    2 * model.nq + 8 * model.nv
}

/// A block's state and the scratch of a step.
struct Moving<'a, S> {
    q: &'a mut [S],
    v: &'a mut [S],
    tau: &'a mut [S],
    /// τ − b(v).
    force: &'a mut [S],
    acceleration: &'a mut [S],
    displacement: &'a mut [S],
    q_stage: &'a mut [S],
    v_stage: &'a mut [S],
    /// Weighted sums of the stages' Θ̇ and acceleration.
    rate_sum: &'a mut [S],
    acceleration_sum: &'a mut [S],
}

impl<'a, S> Moving<'a, S> {
    fn new(model: &Model, memory: &'a mut [S]) -> Self {
        let (nq, nv) = (model.nq, model.nv);
        let mut rest = memory;
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        Self {
            q: take(nq),
            v: take(nv),
            tau: take(nv),
            force: take(nv),
            acceleration: take(nv),
            displacement: take(nv),
            q_stage: take(nq),
            v_stage: take(nv),
            rate_sum: take(nv),
            acceleration_sum: take(nv),
        }
    }
}

impl<T: Float> LaneKernel<OverLanes, T> for Advance<'_, T> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, rollout, torques, job, shared, outputs } = self;
        let Block { workspace, input: memory, .. } = block;
        make_room(memory, memory_size(model));
        let (nq, nv, states) = (model.nq, model.nv, job.states);
        let (bad, finished) = outputs;
        let h = N::from_f64(rollout.step);
        let mut at = Moving::new(model, memory);
        gather::<N, H>(job.q, nq, states, at.q);
        gather::<N, H>(job.v, nv, states, at.v);
        match torques {
            Torques::Held(tau) => gather::<N, H>(&tau[job.first * nv..], nv, states, at.tau),
            Torques::Zero | Torques::EachStep(_) => at.tau.fill(N::zero()),
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
            if let Torques::EachStep(tau) = torques {
                let start = (job.first * rollout.steps + done) * nv;
                gather::<N, H>(&tau[start..], rollout.steps * nv, states, at.tau);
            }
            advance::<N, H>(model, workspace, rollout, h, &mut at);
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

/// (where a stage is reached from the one before, as a fraction of h; its weight in the sum)
const RUNGE_KUTTA: &[(f64, f64)] = &[(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)];
const EULER: &[(f64, f64)] = &[(0.0, 1.0)];

/// One step: the stages of (Θ, v), where q = q₀ ⊕ Θ, then their weighted sum. Semi-implicit Euler has one stage
/// and moves q by the new v. **(HLW §I.1.2, §IV.8)**
#[inline(always)]
fn advance<N: StateLanes, H: Hardware>(
    model: &Model,
    workspace: &mut Workspace<N>,
    rollout: &Rollout,
    h: N,
    at: &mut Moving<'_, N>,
) {
    let nv = model.nv;
    let is_euler = rollout.integrator == Integrator::SemiImplicitEuler;
    at.rate_sum.fill(N::zero());
    at.acceleration_sum.fill(N::zero());
    for &(reach, weight) in if is_euler { EULER } else { RUNGE_KUTTA } {
        if reach == 0.0 {
            at.displacement.fill(N::zero());
            at.v_stage.copy_from_slice(at.v);
            at.q_stage.copy_from_slice(at.q);
        } else {
            let reach = h.scale(reach);
            for k in 0..nv {
                at.displacement[k] *= reach;
                let v = reach.mul_add(at.acceleration[k], at.v[k]);
                at.v_stage[k] = v;
            }
            move_along(model, at.q, at.displacement, at.q_stage);
        }
        drive(model, rollout.dissipation, at.v_stage, at.tau, at.force);
        accelerate::<N, H>(model, workspace, at.q_stage, at.v_stage, at.force, at.acceleration);
        displacement_rate(model, at.displacement, at.v_stage);
        let weight = N::from_f64(weight);
        for k in 0..nv {
            let rate = weight.mul_add(at.displacement[k], at.rate_sum[k]);
            at.rate_sum[k] = rate;
            let sum = weight.mul_add(at.acceleration[k], at.acceleration_sum[k]);
            at.acceleration_sum[k] = sum;
        }
    }
    let share = if is_euler { h } else { h.scale(1.0 / 6.0) };
    for k in 0..nv {
        let v = share.mul_add(at.acceleration_sum[k], at.v[k]);
        at.v[k] = v;
        at.displacement[k] = share * if is_euler { v } else { at.rate_sum[k] };
    }
    move_along(model, at.q, at.displacement, at.q_stage);
    at.q.copy_from_slice(at.q_stage);
}

/// τ − b(v).
#[inline(always)]
fn drive<N: StateLanes>(model: &Model, dissipation: bool, v: &[N], tau: &[N], force: &mut [N]) {
    force.copy_from_slice(tau);
    if !dissipation {
        return;
    }
    for dof in &model.dofs {
        let rate = v[dof.coordinate].scale(dof.ratio);
        let lost = rate.scale(dof.passive.damping) + rate.signum0().scale(dof.passive.friction);
        let left = force[dof.coordinate] - lost.scale(dof.ratio);
        force[dof.coordinate] = left;
    }
}

/// Θ ← Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\]. **(HLW §IV.8)**
#[inline(always)]
fn displacement_rate<N: StateLanes>(model: &Model, theta: &mut [N], v: &[N]) {
    for Stretch { chart, v: k, .. } in stretches(model) {
        match chart {
            Chart::Line => theta[k] = v[k],
            Chart::Rotation => {
                let (t, w) = (vector(theta, k), vector(v, k));
                let once = t.cross(w);
                store(corrected(w, once, t.cross(once)), &mut theta[k..]);
            }
            Chart::Placement => {
                let t = (vector(theta, k), vector(theta, k + 3));
                let w = (vector(v, k), vector(v, k + 3));
                let once = bracket(t, w);
                let twice = bracket(t, once);
                store(corrected(w.0, once.0, twice.0), &mut theta[k..]);
                store(corrected(w.1, once.1, twice.1), &mut theta[k + 3..]);
            }
        }
    }
}

/// w + ½a + ¹⁄₁₂b.
#[inline(always)]
fn corrected<N: Scalar>(w: V3<N>, a: V3<N>, b: V3<N>) -> V3<N> {
    w.add_scaled(N::from_f64(0.5), a).add_scaled(N::from_f64(1.0 / 12.0), b)
}

/// The Lie bracket of se(3), linear part first. **(MR §8.2.2)**
#[inline(always)]
fn bracket<N: Scalar>(a: (V3<N>, V3<N>), b: (V3<N>, V3<N>)) -> (V3<N>, V3<N>) {
    (a.1.cross(b.0) + a.0.cross(b.1), a.1.cross(b.1))
}

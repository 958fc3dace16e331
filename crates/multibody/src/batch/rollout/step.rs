//! The steps of one block.

use dynamics::{Integrator, Scalar, StateLanes};

use super::{Job, Rollout, Shared, Torques};
use crate::Model;
use crate::algebra::V3;
use crate::batch::block::{add_poison, bad_lanes, gather, never_runs, poison_lanes, scatter_all};
use crate::batch::recursions::accelerate;
use crate::batch::retraction::{move_along, store, vector};
use crate::configuration::{Chart, Stretch, stretches};
use crate::dispatch::{Route, Task};
use crate::workspace::Workspace;

/// Steps between two looks at the progress callback.
const STEPS_PER_LOOK: usize = 64;

/// A rollout of one block.
pub(super) struct Advance<'a, S: StateLanes> {
    pub model: &'a Model,
    pub rollout: &'a Rollout,
    /// h.
    pub step: S,
    pub torques: Torques<'a, S::Float>,
    pub job: Job<'a, S::Float>,
    pub memory: &'a mut [S],
    pub shared: &'a Shared<'a>,
    /// The bits of the bad states, and whether all have come to the end.
    pub outputs: (&'a mut u32, &'a mut bool),
}

/// Numbers of each state that a rollout needs.
pub(super) fn memory_size(model: &Model) -> usize {
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

impl<S: StateLanes> Task<S> for Advance<'_, S> {
    #[inline(always)]
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>) {
        if const { never_runs::<S, R>() } {
            unreachable!("several lanes are chosen only where a register holds them");
        }
        let Self { model, rollout, step, torques, job, memory, shared, outputs } = self;
        let (nq, nv, states) = (model.nq, model.nv, job.states);
        let (bad, finished) = outputs;
        let mut at = Moving::new(model, memory);
        gather::<S, R>(workspace, job.q, nq, states, at.q);
        gather::<S, R>(workspace, job.v, nv, states, at.v);
        match torques {
            Torques::Held(tau) => gather::<S, R>(workspace, &tau[job.first * nv..], nv, states, at.tau),
            Torques::Zero | Torques::EachStep(_) => at.tau.fill(S::zero()),
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
                gather::<S, R>(workspace, &tau[start..], rollout.steps * nv, states, at.tau);
            }
            advance::<S, R>(model, workspace, rollout, R::load(step), &mut at);
            if rollout.stride != 0 && (done + 1) % rollout.stride == 0 {
                let sample = (done + 1) / rollout.stride - 1;
                scatter_all::<S, R>(
                    workspace,
                    at.q,
                    &mut job.q_trajectory[sample * nq..],
                    samples * nq,
                    states,
                );
                scatter_all::<S, R>(
                    workspace,
                    at.v,
                    &mut job.v_trajectory[sample * nv..],
                    samples * nv,
                    states,
                );
            }
        }
        let mut poison = R::Number::zero();
        add_poison::<S, R>(&mut poison, at.q, 1);
        add_poison::<S, R>(&mut poison, at.v, 1);
        *bad = bad_lanes::<S, R>(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, at.q);
            poison_lanes(*bad, at.v);
        }
        scatter_all::<S, R>(workspace, at.q, job.q, nq, states);
        scatter_all::<S, R>(workspace, at.v, job.v, nv, states);
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
fn advance<S: StateLanes, R: Route<S>>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    rollout: &Rollout,
    h: R::Number,
    at: &mut Moving<'_, S>,
) {
    let nv = model.nv;
    let is_euler = rollout.integrator == Integrator::SemiImplicitEuler;
    at.rate_sum.fill(S::zero());
    at.acceleration_sum.fill(S::zero());
    for &(reach, weight) in if is_euler { EULER } else { RUNGE_KUTTA } {
        if reach == 0.0 {
            at.displacement.fill(S::zero());
            at.v_stage.copy_from_slice(at.v);
            at.q_stage.copy_from_slice(at.q);
        } else {
            let reach = h.scale(reach);
            for k in 0..nv {
                at.displacement[k] = R::store(R::load(at.displacement[k]) * reach);
                let v = reach.mul_add(R::load(at.acceleration[k]), R::load(at.v[k]));
                at.v_stage[k] = R::store(v);
            }
            move_along::<S, R>(model, at.q, at.displacement, at.q_stage);
        }
        drive::<S, R>(model, rollout.dissipation, at.v_stage, at.tau, at.force);
        accelerate::<S, R>(model, workspace, at.q_stage, at.v_stage, at.force, at.acceleration);
        displacement_rate::<S, R>(model, at.displacement, at.v_stage);
        let weight = R::Number::from_f64(weight);
        for k in 0..nv {
            let rate = weight.mul_add(R::load(at.displacement[k]), R::load(at.rate_sum[k]));
            at.rate_sum[k] = R::store(rate);
            let sum = weight.mul_add(R::load(at.acceleration[k]), R::load(at.acceleration_sum[k]));
            at.acceleration_sum[k] = R::store(sum);
        }
    }
    let share = if is_euler { h } else { h.scale(1.0 / 6.0) };
    for k in 0..nv {
        let v = share.mul_add(R::load(at.acceleration_sum[k]), R::load(at.v[k]));
        at.v[k] = R::store(v);
        at.displacement[k] = R::store(share * if is_euler { v } else { R::load(at.rate_sum[k]) });
    }
    move_along::<S, R>(model, at.q, at.displacement, at.q_stage);
    at.q.copy_from_slice(at.q_stage);
}

/// τ − b(v).
#[inline(always)]
fn drive<S: StateLanes, R: Route<S>>(model: &Model, dissipation: bool, v: &[S], tau: &[S], force: &mut [S]) {
    force.copy_from_slice(tau);
    if !dissipation {
        return;
    }
    for dof in &model.dofs {
        let rate = R::load(v[dof.coordinate]).scale(dof.ratio);
        let lost = rate.scale(dof.passive.damping) + rate.signum0().scale(dof.passive.friction);
        let left = R::load(force[dof.coordinate]) - lost.scale(dof.ratio);
        force[dof.coordinate] = R::store(left);
    }
}

/// Θ ← Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\]. **(HLW §IV.8)**
#[inline(always)]
fn displacement_rate<S: StateLanes, R: Route<S>>(model: &Model, theta: &mut [S], v: &[S]) {
    for Stretch { chart, v: k, .. } in stretches(model) {
        match chart {
            Chart::Line => theta[k] = v[k],
            Chart::Rotation => {
                let (t, w) = (vector::<S, R>(theta, k), vector::<S, R>(v, k));
                let once = t.cross(w);
                store::<S, R>(corrected(w, once, t.cross(once)), &mut theta[k..]);
            }
            Chart::Placement => {
                let t = (vector::<S, R>(theta, k), vector::<S, R>(theta, k + 3));
                let w = (vector::<S, R>(v, k), vector::<S, R>(v, k + 3));
                let once = bracket(t, w);
                let twice = bracket(t, once);
                store::<S, R>(corrected(w.0, once.0, twice.0), &mut theta[k..]);
                store::<S, R>(corrected(w.1, once.1, twice.1), &mut theta[k + 3..]);
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

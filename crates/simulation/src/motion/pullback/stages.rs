//! The adjoint of explicit stages, for any row of the table and over any number type.
//!
//! It evaluates and stores the stages of
//! [`explicit_step`](crate::motion::integrate::explicit::explicit_step),
//!
//! ```text
//! vᵢ = v₀ + h Σ aᵢⱼ v̇ⱼ,  Θᵢ = h Σ âᵢⱼ Θ̇ⱼ,  v̇ᵢ = v̇(q₀ ⊕ Θᵢ, vᵢ),  Θ̇ᵢ = Θ̇(Θᵢ, vᵢ);
//! v₁ = v₀ + h Σ bᵢ v̇ᵢ,  q₁ = q₀ ⊕ h Σ b̂ᵢ Θ̇ᵢ.
//! ```
//!
//! With x̄ the gradient by x, it then proceeds from the last stage to the first:
//!
//! - Start: (q̄₀, Θ̄) follow from q̄₁ through ⊕; Θ̇̄ᵢ = h b̂ᵢ Θ̄, v̇̄ᵢ = h bᵢ v̄₁, v̄₀ = v̄₁.
//! - Stage i: (Θ̄ᵢ, v̄ᵢ) follow from Θ̇̄ᵢ through Θ̇; v̇̄ᵢ adds to (q̄ᵢ, v̄ᵢ) through v̇; q̄ᵢ adds to (q̄₀,
//!   Θ̄ᵢ) through ⊕.
//! - Then h âᵢⱼ Θ̄ᵢ adds to Θ̇̄ⱼ, h aᵢⱼ v̄ᵢ adds to v̇̄ⱼ, and v̄ᵢ adds to v̄₀.

use core::convert::Infallible;

use robot_dynamics_core::Model;
use robot_dynamics_core::algorithms::dissipation::dissipate;
use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::configuration::retraction::move_along;
use robot_dynamics_core::configuration::retraction_pullback::{pull_move, pull_rate};
use robot_dynamics_core::derivatives::pull_dissipation;
use robot_dynamics_integrators::Stage;
use robot_dynamics_number::Scalar;

use crate::motion::integrate::explicit::StageSystem;
use crate::motion::integrate::vectors::{scale, start_from, sum_stages};

/// Forward dynamics and its pullback, for one state or for several states in lanes.
pub trait Accelerations<S: Scalar> {
    /// a at (q, v) under τ.
    fn accelerate(&mut self, model: &Model, q: &[S], v: &[S], tau: &[S], a: &mut [S]);

    /// Computes the cotangents of q, v and τ from that of a, and adds those of the parameters.
    fn pull_back(&mut self, model: &Model, at: PullbackPoint<'_, S>, to: Cotangents<'_, S>);

    /// The pullback of a whole step of h from q and v under τ by machine code. It transforms the cotangents
    /// of the step's end in place, and writes that of τ. Returns whether such code exists. It does not
    /// compute cotangents of parameters.
    fn pull_back_natively(
        &mut self,
        _: &Model,
        _: [&[S]; 3],
        _: S,
        _: (&mut [S], &mut [S]),
        _: &mut [S],
    ) -> bool {
        false
    }
}

/// The state at which forward dynamics is pulled back, and the cotangent of a.
pub struct PullbackPoint<'a, S> {
    pub q: &'a [S],
    pub v: &'a [S],
    pub tau: &'a [S],
    pub cotangent: &'a [S],
}

/// The results, including the acceleration.
pub struct Cotangents<'a, S> {
    pub acceleration: &'a mut [S],
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
    pub by_force: &'a mut [S],
    pub parameters: &'a mut [S],
}

/// A tree under forces that are constant over a step.
pub struct PullbackTree<'a, S, A> {
    pub model: &'a Model,
    pub accelerations: &'a mut A,
    pub dissipation: bool,
    pub tau: &'a [S],
    /// Scratch: τ − b(v), an acceleration and a cotangent of τ.
    pub force: &'a mut [S],
    pub acceleration: &'a mut [S],
    pub by_stage_force: &'a mut [S],
    /// Accumulates the cotangent of τ, and those of the parameters.
    pub by_force: &'a mut [S],
    pub parameters: &'a mut [S],
}

impl<S: Scalar, A> PullbackTree<'_, S, A> {
    /// τ − b(v).
    #[inline(always)]
    fn net_force(&mut self, v: &[S]) {
        let Self { tau, force, .. } = self;
        if self.dissipation {
            dissipate(self.model, v, force);
            for k in 0..force.len() {
                force[k] = tau[k] - force[k];
            }
        } else {
            force.copy_from_slice(tau);
        }
    }
}

impl<S: Scalar, A: Accelerations<S>> StageSystem<S> for PullbackTree<'_, S, A> {
    type Error = Infallible;

    #[inline(always)]
    fn move_along(&self, q: &[S], displacement: &[S], moved: &mut [S]) {
        move_along(self.model, q, displacement, moved);
    }

    #[inline(always)]
    fn accelerate(&mut self, q: &[S], v: &[S], acceleration: &mut [S]) -> Result<(), Infallible> {
        self.net_force(v);
        self.accelerations.accelerate(self.model, q, v, self.force, acceleration);
        Ok(())
    }
}

impl<S: Scalar, A: Accelerations<S>> PullbackTree<'_, S, A> {
    /// The cotangents of q and v from that of v̇; those of τ and of the parameters are accumulated.
    #[inline(always)]
    fn pull_back(
        &mut self,
        (q, v): (&[S], &[S]),
        cotangent: &[S],
        by_position: &mut [S],
        by_velocity: &mut [S],
    ) {
        self.net_force(v);
        let Self { model, accelerations, tau: _, force, acceleration, by_stage_force, by_force, .. } = self;
        let parameters = &mut *self.parameters;
        accelerations.pull_back(
            model,
            PullbackPoint { q, v, tau: force, cotangent },
            Cotangents { acceleration, by_position, by_velocity, by_force: by_stage_force, parameters },
        );
        if self.dissipation {
            pull_dissipation(model, v, by_stage_force, -1.0, by_velocity, parameters);
        }
        add(by_force, by_stage_force);
    }
}

/// x ← x + y.
#[inline(always)]
pub(super) fn add<S: Scalar>(x: &mut [S], y: &[S]) {
    for k in 0..x.len() {
        x[k] += y[k];
    }
}

/// The memory of a step's pullback, cut from one slice.
pub struct PullbackMemory<'a, S> {
    /// For all stages.
    q: &'a mut [S],
    v: &'a mut [S],
    /// For all stages and the end.
    displacement: &'a mut [S],
    rates: &'a mut [S],
    accelerations: &'a mut [S],
    /// The cotangents of the preceding two.
    by_rate: &'a mut [S],
    by_acceleration: &'a mut [S],
    /// Cotangents of one stage.
    by_position: &'a mut [S],
    by_velocity: &'a mut [S],
    by_displacement: &'a mut [S],
    /// Summands of these, and q̄₀.
    part: &'a mut [S],
    other: &'a mut [S],
    start: &'a mut [S],
}

impl<'a, S> PullbackMemory<'a, S> {
    /// The number of entries that a step with this many stages needs; it exceeds that of the step itself.
    pub fn size(model: &Model, stages: usize) -> usize {
        stages * (model.nq + 6 * model.nv) + 7 * model.nv + model.nq
    }

    pub fn new(model: &Model, stages: usize, memory: &'a mut [S]) -> Self {
        let (nq, nv) = (model.nq, model.nv);
        let mut rest = memory;
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        Self {
            q: take(stages * nq),
            v: take(stages * nv),
            displacement: take((stages + 1) * nv),
            rates: take(stages * nv),
            accelerations: take(stages * nv),
            by_rate: take(stages * nv),
            by_acceleration: take(stages * nv),
            by_position: take(nv),
            by_velocity: take(nv),
            by_displacement: take(nv),
            part: take(nv),
            other: take(nv),
            start: take(nv),
        }
    }
}

/// Pulls the cotangents at the end of the step from (q, v) over h back to its start, in place. `known` holds
/// the accelerations of all stages if the step stored them, and is empty otherwise.
#[inline(always)]
pub fn pull_back_step<S: Scalar, A: Accelerations<S>>(
    model: &Model,
    stages: &[Stage],
    motion: &mut PullbackTree<'_, S, A>,
    h: S,
    memory: &mut PullbackMemory<'_, S>,
    (q, v, known): (&[S], &[S], &[S]),
    (by_q, by_v): (&mut [S], &mut [S]),
) {
    run_stages(model, stages, motion, h, memory, (q, v, known));
    let (nq, nv, last) = (model.nq, model.nv, stages.len());
    let PullbackMemory {
        q: q_stages,
        v: v_stages,
        displacement,
        by_rate,
        by_acceleration,
        by_position,
        by_velocity,
        by_displacement,
        part,
        other,
        start,
        ..
    } = memory;
    pull_move(model, &displacement[last * nv..], by_q, start, by_displacement);
    for (i, stage) in stages.iter().enumerate() {
        set_scaled(&mut by_rate[i * nv..(i + 1) * nv], h.scale(stage.q_weight), by_displacement);
        set_scaled(&mut by_acceleration[i * nv..(i + 1) * nv], h.scale(stage.v_weight), by_v);
    }
    for (i, stage) in stages.iter().enumerate().rev() {
        let stays = stage.q_row.is_empty();
        let rows = i * nv..(i + 1) * nv;
        let (theta, v_stage) = (&displacement[rows.clone()], &v_stages[rows.clone()]);
        by_velocity.fill(S::zero());
        by_displacement.fill(S::zero());
        if Stage::needs_rate(stages, i) {
            if stays {
                by_velocity.copy_from_slice(&by_rate[rows.clone()]);
            } else {
                pull_rate(model, (theta, v_stage), &by_rate[rows.clone()], by_displacement, by_velocity);
            }
        }
        if Stage::needs_acceleration(stages, i) {
            let at = (&q_stages[i * nq..(i + 1) * nq], v_stage);
            motion.pull_back(at, &by_acceleration[rows], by_position, part);
            add(by_velocity, part);
            if stays {
                add(start, by_position);
            } else {
                pull_move(model, theta, by_position, part, other);
                add(start, part);
                add(by_displacement, other);
            }
        }
        for (j, &k) in stage.q_row.iter().enumerate().filter(|(_, k)| **k != 0.0) {
            add_scaled(&mut by_rate[j * nv..(j + 1) * nv], h.scale(k), by_displacement);
        }
        for (j, &k) in stage.v_row.iter().enumerate().filter(|(_, k)| **k != 0.0) {
            add_scaled(&mut by_acceleration[j * nv..(j + 1) * nv], h.scale(k), by_velocity);
        }
        add(by_v, by_velocity);
    }
    by_q.copy_from_slice(start);
}

/// Computes and stores the stages of the step: q, v, Θ, Θ̇ and, if a later stage depends on it, v̇.
#[inline(always)]
fn run_stages<S: Scalar, A: Accelerations<S>>(
    model: &Model,
    stages: &[Stage],
    motion: &mut PullbackTree<'_, S, A>,
    h: S,
    memory: &mut PullbackMemory<'_, S>,
    (q, v, known): (&[S], &[S], &[S]),
) {
    let (nq, nv) = (model.nq, model.nv);
    let PullbackMemory { q: q_stages, v: v_stages, displacement, rates, accelerations, .. } = memory;
    for (i, stage) in stages.iter().enumerate() {
        let (stays, rows) = (stage.q_row.is_empty(), i * nv..(i + 1) * nv);
        let (q_stage, v_stage) = (&mut q_stages[i * nq..(i + 1) * nq], &mut v_stages[rows.clone()]);
        let theta = &mut displacement[rows.clone()];
        if stage.v_row.is_empty() {
            v_stage.copy_from_slice(v);
        } else {
            sum_stages(stage.v_row.len(), |j| stage.v_row[j], accelerations, v_stage);
            start_from(v, h, v_stage);
        }
        if stays {
            q_stage.copy_from_slice(q);
        } else {
            sum_stages(stage.q_row.len(), |j| stage.q_row[j], rates, theta);
            scale(h, theta);
            move_along(model, q, theta, q_stage);
        }
        if stages.iter().any(|later| later.v_row.get(i).is_some_and(|&k| k != 0.0)) {
            let own = &mut accelerations[rows.clone()];
            if known.is_empty() {
                let Ok(()) = motion.accelerate(q_stage, v_stage, own);
            } else {
                own.copy_from_slice(&known[rows.clone()]);
            }
        }
        if Stage::needs_rate(stages, i) {
            if stays {
                // Θ = 0.
                rates[rows].copy_from_slice(v_stage);
            } else {
                displacement_rate(model, theta, v_stage, &mut rates[rows]);
            }
        }
    }
    let theta = &mut displacement[stages.len() * nv..];
    sum_stages(stages.len(), |j| stages[j].q_weight, rates, theta);
    scale(h, theta);
}

/// x ← k y.
#[inline(always)]
fn set_scaled<S: Scalar>(x: &mut [S], k: S, y: &[S]) {
    for i in 0..x.len() {
        x[i] = k * y[i];
    }
}

/// x ← x + k y.
#[inline(always)]
fn add_scaled<S: Scalar>(x: &mut [S], k: S, y: &[S]) {
    for i in 0..x.len() {
        x[i] = k.mul_add(y[i], x[i]);
    }
}

//! Explicit stages on a tree: for one state and for batches, free and under constraints.

use dynamics::{DynamicsError, Integrator, Method, Scalar, Stage, check_finite};

use super::{StepForces, StepWorkspace, accelerate};
use crate::model::native::NativeFunction;
use crate::scratch::native::computed_natively;
use crate::space::displacement_rate::displacement_rate;
use crate::{Model, Workspace, integrate};

/// What the stages are taken of.
pub(crate) trait Motion<S: Scalar> {
    /// Why there is no acceleration.
    type Error;

    /// `moved` = q ⊕ δ.
    fn move_along(&self, q: &[S], displacement: &[S], moved: &mut [S]);

    /// v̇ at a stage.
    fn accelerate(&mut self, q: &[S], v: &[S], acceleration: &mut [S]) -> Result<(), Self::Error>;
}

/// Memory of a step, cut from one slice.
pub(crate) struct StageMemory<'a, S> {
    /// A stage's q and v, and at last those of the step's end.
    pub q: &'a mut [S],
    pub v: &'a mut [S],
    /// Θ.
    displacement: &'a mut [S],
    /// Θ̇ and v̇ of all stages.
    rates: &'a mut [S],
    pub accelerations: &'a mut [S],
}

impl<'a, S> StageMemory<'a, S> {
    /// Numbers that a step of so many stages needs.
    pub(crate) fn size(model: &Model, stages: usize) -> usize {
        model.nq + 2 * model.nv * (1 + stages)
    }

    pub(crate) fn new(model: &Model, stages: usize, memory: &'a mut [S]) -> Self {
        let (nq, nv) = (model.nq, model.nv);
        let mut rest = memory;
        let mut take = |count: usize| rest.split_off_mut(..count).unwrap_or_default();
        Self {
            q: take(nq),
            v: take(nv),
            displacement: take(nv),
            rates: take(stages * nv),
            accelerations: take(stages * nv),
        }
    }
}

/// The names of the rows with explicit stages, for messages.
pub(crate) fn explicit_names() -> String {
    let names: Vec<_> =
        Integrator::ALL.into_iter().filter(|row| row.is_explicit()).map(Integrator::name).collect();
    names.join(", ")
}

/// The most stages of any row.
pub(crate) fn most_stages() -> usize {
    let stages = |row: Integrator| match row.method() {
        Method::Explicit(stages) => stages.len(),
        Method::Variational(_) => 0,
    };
    Integrator::ALL.into_iter().map(stages).max().unwrap_or(0)
}

/// From (q, v) over h: leaves the end in `memory.q` and `memory.v`. See [`Stage`]; on joints with quaternions these are
/// Munthe-Kaas's methods, the stages taken in the coordinates Θ of the exponential. **(HLW §IV.8)**
#[inline(always)]
pub(crate) fn explicit_step<S: Scalar, M: Motion<S>>(
    model: &Model,
    stages: &[Stage],
    motion: &mut M,
    h: S,
    memory: &mut StageMemory<'_, S>,
    (q, v): (&[S], &[S]),
) -> Result<(), M::Error> {
    let nv = model.nv;
    let StageMemory { q: q_stage, v: v_stage, displacement, rates, accelerations } = memory;
    for (i, stage) in stages.iter().enumerate() {
        let stays = stage.q_row.is_empty();
        if stage.v_row.is_empty() {
            v_stage.copy_from_slice(v);
        } else {
            sum_stages(stage.v_row.len(), |j| stage.v_row[j], accelerations, v_stage);
            start_from(v, h, v_stage);
        }
        if !stays {
            sum_stages(stage.q_row.len(), |j| stage.q_row[j], rates, displacement);
            scale(h, displacement);
        }
        if Stage::needs_acceleration(stages, i) {
            if stays {
                q_stage.copy_from_slice(q);
            } else {
                motion.move_along(q, displacement, q_stage);
            }
            motion.accelerate(q_stage, v_stage, &mut accelerations[i * nv..(i + 1) * nv])?;
        }
        if Stage::needs_rate(stages, i) {
            let rate = &mut rates[i * nv..(i + 1) * nv];
            if stays {
                // Θ = 0.
                rate.copy_from_slice(v_stage);
            } else {
                displacement_rate(model, displacement, v_stage, rate);
            }
        }
    }
    sum_stages(stages.len(), |j| stages[j].v_weight, accelerations, v_stage);
    start_from(v, h, v_stage);
    sum_stages(stages.len(), |j| stages[j].q_weight, rates, displacement);
    scale(h, displacement);
    motion.move_along(q, displacement, q_stage);
    Ok(())
}

/// Σⱼ kⱼ xⱼ over the first `count` stages.
#[inline(always)]
pub(crate) fn sum_stages<S: Scalar>(count: usize, k: impl Fn(usize) -> f64, x: &[S], sum: &mut [S]) {
    let n = sum.len();
    let mut is_first = true;
    for j in 0..count {
        let k = k(j);
        if k == 0.0 {
            continue;
        }
        let (k, x) = (S::from_f64(k), &x[j * n..(j + 1) * n]);
        for i in 0..n {
            sum[i] = if is_first { k * x[i] } else { k.mul_add(x[i], sum[i]) };
        }
        is_first = false;
    }
    if is_first {
        sum.fill(S::zero());
    }
}

/// x ← start + h x.
#[inline(always)]
pub(crate) fn start_from<S: Scalar>(start: &[S], h: S, x: &mut [S]) {
    for i in 0..x.len() {
        x[i] = h.mul_add(x[i], start[i]);
    }
}

/// x ← h x.
#[inline(always)]
pub(crate) fn scale<S: Scalar>(h: S, x: &mut [S]) {
    for x in x.iter_mut() {
        *x = h * *x;
    }
}

/// A tree under held forces.
struct Free<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    /// τ − b(v).
    force: &'a mut [f64],
    forces: &'a StepForces<'a>,
}

impl Motion<f64> for Free<'_> {
    type Error = DynamicsError;

    fn move_along(&self, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
        integrate(self.model, q, displacement, moved);
    }

    fn accelerate(&mut self, q: &[f64], v: &[f64], acceleration: &mut [f64]) -> Result<(), DynamicsError> {
        accelerate(self.model, self.workspace, self.forces, self.force, (q, v), acceleration)
    }
}

/// A step of a row with explicit stages.
pub(super) fn step(
    model: &Model,
    workspace: &mut StepWorkspace,
    (row, stages): (Integrator, &[Stage]),
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), DynamicsError> {
    let StepWorkspace { dynamics, force, stages: memory, .. } = workspace;
    let mut memory = StageMemory::new(model, stages.len(), memory);
    if let Some(function) = NativeFunction::step(row, forces.dissipation) {
        let (native, ends) = (&mut dynamics.tree.native, &mut [&mut *memory.q, &mut *memory.v]);
        // Where an end is not finite, the stages say which number was first.
        if computed_natively(model, native, function, &[q, v, forces.tau, &[h]], ends)
            && memory.q.iter().chain(&*memory.v).all(|x| x.is_finite())
        {
            q.copy_from_slice(memory.q);
            v.copy_from_slice(memory.v);
            return Ok(());
        }
    }
    let mut motion = Free { model, workspace: dynamics, force, forces };
    advance(model, stages, &mut motion, h, &mut memory, (q, v))
}

/// [`explicit_step`] in place; on an error, or where an end is not finite, (q, v) are left as they were.
pub(crate) fn advance(
    model: &Model,
    stages: &[Stage],
    motion: &mut impl Motion<f64, Error = DynamicsError>,
    h: f64,
    memory: &mut StageMemory<'_, f64>,
    (q, v): (&mut [f64], &mut [f64]),
) -> Result<(), DynamicsError> {
    explicit_step(model, stages, motion, h, memory, (q, v))?;
    check_finite("v after the step", memory.v)?;
    check_finite("q after the step", memory.q)?;
    q.copy_from_slice(memory.q);
    v.copy_from_slice(memory.v);
    Ok(())
}

/// x ← x + k y.
pub(crate) fn add_scaled(x: &mut [f64], k: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += k * y);
}

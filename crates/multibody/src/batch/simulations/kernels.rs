//! Explicit steps of several simulations by machine code, with the bits of each alone.

use std::sync::Arc;

use ::native::Kernel;
use dynamics::Integrator;

use crate::Model;
use crate::algorithms::rank::{are_regular, constant_extents};
use crate::model::native::NativeFunction;
use crate::simulator::side_by_side::StepStart;

/// Simulations that are stepped by one call.
pub(super) const SIDE_BY_SIDE: usize = 16;

/// Steps of up to [`SIDE_BY_SIDE`] simulations, of which the first `states` stand in the tables.
#[derive(Debug)]
pub(super) struct StepKernels {
    model: Arc<Model>,
    function: NativeFunction,
    states: usize,
    /// Rows of q, v, τ and h where the step starts, of q and v at its end, and of K and V there.
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    h: Vec<f64>,
    q_end: Vec<f64>,
    v_end: Vec<f64>,
    energies: Vec<f64>,
    /// 1/d of each freedom where the step starts.
    pivots: Vec<f64>,
    /// √N of each freedom, where it is the same in all configurations.
    extents: Option<Vec<f64>>,
    /// What is known of each step.
    steps: [TakenStep; SIDE_BY_SIDE],
    scratch: Vec<f64>,
}

/// The outcome of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TakenStep {
    /// Whether an angle is beyond the range of the code's sine: then there is no end.
    pub(super) is_far: bool,
    /// Whether M is regular where the step starts, beyond doubt: the single steps' own test would find the same.
    pub(super) is_regular: bool,
}

impl StepKernels {
    /// The steps of this row, if machine code takes those of one simulation and of several.
    pub(super) fn new(model: &Arc<Model>, row: Integrator, dissipation: bool) -> Option<Self> {
        let function = NativeFunction::step(row, dissipation)?;
        let code = model.native.code()?;
        for function in [function, NativeFunction::Energies] {
            code.one::<f64>(model, function)?;
            rows(model, function)?;
        }
        let table = |width: usize| vec![0.0; SIDE_BY_SIDE * width];
        let (nq, nv) = (model.nq, model.nv);
        let extents =
            constant_extents(model).filter(|_| rows(model, NativeFunction::InversePivots).is_some());
        Some(Self {
            model: Arc::clone(model),
            function,
            states: 0,
            q: table(nq),
            v: table(nv),
            tau: table(nv),
            h: table(1),
            q_end: table(nq),
            v_end: table(nv),
            energies: table(2),
            pivots: table(model.dofs.len()),
            extents,
            steps: Default::default(),
            scratch: Vec::new(),
        })
    }

    /// Whether these are the steps of this robot.
    pub(super) fn are_of(&self, model: &Arc<Model>, row: Integrator, dissipation: bool) -> bool {
        Arc::ptr_eq(&self.model, model) && NativeFunction::step(row, dissipation) == Some(self.function)
    }

    /// Takes all states out.
    pub(super) fn clear(&mut self) {
        self.states = 0;
    }

    /// Adds a state.
    pub(super) fn push(&mut self, start: &StepStart<'_>) {
        let StepStart { q, v, tau } = *start;
        let k = self.states;
        self.q[k * q.len()..][..q.len()].copy_from_slice(q);
        self.v[k * v.len()..][..v.len()].copy_from_slice(v);
        self.tau[k * v.len()..][..v.len()].copy_from_slice(tau);
        self.states += 1;
    }

    /// Takes a step of h \[s\] of each state.
    pub(super) fn step(&mut self, h: f64) {
        let Self { model, states, q, v, tau, q_end, v_end, energies, pivots, steps, scratch, .. } = self;
        let (n, nq, nv) = (*states, model.nq, model.nv);
        steps.fill(TakenStep::default());
        self.h.fill(h);
        let (q, v, tau) = (&q[..n * nq], &v[..n * nv], &tau[..n * nv]);
        let (q_end, v_end) = (&mut q_end[..n * nq], &mut v_end[..n * nv]);
        call(model, self.function, n, &[q, v, tau, &self.h[..n]], &mut [q_end, v_end], scratch, |k| {
            steps[k].is_far = true;
        });
        let ends: &[&[f64]] = &[q_end, v_end];
        call(model, NativeFunction::Energies, n, ends, &mut [&mut energies[..2 * n]], scratch, |k| {
            steps[k].is_far = true;
        });
        let Some(extents) = &self.extents else { return };
        let pivots = &mut pivots[..n * extents.len()];
        let mut is_known = [true; SIDE_BY_SIDE];
        call(model, NativeFunction::InversePivots, n, &[q], &mut [&mut *pivots], scratch, |k| {
            is_known[k] = false;
        });
        for (k, step) in steps[..n].iter_mut().enumerate() {
            step.is_regular =
                is_known[k] && are_regular(&pivots[k * extents.len()..][..extents.len()], extents);
        }
    }

    /// The outcome of the step of state k, and its end, with K and V there.
    pub(super) fn end(&self, k: usize) -> (TakenStep, (&[f64], &[f64]), (f64, f64)) {
        let (nq, nv) = (self.model.nq, self.model.nv);
        let (q, v) = (&self.q_end[k * nq..][..nq], &self.v_end[k * nv..][..nv]);
        (self.steps[k], (q, v), (self.energies[2 * k], self.energies[2 * k + 1]))
    }
}

/// The code of a function for several states.
fn rows(model: &Model, function: NativeFunction) -> Option<&Kernel<f64>> {
    model.native.code()?.rows(model, function)
}

/// Calls it. States with an angle out of range are passed to `is_far`.
fn call(
    model: &Model,
    function: NativeFunction,
    states: usize,
    arguments: &[&[f64]],
    results: &mut [&mut [f64]],
    scratch: &mut Vec<f64>,
    is_far: impl FnMut(usize),
) {
    let Some(kernel) = rows(model, function) else { return };
    if scratch.len() < kernel.scratch_len() {
        scratch.resize(kernel.scratch_len(), 0.0);
    }
    kernel.call_rows(states, arguments, results, scratch, is_far);
}

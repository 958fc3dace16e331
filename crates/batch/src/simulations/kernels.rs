//! Explicit steps of several simulations by machine code, with the same bits as each simulation alone.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use robot_dynamics_core::algorithms::rank::{are_regular, constant_extents};
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_integrators::Integrator;
use robot_dynamics_native::Kernel;
use robot_dynamics_simulation::RunError;
use robot_dynamics_simulation::simulator::Simulation;
use robot_dynamics_simulation::simulator::simultaneous_steps::StepStart;

use super::steps::advance;
use crate::Threads;

/// The number of simulations in one call.
pub(super) const SIDE_BY_SIDE: usize = 16;

/// Steps of up to [`SIDE_BY_SIDE`] simulations, of which the first `states` are in the tables.
#[derive(Clone, Debug)]
pub(super) struct StepKernels {
    model: Arc<Model>,
    function: NativeFunction,
    states: usize,
    /// Rows of q, v, τ and h at the start of the step, and of q, v, K and V at its end.
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    h: Vec<f64>,
    q_end: Vec<f64>,
    v_end: Vec<f64>,
    energies: Vec<f64>,
    /// 1/d of each degree of freedom at the start of the step.
    pivots: Vec<f64>,
    /// √N of each degree of freedom, if it is constant over all configurations.
    extents: Option<Vec<f64>>,
    is_far: [bool; SIDE_BY_SIDE],
    is_regular: [bool; SIDE_BY_SIDE],
    scratch: Vec<f64>,
}

/// A completed step.
#[derive(Clone, Copy, Debug)]
struct TakenStep<'a> {
    /// Whether an angle is outside the range of the code's sine; the end is then invalid.
    is_far: bool,
    /// Whether M is clearly regular at the start of the step, so that the test of single steps would agree.
    is_regular: bool,
    /// (q, v) at the end.
    end: (&'a [f64], &'a [f64]),
    /// K and V at the end \[J\].
    energies: (f64, f64),
}

/// The kernels of each thread, if machine code takes the steps of a simulation.
pub(super) fn kernels_for(simulation: Option<&Simulation>, threads: &Threads) -> Vec<Mutex<StepKernels>> {
    let made = simulation.and_then(|simulation| {
        let (row, dissipation, _) = simulation.explicit_row()?;
        StepKernels::new(simulation.shared_model(), row, dissipation)
    });
    made.map_or_else(Vec::new, |made| (0..threads.count()).map(|_| Mutex::new(made.clone())).collect())
}

impl StepKernels {
    /// The kernels of this row, if machine code takes the steps of one simulation and of several.
    fn new(model: &Arc<Model>, row: Integrator, dissipation: bool) -> Option<Self> {
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
            is_far: [false; SIDE_BY_SIDE],
            is_regular: [false; SIDE_BY_SIDE],
            scratch: Vec::new(),
        })
    }

    /// Whether these kernels belong to this robot and row.
    fn are_of(&self, model: &Arc<Model>, row: Integrator, dissipation: bool) -> bool {
        Arc::ptr_eq(&self.model, model) && NativeFunction::step(row, dissipation) == Some(self.function)
    }

    /// Removes all states.
    fn clear(&mut self) {
        self.states = 0;
    }

    /// Adds a state.
    fn push(&mut self, start: &StepStart<'_>) {
        let StepStart { q, v, tau } = *start;
        let k = self.states;
        self.q[k * q.len()..][..q.len()].copy_from_slice(q);
        self.v[k * v.len()..][..v.len()].copy_from_slice(v);
        self.tau[k * v.len()..][..v.len()].copy_from_slice(tau);
        self.states += 1;
    }

    /// Takes a step of h \[s\] of each state.
    fn step(&mut self, h: f64) {
        let Self { model, states, q, v, tau, q_end, v_end, energies, pivots, scratch, .. } = self;
        let (n, nq, nv) = (*states, model.nq, model.nv);
        let (is_far, is_regular) = (&mut self.is_far, &mut self.is_regular);
        is_far.fill(false);
        is_regular.fill(self.extents.is_some());
        self.h.fill(h);
        let (q, v, tau) = (&q[..n * nq], &v[..n * nv], &tau[..n * nv]);
        let (q_end, v_end) = (&mut q_end[..n * nq], &mut v_end[..n * nv]);
        let mut far = |k: usize| is_far[k] = true;
        call(model, self.function, n, &[q, v, tau, &self.h[..n]], &mut [q_end, v_end], scratch, &mut far);
        let ends: &[&[f64]] = &[q_end, v_end];
        call(model, NativeFunction::Energies, n, ends, &mut [&mut energies[..2 * n]], scratch, &mut far);
        let Some(extents) = &self.extents else { return };
        let pivots = &mut pivots[..n * extents.len()];
        let mut far = |k: usize| is_regular[k] = false;
        call(model, NativeFunction::InversePivots, n, &[q], &mut [&mut *pivots], scratch, &mut far);
        for (is_regular, pivots) in is_regular.iter_mut().zip(pivots.chunks_exact(extents.len().max(1))) {
            *is_regular &= are_regular(pivots, extents);
        }
    }

    /// The step of state k.
    fn taken(&self, k: usize) -> TakenStep<'_> {
        let (nq, nv) = (self.model.nq, self.model.nv);
        TakenStep {
            is_far: self.is_far[k],
            is_regular: self.is_regular[k],
            end: (&self.q_end[k * nq..][..nq], &self.v_end[k * nv..][..nv]),
            energies: (self.energies[2 * k], self.energies[2 * k + 1]),
        }
    }
}

/// The code of a function for several states.
fn rows(model: &Model, function: NativeFunction) -> Option<&Kernel<f64>> {
    model.native.code()?.rows(model, function)
}

/// Calls the code, and passes states with an angle out of range to `is_far`.
fn call(
    model: &Model,
    function: NativeFunction,
    states: usize,
    arguments: &[&[f64]],
    results: &mut [&mut [f64]],
    scratch: &mut Vec<f64>,
    is_far: &mut dyn FnMut(usize),
) {
    let Some(kernel) = rows(model, function) else { return };
    if scratch.len() < kernel.scratch_len() {
        scratch.resize(kernel.scratch_len(), 0.0);
    }
    kernel.call_rows(states, arguments, results, scratch, is_far);
}

/// Takes `steps` steps of several simulations together. If a step would differ from that of each alone, the
/// remaining simulations take it separately.
pub(super) fn advance_side_by_side(
    kernels: &mut StepKernels,
    mut simulations: Vec<(usize, &mut Simulation)>,
    steps: usize,
    cancelled: &AtomicBool,
) -> Vec<(usize, RunError)> {
    let mut failed = Vec::new();
    let explicit = simulations.first().and_then(|(_, first)| first.explicit_row());
    let is_alike = |own: &Simulation| {
        own.explicit_row() == explicit
            && explicit
                .is_some_and(|(row, dissipates, _)| kernels.are_of(own.shared_model(), row, dissipates))
    };
    let are_alike = simulations.iter().all(|(_, own)| is_alike(own));
    let mut done = 0;
    if let (Some((.., h)), true) = (explicit, are_alike && simulations.len() > 1 && steps > 0) {
        keep_good(&mut simulations, &mut failed, Simulation::begin_external_steps);
        while done < steps && simulations.len() > 1 && !cancelled.load(Ordering::Relaxed) {
            kernels.clear();
            for (_, own) in &simulations {
                kernels.push(&own.step_start());
            }
            kernels.step(h);
            done += 1;
            let mut state = 0;
            keep_good(&mut simulations, &mut failed, |own| {
                let TakenStep { is_far, is_regular, end, energies } = kernels.taken(state);
                state += 1;
                if !is_regular {
                    own.check_external_step()?;
                }
                if !is_far && own.record_external_step(end, energies) { Ok(()) } else { own.step() }
            });
        }
    }
    if done < steps {
        keep_good(&mut simulations, &mut failed, |own| advance(own, steps - done, cancelled));
    }
    failed.sort_unstable_by_key(|(number, _)| *number);
    failed
}

/// Applies a function to each simulation, and removes those that fail.
fn keep_good(
    simulations: &mut Vec<(usize, &mut Simulation)>,
    failed: &mut Vec<(usize, RunError)>,
    mut act: impl FnMut(&mut Simulation) -> Result<(), RunError>,
) {
    simulations.retain_mut(|(number, own)| match act(own) {
        Ok(()) => true,
        Err(failure) => {
            failed.push((*number, failure));
            false
        }
    });
}

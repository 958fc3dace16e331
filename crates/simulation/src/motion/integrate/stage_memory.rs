//! The memory of a step's stages.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::{Integrator, StepScheme};

/// The memory of a step, cut from one slice.
pub struct StageMemory<'a, S> {
    /// q and v of a stage, and finally those of the step's end.
    pub q: &'a mut [S],
    pub v: &'a mut [S],
    /// Θ.
    pub displacement: &'a mut [S],
    /// Θ̇ and v̇ of all stages.
    pub rates: &'a mut [S],
    pub accelerations: &'a mut [S],
}

impl<'a, S> StageMemory<'a, S> {
    /// The number of entries that a step with this many stages needs.
    pub fn size(model: &Model, stages: usize) -> usize {
        model.nq + 2 * model.nv * (1 + stages)
    }

    pub fn new(model: &Model, stages: usize, memory: &'a mut [S]) -> Self {
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

/// The largest number of stages of any row.
pub fn most_stages() -> usize {
    let stages = |row: Integrator| match row.scheme() {
        StepScheme::Explicit(stages) => stages.len(),
        StepScheme::Variational(_) => 0,
    };
    Integrator::ALL.into_iter().map(stages).max().unwrap_or(0)
}

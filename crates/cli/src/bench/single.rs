//! One state at a time, by the functions with a workspace.

use std::hint::black_box;

use multibody::{FrameId, Inputs, InstructionSet, Model, Quantity, QuantityMemory, Workspace};

use super::states::States;

/// States between two looks at the clock: microseconds of work.
const BLOCK: usize = 64;

/// What is measured, in the order of the report.
pub(super) const MEASURED: [Quantity; 9] = [
    Quantity::InverseDynamics,
    Quantity::ForwardDynamics,
    Quantity::MassMatrix,
    Quantity::CoriolisMatrix,
    Quantity::InverseMassMatrix,
    Quantity::FramePoses,
    Quantity::FrameJacobianWorldAligned,
    Quantity::InverseDynamicsDerivatives,
    Quantity::ForwardDynamicsDerivatives,
];

/// One thread's memory for every quantity.
pub(super) struct Single<'a> {
    model: &'a Model,
    states: &'a States<f64>,
    tip: FrameId,
    workspace: Workspace,
    memory: QuantityMemory,
}

impl<'a> Single<'a> {
    pub(super) fn new(model: &'a Model, states: &'a States<f64>, tip: FrameId) -> Self {
        let (workspace, memory) = (Workspace::new(model), QuantityMemory::new(model));
        Self { model, states, tip, workspace, memory }
    }

    pub(super) fn instruction_set(&self) -> InstructionSet {
        self.workspace.instruction_set()
    }

    /// Computes the next states from `cursor` on; how many.
    pub(super) fn block(&mut self, quantity: Quantity, cursor: &mut usize) -> usize {
        let Self { model, states, tip, workspace, memory } = self;
        let count = BLOCK.min(states.count - *cursor);
        let [q, v, a, tau] = states.part(*cursor, count);
        let inputs = Inputs { q, v, a, tau, frames: &[*tip] };
        quantity.compute_each(model, workspace, &inputs, memory, &mut |memory| {
            black_box(memory);
        });
        *cursor = (*cursor + count) % states.count;
        count
    }

    /// Whether the results of the last call are numbers.
    pub(super) fn is_finite(&mut self, quantity: Quantity) -> bool {
        self.memory.results(quantity).into_iter().flatten().all(|x| x.is_finite())
    }
}

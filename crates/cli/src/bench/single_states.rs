//! One state at a time, by the functions with a workspace.

use std::hint::black_box;

use robot_dynamics::model::{FrameId, InstructionSet, Model, Workspace};
use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};

use super::states::States;

/// States between two clock readings, a few microseconds of work.
const BLOCK: usize = 64;

/// Measured quantities, in the order of the report.
pub(super) const QUANTITIES: [Quantity; 9] = [
    Quantity::InverseDynamics,
    Quantity::ForwardDynamics,
    Quantity::MassMatrix,
    Quantity::CoriolisMatrix,
    Quantity::InverseMassMatrix,
    Quantity::FramePoses,
    Quantity::FrameJacobianLocalWorldAligned,
    Quantity::InverseDynamicsDerivatives,
    Quantity::ForwardDynamicsDerivatives,
];

/// One thread's memory for all quantities.
pub(super) struct SingleStateBench<'a> {
    model: &'a Model,
    states: &'a States<f64>,
    tip: FrameId,
    workspace: Workspace,
    memory: QuantityMemory,
}

impl<'a> SingleStateBench<'a> {
    pub(super) fn new(model: &'a Model, states: &'a States<f64>, tip: FrameId) -> Self {
        let (workspace, memory) = (Workspace::new(model), QuantityMemory::new(model));
        Self { model, states, tip, workspace, memory }
    }

    pub(super) fn instruction_set(&self) -> InstructionSet {
        self.workspace.instruction_set()
    }

    /// Computes the next states after `cursor`. Returns how many.
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

    /// Whether the results of the last call are finite.
    pub(super) fn is_finite(&mut self, quantity: Quantity) -> bool {
        self.memory.results(quantity).into_iter().flatten().all(|x| x.is_finite())
    }
}

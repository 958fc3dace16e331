//! An algorithm on one robot as a call by the index of the state.

use std::hint::black_box;

use robot_dynamics::model::{FrameId, InstructionSet, Model, Workspace};
use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};

use crate::StateTable;

/// The measured algorithm.
pub const MEASURED: [Quantity; 9] = [
    Quantity::InverseDynamics,
    Quantity::ForwardDynamics,
    Quantity::MassMatrix,
    Quantity::CoriolisMatrix,
    Quantity::FramePoses,
    Quantity::FrameJacobianLocalWorldAligned,
    Quantity::FrameJacobianLocal,
    Quantity::InverseDynamicsDerivatives,
    Quantity::ForwardDynamicsDerivatives,
];

/// The name in records and on the command line: that of the library, except for shorter names of the tip's
/// Jacobians.
pub fn key(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::FrameJacobianLocalWorldAligned => "jacobian",
        Quantity::FrameJacobianLocal => "jacobian_in_frame",
        other => other.name(),
    }
}

/// The quantity with that name.
pub fn named(name: &str) -> Option<Quantity> {
    Quantity::ALL.into_iter().find(|&quantity| key(quantity) == name)
}

/// A robot, its states, and the memory of the calls.
#[derive(Debug)]
pub struct Task<'a> {
    model: &'a Model,
    states: &'a StateTable,
    workspace: Workspace,
    tip: FrameId,
    memory: QuantityMemory,
}

impl<'a> Task<'a> {
    /// Memory for every algorithm on this robot.
    ///
    /// # Panics
    /// Panics if the states belong to another robot.
    pub fn new(model: &'a Model, states: &'a StateTable) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        assert_eq!(states.dimensions(), (nq, nv), "states of another robot than {}", model.name());
        let moving = model.joints().iter().filter(|joint| joint.nv > 0 && joint.parent_link != "world");
        let tip = moving.map(|joint| &joint.child_link).nth(states.tip());
        let tip = tip.or(model.joints().last().map(|joint| &joint.child_link)).expect("a robot with joints");
        Self {
            model,
            states,
            workspace: Workspace::new(model),
            tip: model.frame(tip).expect("every link is a frame"),
            memory: QuantityMemory::new(model),
        }
    }

    /// As [`Task::new`], on the baseline instruction set.
    pub fn portable(model: &'a Model, states: &'a StateTable) -> Self {
        Self { workspace: Workspace::limited(model, InstructionSet::Portable), ..Self::new(model, states) }
    }

    /// Computes state `i`.
    ///
    /// # Panics
    /// Panics if there is no such state.
    #[inline]
    pub fn call(&mut self, quantity: Quantity, i: usize) {
        let Self { model, states, workspace, tip, memory } = self;
        let [q, v, a, tau] = states.get(i);
        let inputs = Inputs { q, v, a, tau, frames: &[*tip] };
        quantity.compute(model, workspace, &inputs, memory);
        black_box(&*memory);
    }

    /// The results of the last call: matrices in row-major order; for each frame its rotation in row-major
    /// order, then its translation.
    pub fn result(&mut self, quantity: Quantity) -> Vec<f64> {
        let fixed = self.model.nq() == self.model.nv();
        let [x, y, _] = self.memory.results(quantity);
        if quantity == Quantity::FramePoses {
            // A root that is fixed to the world is not a result.
            return x[12 * usize::from(fixed)..].to_vec();
        }
        // The peer's M⁻¹, a third result, is one triangle, which is not compared.
        [x, y].concat()
    }
}

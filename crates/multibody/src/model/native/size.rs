//! How long a function's expression is at least, before it is traced.

use crate::model::WORLD;
use crate::{Model, NativeFunction};

/// Operations a body of functions that pass the tree once or twice, at least.
const A_PASS: usize = 40;

/// Operations an entry that is not always zero of a matrix, at least.
const AN_ENTRY: usize = 3;

/// A number of operations that no expression of this function is below, for trees of some size.
pub(super) fn least_operations(model: &Model, function: NativeFunction) -> usize {
    let vector = A_PASS * model.bodies.len();
    match function {
        NativeFunction::MassMatrix | NativeFunction::MassMatrixRelated => vector + AN_ENTRY * entries(model),
        NativeFunction::CoriolisMatrix | NativeFunction::InverseMassMatrix => {
            vector + 2 * AN_ENTRY * entries(model)
        }
        NativeFunction::InverseDynamicsDerivatives => vector + 4 * AN_ENTRY * entries(model),
        NativeFunction::ForwardDynamicsDerivatives => vector + 8 * AN_ENTRY * entries(model),
        NativeFunction::ForwardDynamics
        | NativeFunction::SemiImplicitEulerStep
        | NativeFunction::ConservativeSemiImplicitEulerStep => 2 * vector,
        NativeFunction::Rk4Step | NativeFunction::ConservativeRk4Step => 8 * vector,
        _ => vector,
    }
}

/// Pairs of a body and one that carries it, itself among them.
fn entries(model: &Model) -> usize {
    let mut depths = Vec::with_capacity(model.bodies.len());
    for body in &model.bodies {
        let depth: usize = if body.parent == WORLD { 1 } else { depths[body.parent] + 1 };
        depths.push(depth);
    }
    depths.iter().sum()
}

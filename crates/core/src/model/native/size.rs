//! The largest expression that is compiled, and an estimate of its size before it is traced.

use robot_dynamics_native::Width;

use crate::model::WORLD;
use crate::model::native::NativeTask;
use crate::{Model, NativeFunction};

/// The largest number of operations that machine code pays off for. Fetching longer code takes more time than
/// computing with it; the recursion, whose code stays in the cache, is then as fast. Measured on chains of 8
/// to 64 links (docs/performance.md). Functions of frames and of the centre of mass gain up to 1024 links,
/// which take a tenth of a second to compile.
pub(super) fn most_operations(function: NativeFunction, width: Width) -> usize {
    match (function, width) {
        (NativeFunction::CoriolisMatrix, Width::One) => 3_500,
        (NativeFunction::MassMatrix, Width::One) => 12_000,
        // Four stages; the recursion takes as many operations. Longer code takes over a tenth of a second to
        // compile.
        (NativeFunction::Rk4StepPullback | NativeFunction::ConservativeRk4StepPullback, _) => 70_000,
        // States side by side share the fetched code. The other functions gain for one state too. The stages
        // of a step fetch the code repeatedly either way, and the other recursions take twice the operations.
        (_, Width::Lanes)
        | (
            NativeFunction::Rk4Step
            | NativeFunction::ConservativeRk4Step
            | NativeFunction::InverseDynamicsPullback
            | NativeFunction::ForwardDynamicsPullback
            | NativeFunction::SemiImplicitEulerStepPullback
            | NativeFunction::ConservativeSemiImplicitEulerStepPullback
            | NativeFunction::MassMatrixFactor,
            Width::One,
        ) => 30_000,
        (_, Width::One) => 20_000,
    }
}

/// An estimate of the operations for trees of many links. It counts each body, each pair of a body and an
/// ancestor, and each such triple. Small robots need fewer operations and are always traced.
pub(super) fn estimated_operations(model: &Model, NativeTask { function, frame }: NativeTask) -> usize {
    if let Some(frame) = frame {
        let of_link = if function == NativeFunction::FramePose { 18 } else { 45 };
        return of_link * model.body_and_ancestors(model.frame_of(frame).body.unwrap_or(WORLD)).count();
    }
    let (bodies, pairs, triples) = counts(model);
    match function {
        NativeFunction::ForwardDynamics
        | NativeFunction::InversePivots
        | NativeFunction::SemiImplicitEulerStep
        | NativeFunction::ConservativeSemiImplicitEulerStep => 150 * bodies,
        NativeFunction::Rk4Step | NativeFunction::ConservativeRk4Step => 600 * bodies,
        NativeFunction::MassMatrix | NativeFunction::MassMatrixRelated => 40 * bodies + 8 * pairs,
        NativeFunction::CoriolisMatrix => 40 * bodies + 20 * pairs,
        NativeFunction::InverseMassMatrix => 40 * bodies + 8 * pairs + 2 * triples,
        NativeFunction::InverseDynamicsDerivatives => 60 * bodies + 60 * pairs,
        NativeFunction::ForwardDynamicsDerivatives => 150 * bodies + 120 * pairs,
        NativeFunction::InverseDynamicsPullback => 120 * bodies,
        NativeFunction::ForwardDynamicsPullback
        | NativeFunction::SemiImplicitEulerStepPullback
        | NativeFunction::ConservativeSemiImplicitEulerStepPullback => 350 * bodies,
        NativeFunction::Rk4StepPullback | NativeFunction::ConservativeRk4StepPullback => 1400 * bodies,
        NativeFunction::MassMatrixFactor => 40 * bodies + 8 * pairs + triples,
        NativeFunction::CentroidalMomentumMatrix => 100 * bodies,
        NativeFunction::GravityDerivative => 30 * bodies + 2 * pairs,
        _ => 50 * bodies,
    }
}

/// The number of bodies; of pairs of a body and an ancestor, itself included; and Σ depth² of the bodies.
fn counts(model: &Model) -> (usize, usize, usize) {
    let mut depths: Vec<usize> = Vec::with_capacity(model.bodies.len());
    for body in &model.bodies {
        let depth = if body.parent == WORLD { 1 } else { depths[body.parent] + 1 };
        depths.push(depth);
    }
    (depths.len(), depths.iter().sum(), depths.iter().map(|depth| depth * depth).sum())
}

//! How long a function's expression may be, and about how long it is before it is traced.

use native::Width;

use crate::model::WORLD;
use crate::model::native::NativeTask;
use crate::{Model, NativeFunction};

/// Code of more operations is fetched for longer than it computes: the recursion, whose code stays in the cache, is as fast. Measured on
/// chains of 8 to 64 links (docs/native-code.md). Functions of frames and of the centre of mass gain up to 1024 links, which take a tenth of a
/// second to compile.
pub(super) fn most_operations(function: NativeFunction, width: Width) -> usize {
    match (function, width) {
        (NativeFunction::CoriolisMatrix, Width::One) => 3_500,
        (NativeFunction::MassMatrix, Width::One) => 12_000,
        // Four stages, as many operations for the recursion. Beyond, making the code takes a tenth of a second.
        (NativeFunction::Rk4StepPullback | NativeFunction::ConservativeRk4StepPullback, _) => 70_000,
        // States side by side share what is fetched. Stages of a step are fetched as often one by one, and the recursions of the others take
        // twice the operations.
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

/// About the operations that trees of many links need, counted for each body, each pair of a body and one that carries it, and each
/// triple of these. Small robots need fewer, and are traced in any case.
pub(super) fn estimated_operations(model: &Model, NativeTask { function, frame }: NativeTask) -> usize {
    if let Some(frame) = frame {
        let of_link = if function == NativeFunction::FramePose { 18 } else { 45 };
        return of_link * carriers(model, model.frame_of(frame).body);
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

/// A body and all that carry it.
fn carriers(model: &Model, body: Option<usize>) -> usize {
    let next = |&body: &usize| Some(model.bodies[body].parent).filter(|&parent| parent != WORLD);
    core::iter::successors(body, next).count()
}

/// Bodies; pairs of a body and one that carries it, itself among them; Σ depth² of the bodies.
fn counts(model: &Model) -> (usize, usize, usize) {
    let mut depths: Vec<usize> = Vec::with_capacity(model.bodies.len());
    for body in &model.bodies {
        let depth = if body.parent == WORLD { 1 } else { depths[body.parent] + 1 };
        depths.push(depth);
    }
    (depths.len(), depths.iter().sum(), depths.iter().map(|depth| depth * depth).sum())
}

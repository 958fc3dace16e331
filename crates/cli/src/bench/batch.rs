//! Batches of states, in lanes and over threads.

use std::hint::black_box;

use robot_dynamics::batch;
use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchQuantity, BatchWorkspace, Rollout, Torques};
use robot_dynamics::model::{FrameId, InstructionSet, Model};
use robot_dynamics::quantity::{Input, Inputs, Quantity};
use robot_dynamics::simulation::Integrator;

use super::states::{States, piece};
use crate::failure::Failure;

/// Steps of a rollout between two clock readings.
const STEPS: usize = 16;

/// Time step \[s\]. The cost of a step does not depend on it. This one resolves the fastest random motion of
/// a light link.
const STEP: f64 = 1e-6;

/// Quantities that are measured in batches, in the order of the report.
pub(super) const QUANTITIES: [Quantity; 6] = [
    Quantity::InverseDynamics,
    Quantity::ForwardDynamics,
    Quantity::MassMatrix,
    Quantity::InverseMassMatrix,
    Quantity::FramePoses,
    Quantity::FrameJacobianLocalWorldAligned,
];

/// The integrators of the rollouts.
pub(super) const ROLLOUTS: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::RungeKutta4];

/// The work of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Work {
    Compute(Quantity),
    Rollout(Integrator),
}

/// States of a batch in one precision, and a workspace for each number of threads.
pub(super) struct Batch<'a, T: BatchFloat> {
    model: &'a Model,
    states: States<T>,
    frames: Vec<FrameId>,
    tip: FrameId,
    workspaces: Vec<BatchWorkspace<T>>,
    output: Vec<T>,
    q: Vec<T>,
    v: Vec<T>,
}

impl<'a, T: BatchFloat> Batch<'a, T> {
    pub(super) fn new(
        model: &'a Model,
        states: States<T>,
        tip: FrameId,
        threads: &[usize],
    ) -> Result<Self, Failure> {
        let workspace = |&threads: &usize| {
            let mut options = BatchOptions::default();
            options.threads = threads;
            BatchWorkspace::with_options(model, options).map_err(Failure::new)
        };
        Ok(Self {
            model,
            states,
            frames: model.frames().iter().filter_map(|frame| model.frame(&frame.name)).collect(),
            tip,
            workspaces: threads.iter().map(workspace).collect::<Result<_, _>>()?,
            output: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
        })
    }

    /// The number of states of one block, and its instruction set.
    pub(super) fn lanes(&self) -> (usize, InstructionSet) {
        (self.workspaces[0].lanes(), self.workspaces[0].instruction_set())
    }

    /// Computes the next states after `cursor` on that many threads. Returns the number of states, or of
    /// rollout steps.
    pub(super) fn block(&mut self, work: Work, threads: usize, cursor: &mut usize) -> Result<usize, String> {
        let Self { model, states, frames, tip, workspaces, output, q: q_end, v: v_end } = self;
        let workspace = workspaces.iter_mut().find(|workspace| workspace.threads() == threads);
        let w = workspace.ok_or_else(|| format!("no workspace for {threads} threads"))?;
        let count = piece(model, states.count, threads).min(states.count - *cursor);
        let [q, v, a, tau] = states.part(*cursor, count);
        *cursor = (*cursor + count) % states.count;
        match work {
            Work::Compute(quantity) => {
                let [result, ..] = quantity.results() else { unreachable!("each quantity has a result") };
                // Quantities with several results are not measured in batches.
                let width = result.shape.len(model, frames.len());
                output.resize(output.len().max(count * width), T::from_f64(0.0));
                let out = &mut output[..count * width];
                let frames =
                    if quantity.reads(Input::Frame) { std::slice::from_ref(tip) } else { &frames[..] };
                let inputs = Inputs { q, v, a, tau, frames };
                let computed = quantity
                    .compute_batch(model, w, &inputs, [&mut *out, &mut [], &mut []])
                    .ok_or_else(|| format!("{} has no batch function", quantity.name()))?;
                black_box(&*out);
                computed.map_err(|error| error.to_string())?;
                Ok(count)
            }
            Work::Rollout(integrator) => {
                q_end.clear();
                q_end.extend(q);
                v_end.clear();
                v_end.extend(v);
                let how = Rollout::new(integrator, STEP, STEPS).with_dissipation(false);
                let moved = batch::rollout(
                    model,
                    w,
                    &how,
                    Torques::Zero,
                    batch::RolloutStates::ends(q_end, v_end),
                    None,
                );
                black_box((&*q_end, &*v_end));
                moved.map_err(|error| error.to_string())?;
                Ok(count * STEPS)
            }
        }
    }
}

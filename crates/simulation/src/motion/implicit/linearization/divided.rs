//! The derivatives of a step that was taken in parts: the product of those of its parts.
//!
//! With (δq, δv)ᵢ₊₁ = Aᵢ (δq, δv)ᵢ + Bᵢ δu of part i, the step has A = Aₙ … A₁ and B = Σ Aₙ … Aᵢ₊₁ Bᵢ, where
//! u stands for forces and parameters. The division into parts is kept, and impacts move within their parts
//! (`landing`).

use robot_dynamics_core::Model;

use super::super::ImplicitIntegrator;
use super::super::advance::ImpactPolicy;
use super::super::snapshot::StepSnapshot;
use crate::motion::RobotState;
use crate::motion::linearize_step::product::multiply_changes;
use crate::motion::linearize_step::results::{
    LinearizationMethod, LinearizedStep, LinearizedStepWithParameters,
};
use crate::motion::simulate::StepError;
use crate::{StepForces, StepWorkspace};

impl ImplicitIntegrator {
    /// Takes the recorded passes of a step of h from `begun` to (q₁, v₁) again, and multiplies their
    /// derivatives.
    pub(super) fn differentiate_parts(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        (h, begun): (f64, &StepSnapshot),
        (q1, v1): (&[f64], &[f64]),
        mut out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        let parts = core::mem::take(&mut self.record.parts);
        let (mut q, mut v) = (begun.q.clone(), begun.v.clone());
        self.kept.copy_from(begun);
        self.take_back(&mut q, &mut v);
        self.begin_whole(model, workspace, forces, h, (&mut q, &mut v));
        let mut part_of_step = PartDerivatives::new(&mut out);
        let (mut from, mut is_transition) = ((q.clone(), v.clone()), false);
        for part in parts {
            from.0.copy_from_slice(&q);
            from.1.copy_from_slice(&v);
            self.store_state(&q, &v);
            self.record.begin();
            let (tau, impacts) = (forces.tau, ImpactPolicy::AcceptStep);
            self.advance(model, &mut workspace.dynamics, tau, part, (&mut q, &mut v), impacts)?;
            (self.record.is_on, self.record.is_part) = (false, true);
            let state = RobotState { q: &from.0, v: &from.1 };
            let part_out = part_of_step.out();
            let method = self.differentiate(model, &mut workspace.dynamics, part, state, (&q, &v), part_out);
            self.record.is_part = false;
            match method? {
                LinearizationMethod::Analytic { at_transition } => is_transition |= at_transition,
                method @ LinearizationMethod::Differences { .. } => return Ok(method),
            }
            part_of_step.multiply(model.nv, &mut out);
        }
        let off = q
            .iter()
            .chain(&v)
            .zip(q1.iter().chain(v1))
            .map(|(own, end)| (own - end).abs() / (1.0 + end.abs()));
        debug_assert!(off.fold(0.0, f64::max) < 1e-9, "the passes of a step lead to the same end again");
        Ok(LinearizationMethod::Analytic { at_transition: is_transition })
    }
}

/// The derivatives of one part, and a product.
struct PartDerivatives {
    by_state: Vec<f64>,
    /// By forces, controls, inertial parameters and friction.
    by_inputs: [Vec<f64>; 4],
    product: Vec<f64>,
}

impl PartDerivatives {
    /// Memory for a part, with the derivatives of a step without length in `out`.
    fn new(out: &mut LinearizedStepWithParameters<'_>) -> Self {
        let by_inputs = inputs(out).map(|matrix| {
            matrix.fill(0.0);
            matrix.to_vec()
        });
        let LinearizedStep { by_state, .. } = &mut out.step;
        by_state.fill(0.0);
        let by_part = by_state.to_vec();
        let n = by_state.len().isqrt();
        by_state.iter_mut().step_by(n + 1).for_each(|entry| *entry = 1.0);
        Self { by_state: by_part, by_inputs, product: Vec::new() }
    }

    /// The output of a part.
    fn out(&mut self) -> LinearizedStepWithParameters<'_> {
        let [by_force, by_control, by_inertial, by_friction] = &mut self.by_inputs;
        let step = LinearizedStep { by_state: &mut self.by_state, by_force };
        LinearizedStepWithParameters { step, by_control, by_inertial, by_friction }
    }

    /// Continues the derivatives of the parts so far by this part.
    fn multiply(&mut self, nv: usize, out: &mut LinearizedStepWithParameters<'_>) {
        let Self { by_state, by_inputs, product } = self;
        let mut continue_by = |part: Option<&[f64]>, sum: &mut [f64]| {
            let width = sum.len() / (2 * nv).max(1);
            if width == 0 {
                return;
            }
            product.resize(sum.len(), 0.0);
            multiply_changes(&[(by_state, sum)], width, product);
            sum.copy_from_slice(product);
            for (sum, own) in sum.iter_mut().zip(part.into_iter().flatten()) {
                *sum += own;
            }
        };
        for (own, sum) in by_inputs.iter().zip(inputs(out)) {
            continue_by(Some(own), sum);
        }
        continue_by(None, out.step.by_state);
    }
}

/// The derivatives by forces, controls, inertial parameters and friction.
fn inputs<'a>(out: &'a mut LinearizedStepWithParameters<'_>) -> [&'a mut [f64]; 4] {
    let LinearizedStepWithParameters { step, by_control, by_inertial, by_friction } = out;
    [step.by_force, by_control, by_inertial, by_friction]
}

//! The forces of held contacts.

use robot_dynamics_number::{InvalidInput, check_finite, check_positive};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};
use crate::optimal::dynamics::{ContactForces, DiscreteDynamics, HeldContactStep};

/// r = F λ − r\*: combinations of the forces λ of a [`HeldContactStep`], with exact derivatives by x and u.
///
/// It solves the dynamics of its own copy of the step. In a node whose dynamics is the same step, or a clone
/// of it, it reads the forces that the node computed.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, RowFeedback, SpatialAxis};
/// use robot_dynamics::control::optimal::{ContactForceResidual, HeldContactStep, Residual};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let hold = FrameConstraint::contact(model.frame_named("tip")?, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let step = HeldContactStep::new(model, &set, RowFeedback::default(), 0.01)?;
/// let mut residual = ContactForceResidual::tracking(&step, &[15.0])?;
/// let mut r = [0.0];
/// residual.evaluate(&[0.3, 0.0], &[0.0], &mut r)?;
/// assert!((r[0] - (2.0 * 9.81 - 15.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias = "ResidualModelContactForce")]
#[doc(alias = "ResidualModelContactFrictionCone")]
pub struct ContactForceResidual {
    step: HeldContactStep,
    /// The entries of F that are not zero: row, column, value.
    entries: Vec<(usize, usize, f64)>,
    reference: Vec<f64>,
}

impl ContactForceResidual {
    /// r = F λ − r\* with F row-major, one row for each entry of r\*.
    ///
    /// # Errors
    /// [`InvalidInput`] if F does not have a column for each held row, or a number is not finite.
    pub fn new(step: &HeldContactStep, factors: &[f64], reference: &[f64]) -> Result<Self, InvalidInput> {
        let (rows, count) = (reference.len(), step.constraints().len());
        if rows == 0 || factors.len() != rows * count {
            let shape = format!("have {} numbers, {rows}×{count} are needed", factors.len());
            return Err(InvalidInput::unmet("the factors of the contact forces", shape));
        }
        check_finite("the factors of the contact forces", factors)?;
        check_finite("the reference of the contact forces", reference)?;
        let at = |k: usize| (k / count, k % count, factors[k]);
        let entries = (0..factors.len()).map(at).filter(|entry| entry.2 != 0.0).collect();
        Ok(Self { step: step.clone(), entries, reference: reference.to_vec() })
    }

    /// r = λ − λ\* for all held rows.
    ///
    /// # Errors
    /// [`InvalidInput`] if there is not one finite number for each row.
    pub fn tracking(step: &HeldContactStep, reference: &[f64]) -> Result<Self, InvalidInput> {
        let count = step.constraints().len();
        let mut identity = vec![0.0; count * count];
        (0..count).for_each(|i| identity[i * (count + 1)] = 1.0);
        Self::new(step, &identity, reference)
    }

    /// Five numbers that are not negative within the pyramid of friction of a point contact: μλ_n ± λ_x, μλ_n
    /// ± λ_y and λ_n. `rows` are the indices of the held rows x, y and of the normal. Penalize negative
    /// numbers by [`Activation::QuadraticBarrier`](crate::optimal::Activation), or constrain them.
    ///
    /// # Errors
    /// [`InvalidInput`] if a row does not exist, or μ is not positive and finite.
    pub fn friction_pyramid(
        step: &HeldContactStep,
        [x, y, normal]: [usize; 3],
        friction: f64,
    ) -> Result<Self, InvalidInput> {
        check_positive("the friction", friction, "")?;
        let count = step.constraints().len();
        if let Some(row) = [x, y, normal].into_iter().find(|row| *row >= count) {
            let required = format!("must be below {count}, the number of held rows; got {row}");
            return Err(InvalidInput::unmet("a row of the contact", required));
        }
        let mut factors = vec![0.0; 5 * count];
        for (k, (tangent, sign)) in [(x, 1.0), (x, -1.0), (y, 1.0), (y, -1.0)].into_iter().enumerate() {
            factors[k * count + normal] = friction;
            factors[k * count + tangent] = sign;
        }
        factors[4 * count + normal] = 1.0;
        Self::new(step, &factors, &[0.0; 5])
    }
}

impl Residual for ContactForceResidual {
    fn dimension(&self) -> usize {
        self.reference.len()
    }

    fn expects(&self) -> ResidualInputs {
        let coordinates = Some(self.step.state_space().coordinates());
        ResidualInputs { coordinates, controls: Some(self.step.controls()) }
    }

    fn reuse(&mut self, forces: &ContactForces<'_>) {
        self.step.reuse(forces);
    }

    fn evaluate(&mut self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let (multipliers, _) = self.step.forces_at(x, u, false)?;
        residual.iter_mut().zip(&self.reference).for_each(|(r, reference)| *r = -reference);
        for &(row, column, factor) in &self.entries {
            residual[row] += factor * multipliers[column];
        }
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let (n, m) = (self.step.state_space().tangent(), u.len());
        let (_, by_inputs) = self.step.forces_at(x, u, true)?;
        for &(row, column, factor) in &self.entries {
            let by = &by_inputs[column * (n + m)..][..n + m];
            let to_state = &mut jacobian.by_state[row * n..][..n];
            to_state.iter_mut().zip(&by[..n]).for_each(|(to, by)| *to += factor * by);
            let to_control = &mut jacobian.by_control[row * m..][..m];
            to_control.iter_mut().zip(&by[n..]).for_each(|(to, by)| *to += factor * by);
        }
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}

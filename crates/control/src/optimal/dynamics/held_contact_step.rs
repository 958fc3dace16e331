//! A step with held contacts: a phase of a gait, a hand on a rail, feet that stand.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::{
    ConstraintSet, HeldDynamics, LinearizedHeldStep, RobotState, RowFeedback, StepError,
};

use super::contact_forces::{ContactForces, ContactPhase, EvaluatedForces};
use super::{ActuationMatrix, DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// One step of semi-implicit Euler with held rows: v′ = v + h a, q′ = q ⊕ h v′, x = (q, v), τ = S u.
///
/// a and the forces λ solve M a + C v + g = τ + Aᵀλ, A a = −Ȧv − d A v − p φ, see [`HeldDynamics`]. The rows
/// are those of a set, for instance of feet. They are held for the whole phase: λ may pull and slip. A cost
/// or a constraint on a [`ContactForceResidual`](crate::optimal::ContactForceResidual) keeps it within
/// friction. Damping and friction of the joints are not included.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, RowFeedback, SpatialAxis};
/// use robot_dynamics::control::optimal::{DiscreteDynamics, HeldContactStep};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// // A rod whose tip is held at its height stays where it is.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let hold = FrameConstraint::contact(model.frame_named("tip")?, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let mut step = HeldContactStep::new(model, &set, RowFeedback::default(), 0.01)?;
/// let mut next = [0.0; 2];
/// step.step(&[0.3, 0.0], &[0.0], &mut next)?;
/// assert!((next[0] - 0.3).abs() < 1e-15 && next[1].abs() < 1e-15);
/// // The tip carries the rod: λ l cos q = m g l cos q.
/// assert!((step.contact_forces().expect("forces").multipliers[0] - 2.0 * 9.81).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias = "DifferentialActionModelContactFwdDynamics")]
pub struct HeldContactStep {
    space: StateSpace,
    phase: Arc<ContactPhase>,
    held: HeldDynamics,
    tau: Vec<f64>,
    evaluated: EvaluatedForces,
}

impl HeldContactStep {
    /// A step of `step` seconds with the rows of a set, and with one control for each coordinate.
    ///
    /// # Errors
    /// [`StepError`] if the step is not positive and finite, a number of the feedback is not finite, or the
    /// set has no robot.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn new(
        model: impl Into<Arc<Model>>,
        set: &ConstraintSet,
        feedback: RowFeedback,
        step: f64,
    ) -> Result<Self, StepError> {
        robot_dynamics_number::check_positive("the step", step, "s")?;
        let model = model.into();
        let held = HeldDynamics::new(&model, set, feedback)?;
        let actuation = ActuationMatrix::identity(&model);
        let columns = actuation.columns();
        let (space, tau) = (StateSpace::robot(model.clone()), vec![0.0; model.nv()]);
        let phase = Arc::new(ContactPhase { model, set: set.clone(), actuation, columns, step });
        Ok(Self { space, phase, held, tau, evaluated: EvaluatedForces::default() })
    }

    /// The same with other actuation: τ = S u.
    ///
    /// # Errors
    /// [`InvalidInput`] if S does not have nv rows, or has no column.
    pub fn with_actuation(mut self, actuation: ActuationMatrix) -> Result<Self, InvalidInput> {
        let ContactPhase { model, set, step, .. } = &*self.phase;
        actuation.check(model)?;
        let (columns, model, set) = (actuation.columns(), model.clone(), set.clone());
        self.phase = Arc::new(ContactPhase { model, set, actuation, columns, step: *step });
        self.evaluated = EvaluatedForces::default();
        Ok(self)
    }

    /// The held rows.
    pub fn constraints(&self) -> &ConstraintSet {
        &self.phase.set
    }

    /// The forces at (x, u), with derivatives if asked for: those of the last evaluation if it was there.
    pub(in crate::optimal) fn forces_at(
        &mut self,
        x: &[f64],
        u: &[f64],
        with_derivatives: bool,
    ) -> Result<(&[f64], &[f64]), StepError> {
        let has_all = !with_derivatives || !self.evaluated.by_inputs.is_empty();
        if !(has_all && self.evaluated.is_at(x, u)) {
            let phase = &*self.phase;
            let (q, v) = x.split_at(phase.model.nq());
            phase.actuation.forces(u, &mut self.tau);
            let state = RobotState { q, v };
            if with_derivatives {
                self.held.linearize(&phase.model, state, &self.tau, &phase.columns)?;
            } else {
                self.held.solve(&phase.model, state, &self.tau)?;
            }
            self.evaluated.set(x, u, &self.held, with_derivatives);
        }
        Ok((&self.evaluated.multipliers, &self.evaluated.by_inputs))
    }

    /// Takes over the forces of a clone.
    pub(in crate::optimal) fn reuse(&mut self, forces: &ContactForces<'_>) {
        if Arc::ptr_eq(&self.phase, forces.phase) {
            self.evaluated.clone_from(forces.evaluated);
        }
    }
}

impl DiscreteDynamics for HeldContactStep {
    fn state_space(&self) -> &StateSpace {
        &self.space
    }

    fn controls(&self) -> usize {
        self.phase.actuation.controls()
    }

    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        let phase = &*self.phase;
        phase.actuation.forces(u, &mut self.tau);
        let (q, v) = x.split_at(phase.model.nq());
        let (next_q, next_v) = next.split_at_mut(phase.model.nq());
        self.held.step(&phase.model, RobotState { q, v }, &self.tau, phase.step, [next_q, next_v])?;
        self.evaluated.set(x, u, &self.held, false);
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        let LinearizedDynamics { by_state, by_control } = derivatives;
        let phase = &*self.phase;
        phase.actuation.forces(u, &mut self.tau);
        let (q, v) = x.split_at(phase.model.nq());
        let (state, forces) = (RobotState { q, v }, (&self.tau[..], &phase.columns[..]));
        let out = LinearizedHeldStep { by_state, by_control };
        self.held.linearize_step(&phase.model, state, forces, phase.step, out)?;
        self.evaluated.set(x, u, &self.held, true);
        Ok(())
    }

    fn contact_forces(&self) -> Option<ContactForces<'_>> {
        let (evaluated, phase) = (&self.evaluated, &self.phase);
        let EvaluatedForces { x, u, multipliers, .. } = evaluated;
        Some(ContactForces { x, u, multipliers, evaluated, phase })
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}

//! The impact at which contacts begin to be held.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::{
    ConstraintSet, HeldDynamics, LinearizedImpact, RobotState, RowFeedback, StepError,
};

use super::{DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// The impact on rows that begin to be held, as the dynamics of a node without time and without controls:
/// q′ = q, v′ = v + M⁻¹Aᵀι with A v′ = −e A v.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::control::optimal::{DiscreteDynamics, ImpactStep};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let floor = FrameConstraint::contact(model.frame_named("tip")?, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("floor", floor.into())])?;
/// let mut impact = ImpactStep::new(model, &set, 0.5)?;
/// let mut next = [0.0; 2];
/// impact.step(&[0.3, 2.0], &[], &mut next)?;
/// assert!(next[0] == 0.3 && (next[1] + 1.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias = "ActionModelImpulseFwdDynamics")]
pub struct ImpactStep {
    space: StateSpace,
    model: Arc<Model>,
    held: HeldDynamics,
    restitution: f64,
}

impl ImpactStep {
    /// The impact on the rows of a set with the restitution e; 0 for contacts that hold.
    ///
    /// # Errors
    /// [`InvalidInput`] if e is outside \[0, 1\], or the set has no robot.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn new(
        model: impl Into<Arc<Model>>,
        set: &ConstraintSet,
        restitution: f64,
    ) -> Result<Self, InvalidInput> {
        if !(0.0..=1.0).contains(&restitution) {
            return Err(InvalidInput::out_of_range("the restitution", restitution, "", "between 0 and 1"));
        }
        let model = model.into();
        let held = HeldDynamics::new(&model, set, RowFeedback::default())?;
        Ok(Self { space: StateSpace::robot(model.clone()), model, held, restitution })
    }

    /// The impulses of the last impact, one number for each row \[N·s, or N·m·s for a rotation\].
    pub fn impulses(&self) -> &[f64] {
        self.held.multipliers()
    }
}

impl DiscreteDynamics for ImpactStep {
    fn state_space(&self) -> &StateSpace {
        &self.space
    }

    fn controls(&self) -> usize {
        0
    }

    fn step(&mut self, x: &[f64], _u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        let nq = self.model.nq();
        let ((q, v), (next_q, next_v)) = (x.split_at(nq), next.split_at_mut(nq));
        next_q.copy_from_slice(q);
        self.held.impact(&self.model, RobotState { q, v }, self.restitution, next_v)
    }

    fn linearize(
        &mut self,
        x: &[f64],
        _u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        let (q, v) = x.split_at(self.model.nq());
        let out = LinearizedImpact { by_state: derivatives.by_state };
        self.held.linearize_impact(&self.model, RobotState { q, v }, self.restitution, out)
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}

//! Bounds on the controls of a node.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

/// u̲ ≤ u ≤ ū; an entry may be infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlBounds {
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
}

impl ControlBounds {
    /// Bounds with one number a control.
    ///
    /// # Errors
    /// [`InvalidInput`] if the lengths differ, an entry is NaN, or a lower bound is above its upper bound.
    pub fn new(lower: &[f64], upper: &[f64]) -> Result<Self, InvalidInput> {
        if lower.len() != upper.len() {
            let lengths = format!("have {} and {} numbers; give one a control", lower.len(), upper.len());
            return Err(InvalidInput::unmet("the bounds on the controls", lengths));
        }
        for (index, (low, high)) in lower.iter().zip(upper).enumerate() {
            let is_ordered = low <= high;
            if !is_ordered || *low == f64::INFINITY || *high == f64::NEG_INFINITY {
                let problem = format!("has the bounds {low} and {high}; the lower must be below the upper");
                return Err(InvalidInput::unmet(format!("u[{index}]"), problem));
            }
        }
        Ok(Self { lower: lower.to_vec(), upper: upper.to_vec() })
    }

    /// The effort limits of the actuated coordinates of a robot, in the order of
    /// [`ActuationMatrix::actuated`](super::ActuationMatrix::actuated): |τ| ≤ the limit of the joint, infinite
    /// without one.
    pub fn effort_limits(model: &Model) -> Self {
        let limits = model.coordinate_limits();
        let driven = limits.iter().zip(model.actuated_dofs()).filter(|(_, driven)| **driven);
        let upper: Vec<f64> = driven.map(|(limit, _)| limit.effort).collect();
        Self { lower: upper.iter().map(|limit| -limit).collect(), upper }
    }

    /// No bounds on `controls` numbers.
    pub fn unbounded(controls: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; controls], upper: vec![f64::INFINITY; controls] }
    }

    /// The lower bounds.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// The upper bounds.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Whether a bound is finite.
    pub fn is_bounded(&self) -> bool {
        self.lower.iter().chain(&self.upper).any(|bound| bound.is_finite())
    }

    /// Moves each control to the nearest number within its bounds.
    pub fn clamp(&self, u: &mut [f64]) {
        for ((u, low), high) in u.iter_mut().zip(&self.lower).zip(&self.upper) {
            *u = u.max(*low).min(*high);
        }
    }
}

//! The constraint error of a state.

use nalgebra::DVector;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::check_length;

use super::forward_dynamics::LargestEntry;
use super::rows::ConstraintRows;
use super::{ConstraintError, ConstraintSet};

/// The constraint error of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConstraintDrift {
    /// max |φ| over the rows that have φ \[m or rad\].
    pub position: f64,
    /// max |A v| over all rows \[m/s or rad/s\].
    pub velocity: f64,
}

impl ConstraintDrift {
    /// The larger of both, entry by entry.
    pub fn max(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), velocity: self.velocity.max(other.velocity) }
    }

    pub(super) fn of(rows: &ConstraintRows, v: &[f64]) -> Self {
        let velocity = &rows.matrix * DVector::from_column_slice(v);
        Self { position: rows.position_error.amax_or_zero(), velocity: velocity.amax_or_zero() }
    }

    /// Returns an error if the state is farther off than `allowed`.
    pub(super) fn require_below(
        set: &ConstraintSet,
        rows: &ConstraintRows,
        v: &[f64],
        allowed: f64,
    ) -> Result<(), ConstraintError> {
        let velocity = &rows.matrix * DVector::from_column_slice(v);
        for (quantity, values) in [("the position error", &rows.position_error), ("the velocity", &velocity)]
        {
            // A value that is not finite is an error.
            if let Some(i) = (0..values.len()).find(|&i| values[i].is_nan() || values[i].abs() > allowed) {
                let name = set.row_names()[i].clone();
                return Err(ConstraintError::OffConstraint { quantity, name, error: values[i].abs() });
            }
        }
        Ok(())
    }
}

/// max |φ(q)| and max |A(q) v|.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintSet, constraint_drift};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // A ball that should be held at the origin is 0.4 m off, and moves at 3 m/s.
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(ball, [0.0; 3]).into())])?;
/// let (q, v) = ([0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let drift = constraint_drift(&model, &mut Workspace::new(&model), &set, &q, &v);
/// assert_eq!((drift.position, drift.velocity), (0.4, 3.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn constraint_drift(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    q: &[f64],
    v: &[f64],
) -> ConstraintDrift {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    ConstraintDrift::of(&set.rows(model, workspace, q, v), v)
}

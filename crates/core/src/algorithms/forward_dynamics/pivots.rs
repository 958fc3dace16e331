//! The pivots of the articulated-body algorithm.

use robot_dynamics_number::Scalar;

use super::articulated_body;
use crate::{InstructionSet, Model, Workspace};

/// 1/d of each DoF, for any scalar type. `None` if the robot has mimic joints, or armature on tendons over
/// several joints.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_core::inverse_pivots;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// assert_eq!(inverse_pivots(&model, &[0.3]), Some(vec![1.0 / (2.0 * 0.5 * 0.5)])); // 1/(m l²)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[doc(hidden)]
#[track_caller]
pub fn inverse_pivots<S: Scalar>(model: &Model, q: &[S]) -> Option<Vec<S>> {
    if model.needs_dense_factor {
        return None;
    }
    let mut workspace = Workspace::limited(model, InstructionSet::Portable);
    workspace.check_inputs(model, q);
    let (rest, mut acceleration) = (vec![S::zero(); model.nv], vec![S::zero(); model.nv]);
    articulated_body(model, &mut workspace.tree, q, &rest, &rest, &[], &mut acceleration);
    Some(workspace.tree.inertias.pivot.iter().map(|pivot| pivot.inverse).collect())
}

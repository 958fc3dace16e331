//! The pivots of the articulated-body algorithm.

use dynamics::Scalar;

use super::articulated_body;
use crate::{InstructionSet, Model, Workspace};

/// 1/d of each freedom, over numbers of any kind; a robot with followers or with armature on tendons over several joints has none.
///
/// ```
/// use multibody::{Model, inverse_pivots, pendulum};
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
    if model.couples_branches {
        return None;
    }
    let mut workspace = Workspace::limited(model, InstructionSet::Portable);
    workspace.admit(model, q);
    let (rest, mut acceleration) = (vec![S::zero(); model.nv], vec![S::zero(); model.nv]);
    articulated_body(model, &mut workspace.tree, q, &rest, &rest, &[], &mut acceleration);
    Some(workspace.tree.inertias.pivot.iter().map(|pivot| pivot.inverse).collect())
}

//! The structurally nonzero entries of M(q), on and above the diagonal: M_ij of which one DoF is an ancestor
//! of the other.
//!
//! The algorithm is that of the mass matrix, O(n depth). A chain has half of the entries of M, a tree with
//! many branches far fewer. The bits are those of `mass_matrix`.

use robot_dynamics_core::Model;

use crate::float::Quantity;
use crate::tables::InputTables;
use crate::{BadStates, BatchFloat, BatchWorkspace};

/// The structurally nonzero entries of M(q) of each state on and above the diagonal. These are the M_ij of
/// two degrees of freedom of which one is an ancestor of the other.
/// [`mass_matrix_related_entries`](robot_dynamics_core::mass_matrix_related_entries) lists them.
///
/// q is \[batch\]\[nq\]; the result is \[batch\]\[entries\]. For a chain it has half of the entries of
/// [`mass_matrix`](super::mass_matrix), for a tree with many branches far fewer. They have the same bits.
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let mut workspace = BatchWorkspace::<f64>::new(&model);
/// let (nv, q) = (model.nv(), neutral(&model).repeat(100));
/// let entries = batch::mass_matrix_related_entries(&model);
/// let mut packed = vec![0.0; 100 * entries.len()];
/// batch::mass_matrix_related(&model, &mut workspace, &q, &mut packed)?;
/// // Assemble the first state's whole matrix.
/// let mut mass = vec![0.0; nv * nv];
/// for (&(i, j), &m) in entries.iter().zip(&packed) {
///     (mass[i * nv + j], mass[j * nv + i]) = (m, m);
/// }
/// let mut expected = vec![0.0; 100 * nv * nv];
/// batch::mass_matrix(&model, &mut workspace, &q, &mut expected)?;
/// assert_eq!(mass, expected[..nv * nv]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "CRBA")]
#[track_caller]
pub fn mass_matrix_related<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    mass: &mut [T],
) -> Result<(), BadStates> {
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::RelatedMass, &tables, "the related entries of M", mass)
}

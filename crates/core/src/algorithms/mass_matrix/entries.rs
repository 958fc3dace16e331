//! The entries of M: which ones are written, where they are, and what rotors add to them.

use robot_dynamics_number::Scalar;

use crate::Model;
use crate::model::Dof;

/// Row and column of the entries of M on and above the diagonal that are not always zero. The order is that
/// of `batch::mass_matrix_related`: row by row, and by column within a row; row ≤ column.
///
/// Row i has columns i, i + 1, … to the last DoF in the subtree of i. All other entries above the diagonal
/// are zero in every configuration. A robot with mimic joints, or with armature on tendons over several
/// joints, has the whole triangle.
///
/// ```
/// use robot_dynamics::algorithms::mass_matrix_related_entries;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// // One DoF, one entry.
/// assert_eq!(mass_matrix_related_entries(&Model::new(pendulum(1.0, 1.0))?), [(0, 0)]);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
pub fn mass_matrix_related_entries(model: &Model) -> Vec<(usize, usize)> {
    (0..model.nv).flat_map(|i| (i..related_end(model, i)).map(move |j| (i, j))).collect()
}

/// One past the last column of row i among [`mass_matrix_related_entries`].
#[inline(always)]
pub fn related_end(model: &Model, i: usize) -> usize {
    // A mimic joint adds to its leader's coordinate from any place in the tree, and a tendon can span any
    // joints.
    if model.needs_dense_factor { model.nv } else { model.dofs[i].end }
}

/// The entries of M to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    All,
    /// Those of two DoFs on one path to the root, in both triangles. With mimic joints, all.
    Related,
    /// The entries of `Related` in the upper triangle. With mimic joints, the whole triangle.
    RelatedAbove,
    /// The same, row after row without gaps. Requires [`is_plain`].
    Packed,
}

/// Whether M is written row by row: no mimic joints, and no reference points that move with slides.
#[inline(always)]
pub fn is_plain(model: &Model) -> bool {
    !model.needs_dense_factor && !model.points.carried
}

#[inline(always)]
pub(super) fn add_armature<S: Scalar>(model: &Model, mass: &mut [S]) {
    if model.has_armature {
        for dof in &model.dofs {
            mass[dof.coordinate * (model.nv + 1)] += S::from_f64(armature(dof));
        }
        for rotor in &model.rotors {
            for (i, j, entry) in rotor.entries(&model.dofs) {
                mass[i * model.nv + j] += S::from_f64(entry);
            }
        }
    }
}

#[inline(always)]
pub(super) fn armature(dof: &Dof) -> f64 {
    dof.passive.armature * dof.ratio * dof.ratio
}

/// Adds a tree entry M_{i j} (and its mirror image) to the reduced matrix GᵀMG.
#[inline(always)]
pub(super) fn add_reduced<S: Scalar>(model: &Model, mass: &mut [S], i: usize, j: usize, entry: S) {
    let (a, b) = (&model.dofs[i], &model.dofs[j]);
    let entry = entry.scale(a.ratio * b.ratio);
    mass[a.coordinate * model.nv + b.coordinate] += entry;
    if i != j {
        mass[b.coordinate * model.nv + a.coordinate] += entry;
    }
}

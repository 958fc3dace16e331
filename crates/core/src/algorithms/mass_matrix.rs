//! The mass matrix by the composite-rigid-body algorithm, O(n depth).
//!
//! The bodies beyond a joint move as one rigid body when that joint alone accelerates. The momentum that this
//! takes is I^c S. Its component along each ancestor's motion gives that joint's column of M: M_ij = S_iᵀ
//! I^c_j S_j.
//!
//! There are two forms. `world_frame` uses one inertial frame, so no vector is rotated. `body_frames` takes
//! half the operations where expressions are traced, as zeros and ones fold there. **(RBDA §6.2)**

mod body_frames;
mod columns;
mod entries;
mod world_frame;

pub use columns::{project_column, project_columns, write_column};
pub use entries::{Entries, is_plain, mass_matrix_related_entries, related_end};

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::model::native::NativeFunction;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// M(q), nv×nv symmetric, row-major, both triangles, with K = ½ vᵀM v \[kg·m², kg·m, kg\]. Armature adds to
/// the diagonal. **(RBDA §6.2)**
///
/// ```
/// use robot_dynamics::algorithms::{kinetic_energy, mass_matrix};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (w, nv) = (&mut Workspace::new(&model), model.nv());
/// let mut mass = vec![0.0; nv * nv];
/// mass_matrix(&model, w, &q, &mut mass);
/// let half: f64 = (0..nv * nv).map(|at| 0.5 * v[at / nv] * mass[at] * v[at % nv]).sum(); // ½ vᵀM v
/// assert!((half / kinetic_energy(&model, w, &q, &v) - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "CRBA")]
#[inline]
#[track_caller]
pub fn mass_matrix<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], mass: &mut [S]) {
    workspace.check_inputs(model, q);
    check_length("the mass matrix", mass.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if !computed_natively(model, native, NativeFunction::MassMatrix, &[q], &mut [&mut *mass]) {
        write_mass_matrix(model, workspace, q, mass, Entries::All);
    }
}

/// Writes the selected entries of M. The other entries of `mass` are not read; their values afterwards are
/// unspecified.
#[inline]
#[track_caller]
pub fn write_mass_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    mass: &mut [S],
    entries: Entries,
) {
    workspace.check_inputs(model, q);
    check_length("the mass matrix", mass.len(), model.nv * model.nv);
    run(&mut workspace.tree, CompositeBodies { model, q, mass, entries });
}

/// Writes the entries of M in the upper triangle that are not always zero, row by row without gaps. Requires
/// [`is_plain`].
pub fn write_packed_mass_matrix(model: &Model, workspace: &mut Workspace, q: &[f64], mass: &mut [f64]) {
    workspace.check_inputs(model, q);
    run(&mut workspace.tree, CompositeBodies { model, q, mass, entries: Entries::Packed });
}

/// The arguments of the composite-rigid-body algorithm.
pub struct CompositeBodies<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub mass: &'a mut [S],
    pub entries: Entries,
}

compiled_once!(CompositeBodies);

impl<S: Scalar> Kernel<TreeStorage, S> for CompositeBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, mass, entries } = self;
        let (q, mass) = (N::view(q), N::view_mut(mass));
        if M3::<N>::FOLDS_ZEROS {
            body_frames::write_matrix(model, tree, q, mass, entries);
        } else {
            world_frame::write_matrix(model, tree, q, mass, entries);
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::{Entries, mass_matrix, mass_matrix_related_entries, write_mass_matrix};
    use crate::{Model, Workspace, random_state};

    /// The entries above the diagonal equal those of M to the last bit, on random trees.
    #[test]
    fn the_entries_above_the_diagonal_are_those_of_the_matrix() {
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).unwrap();
            let (nv, mut workspace) = (model.nv(), Workspace::new(&model));
            let q = random_state(&model, &mut SplitMix64::new(seed)).q;
            let (mut whole, mut above) = (vec![0.0; nv * nv], vec![f64::NAN; nv * nv]);
            mass_matrix(&model, &mut workspace, &q, &mut whole);
            write_mass_matrix(&model, &mut workspace, &q, &mut above, Entries::RelatedAbove);
            for (i, j) in mass_matrix_related_entries(&model) {
                assert_eq!(above[i * nv + j], whole[i * nv + j], "seed {seed}: {i}, {j}");
            }
        }
    }
}

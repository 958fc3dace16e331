//! The structurally nonzero entries of M of a block.

use robot_dynamics_core::algorithms::mass_matrix::{CompositeBodies, Entries, is_plain, related_end};
use robot_dynamics_core::workspace::buffers::DenseBuffers;
use robot_dynamics_core::{Model, NativeFunction, Workspace};
use robot_dynamics_number::dispatch::Hardware;
use robot_dynamics_number::{Scalar, StateLanes};

use crate::block::{Operation, add_poison};
use crate::kernel_call::call;

/// The entries of M on and above the diagonal that are not always zero.
#[derive(Clone, Copy)]
pub(crate) struct RelatedMass;

impl<T> Operation<T> for RelatedMass {
    fn width(self, model: &Model) -> usize {
        (0..model.nv).map(|i| related_end(model, i) - i).sum()
    }

    fn native(self) -> Option<NativeFunction> {
        Some(NativeFunction::MassMatrixRelated)
    }

    /// |M_ij|² ≤ M_ii M_jj, so the diagonal entries suffice, the first of each row.
    #[inline(always)]
    fn watch<N: StateLanes<Float = T>>(self, model: &Model, packed: &[N], poison: &mut N) {
        let mut k = 0;
        for i in 0..model.nv {
            add_poison(poison, &packed[k..=k], 1);
            k += related_end(model, i) - i;
        }
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        packed: &mut [N],
    ) {
        if is_plain(model) {
            call::<H, _, _>(
                &mut workspace.tree,
                CompositeBodies { model, q, mass: packed, entries: Entries::Packed },
            );
            return;
        }
        let Workspace { tree, dense: DenseBuffers { matrix, .. }, .. } = workspace;
        let (mass, entries) = (&mut matrix[..], Entries::RelatedAbove);
        call::<H, _, _>(tree, CompositeBodies { model, q, mass, entries });
        pack(model, matrix, packed);
    }
}

#[inline(always)]
fn pack<N: Scalar>(model: &Model, matrix: &[N], packed: &mut [N]) {
    let mut k = 0;
    for i in 0..model.nv {
        for j in i..related_end(model, i) {
            packed[k] = matrix[i * model.nv + j];
            k += 1;
        }
    }
}

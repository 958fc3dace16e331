//! The recursions on batches.

use dynamics::Scalar;
use number::dispatch::{Hardware, Kernel};
use number::{StateLanes, View};

use super::block::{Operation, scatter, zero_entry};
use super::within::call;
use crate::algorithms::forward_dynamics::ArticulatedBodies;
use crate::algorithms::inverse_dynamics::{NewtonEuler, upward};
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::factor::sparse;
use crate::scratch::compiled_once::{OverNumber, compiled_once};
use crate::{Model, Workspace};

/// Which forces of the Newton–Euler recursion.
#[derive(Clone, Copy)]
pub enum Forces {
    Inverse,
    Bias,
    Gravity,
}

impl<T> Operation<T> for Forces {
    fn width(self, model: &Model) -> usize {
        model.nv
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, v, a]: [&[N]; 3],
        tau: &mut [N],
    ) {
        let (v, a) = match self {
            Self::Inverse => (Some(v), Some(a)),
            Self::Bias => (Some(v), None),
            Self::Gravity => (None, None),
        };
        let ground = upward(model);
        call::<H, _, _>(
            workspace,
            NewtonEuler { model, q, v, a, ground, with_springs: true, wrenches: &[], tau },
        );
    }
}

/// a = M⁻¹(τ − C v − g).
#[derive(Clone, Copy)]
pub(super) struct Acceleration;

impl<T> Operation<T> for Acceleration {
    fn width(self, model: &Model) -> usize {
        model.nv
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, v, tau]: [&[N]; 3],
        acceleration: &mut [N],
    ) {
        accelerate::<N, H>(model, workspace, q, v, tau, acceleration);
    }
}

/// Forward dynamics of a block.
#[inline(always)]
pub(super) fn accelerate<N: StateLanes, H: Hardware>(
    model: &Model,
    workspace: &mut Workspace<N>,
    q: &[N],
    v: &[N],
    tau: &[N],
    acceleration: &mut [N],
) {
    if model.has_mimic {
        // With followers the robot is no tree: x = τ − C v − g, then M a = x.
        let (ground, tau_out) = (upward(model), &mut *acceleration);
        let newton_euler = NewtonEuler {
            model,
            q,
            v: Some(v),
            a: None,
            ground,
            with_springs: true,
            wrenches: &[],
            tau: tau_out,
        };
        call::<H, _, _>(workspace, newton_euler);
        call::<H, _, _>(workspace, FactoredMass { model, q });
        let mut x = core::mem::take(&mut workspace.vector);
        for k in 0..model.nv {
            x[k] = tau[k] - acceleration[k];
        }
        sparse::solve(&workspace.carrier, &workspace.matrix, &mut x);
        acceleration.copy_from_slice(&x);
        workspace.vector = x;
        return;
    }
    call::<H, _, _>(workspace, ArticulatedBodies { model, q, v, tau, wrenches: &[], acceleration });
}

/// L and D of M = LᵀDL, left in the workspace's matrix.
pub(crate) struct FactoredMass<'a, S> {
    model: &'a Model,
    q: &'a [S],
}

compiled_once!(FactoredMassKind, FactoredMass);

impl<S: Scalar> Kernel<OverNumber, S> for FactoredMass<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, workspace: &mut Workspace<N>) {
        let Self { model, q } = self;
        let mut matrix = core::mem::take(&mut workspace.matrix);
        let (q, entries) = (N::view(q), Entries::Related);
        CompositeBodies { model, q, mass: &mut matrix, entries }.run::<N, H>(workspace);
        sparse::factor(&workspace.carrier, &mut matrix);
        workspace.matrix = matrix;
    }
}

/// M⁻¹.
#[derive(Clone, Copy)]
pub(super) struct InverseMass;

impl<T> Operation<T> for InverseMass {
    fn width(self, model: &Model) -> usize {
        model.nv * model.nv
    }

    /// As for M.
    fn watched_step(self, model: &Model) -> usize {
        model.nv + 1
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        inverse: &mut [N],
    ) {
        call::<H, _, _>(workspace, FactoredMass { model, q });
        let mut row = core::mem::take(&mut workspace.vector);
        sparse::invert(&workspace.carrier, &workspace.matrix, &mut row, inverse);
        workspace.vector = row;
    }

    /// Row by row, each number above the diagonal from its mirror image.
    #[inline(always)]
    fn scatter<N: StateLanes<Float = T>, H: Hardware>(
        self,
        _: &[u32],
        inverse: &[N],
        rows: &mut [T],
        states: usize,
    ) {
        let nv = inverse.len().isqrt();
        for i in 0..nv {
            let entry = |j: usize| &inverse[i.max(j) * nv + i.min(j)];
            scatter(nv, entry, &mut rows[i * nv..], nv * nv, states);
        }
    }
}

/// M.
#[derive(Clone, Copy)]
pub(super) struct Mass;

impl<T> Operation<T> for Mass {
    fn width(self, model: &Model) -> usize {
        model.nv * model.nv
    }

    /// |M_ij|² ≤ M_ii M_jj: the diagonal tells.
    fn watched_step(self, model: &Model) -> usize {
        model.nv + 1
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        mass: &mut [N],
    ) {
        call::<H, _, _>(workspace, CompositeBodies { model, q, mass, entries: Entries::RelatedAbove });
        if model.nv > 1 && !model.has_mimic {
            mass[zero_entry(model.nv)] = N::zero();
        }
    }

    #[inline(always)]
    fn scatter<N: StateLanes<Float = T>, H: Hardware>(
        self,
        mirror: &[u32],
        mass: &[N],
        rows: &mut [T],
        states: usize,
    ) {
        let mirror = &mirror[..mass.len()];
        scatter(mass.len(), |k| &mass[mirror[k] as usize], rows, mass.len(), states);
    }
}

//! The recursions on batches.

use robot_dynamics_core::algorithms::forward_dynamics::ArticulatedBodies;
use robot_dynamics_core::algorithms::inverse_dynamics::{NewtonEuler, upward};
use robot_dynamics_core::algorithms::mass_matrix::{CompositeBodies, Entries};
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::workspace::buffers::DenseBuffers;
use robot_dynamics_core::workspace::compiled_once::compiled_once;
use robot_dynamics_core::workspace::tree::{TreeMemory, TreeStorage};
use robot_dynamics_core::{Model, NativeFunction, Workspace};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, StateLanes, View};

use crate::block::Operation;
use crate::kernel_call::call;

/// The forces that the Newton–Euler recursion computes.
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

    fn native(self) -> Option<NativeFunction> {
        Some(match self {
            Self::Inverse => NativeFunction::InverseDynamics,
            Self::Bias => NativeFunction::Bias,
            Self::Gravity => NativeFunction::Gravity,
        })
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
            &mut workspace.tree,
            NewtonEuler { model, q, v, a, ground, with_springs: true, wrenches: &[], tau },
        );
    }
}

/// a = M⁻¹(τ − C v − g).
#[derive(Clone, Copy)]
pub(crate) struct Acceleration;

impl<T> Operation<T> for Acceleration {
    fn width(self, model: &Model) -> usize {
        model.nv
    }

    fn native(self) -> Option<NativeFunction> {
        Some(NativeFunction::ForwardDynamics)
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
pub(crate) fn accelerate<N: StateLanes, H: Hardware>(
    model: &Model,
    workspace: &mut Workspace<N>,
    q: &[N],
    v: &[N],
    tau: &[N],
    acceleration: &mut [N],
) {
    if model.needs_dense_factor {
        // If branches are coupled, the articulated-body recursion does not apply: compute x = τ − C v − g,
        // then solve M a = x.
        call::<H, _, _>(&mut workspace.tree, NewtonEuler::bias(model, q, v, acceleration));
        let Workspace { tree, dense: DenseBuffers { matrix: mass, dof_parent, .. }, .. } = workspace;
        for k in 0..model.nv {
            acceleration[k] = tau[k] - acceleration[k];
        }
        call::<H, _, _>(tree, FactoredMass { model, q, dof_parent, mass });
        sparse::solve(dof_parent, mass, acceleration);
        return;
    }
    call::<H, _, _>(&mut workspace.tree, ArticulatedBodies { model, q, v, tau, wrenches: &[], acceleration });
}

/// L and D of M = LᵀDL.
pub(crate) struct FactoredMass<'a, S> {
    model: &'a Model,
    q: &'a [S],
    dof_parent: &'a [usize],
    mass: &'a mut [S],
}

compiled_once!(FactoredMass);

impl<S: Scalar> Kernel<TreeStorage, S> for FactoredMass<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, dof_parent, mass } = self;
        let (q, mass, entries) = (N::view(q), N::view_mut(mass), Entries::Related);
        CompositeBodies { model, q, mass: &mut *mass, entries }.run::<N, H>(tree);
        sparse::factor(dof_parent, mass);
    }
}

/// M⁻¹.
#[derive(Clone, Copy)]
pub(crate) struct InverseMass;

impl<T> Operation<T> for InverseMass {
    fn width(self, model: &Model) -> usize {
        model.nv * model.nv
    }

    fn native(self) -> Option<NativeFunction> {
        Some(NativeFunction::InverseMassMatrix)
    }

    /// As for M: the diagonal bounds all entries.
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
        let Workspace { tree, dense: DenseBuffers { matrix: mass, vector: row, dof_parent, .. }, .. } =
            workspace;
        call::<H, _, _>(tree, FactoredMass { model, q, dof_parent, mass });
        sparse::invert(dof_parent, mass, row, inverse);
        // The recursion writes the upper triangle only.
        for i in 0..model.nv {
            for j in i + 1..model.nv {
                inverse[i * model.nv + j] = inverse[j * model.nv + i];
            }
        }
    }
}

/// M.
#[derive(Clone, Copy)]
pub(crate) struct Mass;

impl<T> Operation<T> for Mass {
    fn width(self, model: &Model) -> usize {
        model.nv * model.nv
    }

    fn native(self) -> Option<NativeFunction> {
        Some(NativeFunction::MassMatrix)
    }

    /// |M_ij|² ≤ M_ii M_jj, so the diagonal entries suffice.
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
        call::<H, _, _>(&mut workspace.tree, CompositeBodies { model, q, mass, entries: Entries::All });
    }
}

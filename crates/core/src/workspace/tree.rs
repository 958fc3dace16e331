//! The memory of the recursions over the tree, with a part for each stage.

use core::marker::PhantomData;

use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::dispatch::{StateMemory, Storage};
use robot_dynamics_number::{Float, Scalar, Specialization, TypeFamily};

use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{ArticulatedInertia, DofElimination, MassFlux, SpatialInertia};
use crate::spatial::motion::{AxisMotion, BodyMotion, MotionVector};
use crate::spatial::transform::Transform;
use crate::workspace::branch_block::BranchBlock;
use crate::workspace::derivatives::DerivativeBuffers;
use crate::workspace::momentum_block::momentum_blocks;
use crate::workspace::native::NativeScratch;
use crate::workspace::pullback;
use crate::{InstructionSet, Model};

/// The memory of kernels, over one scalar type.
#[derive(Clone, Debug)]
pub struct TreeMemory<S: Scalar> {
    /// The memory over the machine's vector type, if it is faster than `f64` or `f32`.
    pub fast: Option<StateMemory<TreeStorage>>,
    pub native: NativeScratch<S>,
    pub angles: Angles<S>,
    pub dofs: DofBuffers<S>,
    pub bodies: BodyBuffers<S>,
    pub world: WorldFrameBuffers<S>,
    pub inertias: Inertias<S>,
    pub blocks: Blocks<S>,
    pub derivatives: DerivativeBuffers<S>,
    pub pullback: pullback::PullbackBuffers<S>,
}

/// [`TreeMemory`] over any scalar type.
#[derive(Debug)]
pub struct TreeStorage;

impl Storage for TreeStorage {
    type Over<S: Scalar> = TreeMemory<S>;
    type Input<'a> = TreeSize<'a>;
    fn new<S: Scalar>(size: TreeSize<'_>) -> TreeMemory<S> {
        TreeMemory::portable(size.model, size.dof_parent)
    }
}

/// The size of a memory. If `dof_parent` is empty, there is no memory for derivatives.
#[derive(Clone, Copy, Debug)]
pub struct TreeSize<'a> {
    model: &'a Model,
    dof_parent: &'a [usize],
}

/// Positions of the one-DoF joints, with their sines and cosines; one entry per body.
#[derive(Clone, Debug)]
pub struct Angles<S> {
    pub angle: Vec<S>,
    pub sine: Vec<S>,
    pub cosine: Vec<S>,
}

/// Velocity, acceleration and force of each DoF of the tree (mimic joints included).
#[derive(Clone, Debug)]
pub struct DofBuffers<S> {
    pub v: Vec<S>,
    pub a: Vec<S>,
    pub tau: Vec<S>,
}

/// One entry per body, in the body's own frame.
#[derive(Clone, Debug)]
pub struct BodyBuffers<S: Scalar> {
    /// `parent_from_body`.
    pub place: Vec<Transform<S>>,
    /// The velocity of the frame's origin, and ω.
    pub velocity: Vec<MotionVector<S>>,
    pub motion: Vec<BodyMotion<S>>,
    /// Motion along the world's axes.
    pub axis_motion: Vec<AxisMotion<S>>,
    pub force: Vec<ForceVector<S>>,
    /// The total force of the body's subtree.
    pub subtree_force: Vec<ForceVector<S>>,
}

/// Placements and motions in one inertial frame; see [`world_frame`](crate::kinematics::world_frame).
#[derive(Clone, Debug)]
pub struct WorldFrameBuffers<S: Scalar> {
    /// `world_from_body`, or the same placement relative to the body's reference point.
    pub pose: Vec<Transform<S>>,
    /// The reference points: those of trees' roots in the world, others relative to their tree's root.
    pub points: Vec<V3<S>>,
    /// The vector to each point from that of the parent's tree.
    pub levers: Vec<V3<S>>,
    /// Each DoF's motion S.
    pub column: Vec<MotionVector<S>>,
    /// Ṡ.
    pub column_rate: Vec<MotionVector<S>>,
    /// Each body's velocity V, and V̇ or a part of it, as motions in the inertial frame.
    pub twist: Vec<MotionVector<S>>,
    pub twist_rate: Vec<MotionVector<S>>,
    pub flow: Vec<MassFlux<S>>,
    /// Bodies between a frame and the root.
    pub chain: Vec<usize>,
}

/// Inertias of bodies and of their subtrees.
#[derive(Clone, Debug)]
pub struct Inertias<S: Scalar> {
    /// The subtree as one rigid body.
    pub composite: Vec<SpatialInertia<S>>,
    /// The body with the joints beyond it free.
    pub articulated: Vec<ArticulatedInertia<S>>,
    /// One entry per DoF, for its elimination.
    pub pivot: Vec<DofElimination<S>>,
}

/// Momenta of the DoFs, one per column.
#[derive(Clone, Debug)]
pub struct Blocks<S> {
    /// A row-major matrix of six rows, with a column for each DoF.
    pub rows: Vec<S>,
    /// Momenta and their rates by blocks of columns, for C.
    pub branch_block: Vec<BranchBlock<S>>,
}

/// A place for a new memory.
struct NewMemory<'a>(PhantomData<&'a ()>);

impl<'a> TypeFamily for NewMemory<'a> {
    type Over<S: Scalar> = &'a mut Option<TreeMemory<S>>;
}

/// A memory over a float, with the machine's vector type up to a set of instructions.
fn over_float<T: Float>(size: TreeSize<'_>, limit: InstructionSet) -> TreeMemory<T> {
    let fast = StateMemory::new::<T>(limit, size);
    let instructions = fast.as_ref().map_or(InstructionSet::Portable, StateMemory::instruction_set);
    TreeMemory { fast, native: NativeScratch::new(instructions), ..TreeStorage::new(size) }
}

fn over_f64(size: TreeSize<'_>, limit: InstructionSet, made: &mut Option<TreeMemory<f64>>) {
    *made = Some(over_float(size, limit));
}

fn over_f32(size: TreeSize<'_>, limit: InstructionSet, made: &mut Option<TreeMemory<f32>>) {
    *made = Some(over_float(size, limit));
}

impl<S: Scalar> TreeMemory<S> {
    /// A memory for instructions up to these. `dof_parent` is λ of each coordinate; if it is empty, there is
    /// no memory for derivatives.
    #[inline(always)]
    pub fn limited(model: &Model, dof_parent: &[usize], limit: InstructionSet) -> Self {
        let size = TreeSize { model, dof_parent };
        let mut made = None;
        // A branch on a constant: memories of floats are compiled only in this library.
        if const { S::IS_FLOAT } {
            match S::specialize::<NewMemory<'_>>(&mut made) {
                Specialization::F64(made) => over_f64(size, limit, made),
                Specialization::F32(made) => over_f32(size, limit, made),
                Specialization::Other(_) => {}
            }
        } else {
            made = Some(TreeStorage::new(size));
        }
        let Some(made) = made else { unreachable!("a float says which one it is") };
        made
    }

    /// A memory over this scalar type only, for kernels.
    #[inline(never)]
    pub fn portable(model: &Model, dof_parent: &[usize]) -> Self {
        let (bodies, dofs, points) = (model.bodies.len(), model.dofs.len(), model.points.count);
        let zero = S::zero();
        let (v3, m3, sym) = (V3::zero(), M3::zero(), Sym3::zero());
        let (motion, force) = (MotionVector::zero(), ForceVector::zero());
        let articulated =
            ArticulatedInertia { mass: sym, coupling: m3, coupling_back: m3, inertia: sym, bias: force };
        Self {
            fast: None,
            native: NativeScratch::new(InstructionSet::Portable),
            angles: Angles {
                angle: filled(zero, bodies),
                sine: filled(zero, bodies),
                cosine: filled(zero, bodies),
            },
            dofs: DofBuffers { v: filled(zero, dofs), a: filled(zero, dofs), tau: filled(zero, dofs) },
            bodies: BodyBuffers {
                place: filled(Transform { rotation: m3, translation: v3 }, bodies),
                motion: filled(BodyMotion { angular: v3, gradient: m3, origin: v3, alpha: v3 }, bodies),
                velocity: filled(motion, bodies),
                axis_motion: filled(AxisMotion { angular: v3, alpha: v3, origin: v3 }, bodies),
                force: filled(force, bodies),
                subtree_force: filled(force, bodies),
            },
            world: WorldFrameBuffers {
                pose: filled(Transform { rotation: m3, translation: v3 }, bodies),
                points: filled(v3, points),
                levers: filled(v3, points),
                column: filled(motion, dofs),
                column_rate: filled(motion, dofs),
                twist: filled(motion, bodies),
                twist_rate: filled(motion, bodies),
                flow: filled(MassFlux { momentum: v3, first_moment_rate: m3 }, bodies),
                chain: vec![0; bodies],
            },
            inertias: Inertias {
                composite: filled(SpatialInertia { mass: zero, first_moment: v3, inertia: sym }, bodies),
                articulated: filled(articulated, bodies),
                pivot: filled(DofElimination { column: force, residual: zero, inverse: zero }, dofs),
            },
            blocks: Blocks {
                rows: filled(zero, 6 * dofs),
                branch_block: filled(BranchBlock::zero(), momentum_blocks(dofs)),
            },
            derivatives: DerivativeBuffers::new(model, dof_parent),
            pullback: pullback::PullbackBuffers::new(model),
        }
    }
}

/// A vector of equal values: one function for each type of field. Written out for each field, these loops
/// would dominate the compile time of a memory of wide registers.
#[inline(never)]
fn filled<T: Clone>(value: T, count: usize) -> Vec<T> {
    vec![value; count]
}

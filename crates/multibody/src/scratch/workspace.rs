//! The scratch memory of the recursions; it belongs to the caller.

use core::marker::PhantomData;

use dynamics::Scalar;
use number::dispatch::{Make, OneState};
use number::{AsFloat, Float, Form};

use crate::factor::sparse::coordinate_carriers;
use crate::model::identity::Identity;
use crate::model::length::check_length;
use crate::scratch::branch_block::BranchBlock;
use crate::scratch::compiled_once::OverNumber;
use crate::scratch::derivatives::Scratch;
use crate::scratch::extent;
use crate::scratch::momentum_block::{MomentumBlock, WIDTH as BLOCK_WIDTH, momentum_blocks};
use crate::spatial::algebra::{M3, Sym3, V3};
use crate::spatial::screw::{
    Articulated, AxisMotion, BodyMotion, Composite, Flow, Force, Pivot, Place, Screw,
};
use crate::{InstructionSet, Model};

/// Scratch for the algorithms on one model, over one scalar.
///
/// Every algorithm writes what it reads: no call depends on what an earlier call left here, so one
/// workspace serves all algorithms in any order. One per thread.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar = f64> {
    /// Whose it is.
    pub(crate) robot: Identity,
    /// Where kernels compute instead, on a machine with a better number than `f64` or `f32`.
    pub(crate) fast: Option<OneState<OverNumber>>,
    /// Positions of the one-freedom joints, their sines and cosines; one entry a body.
    pub(crate) angle: Vec<S>,
    pub(crate) sine: Vec<S>,
    pub(crate) cosine: Vec<S>,
    /// Velocity, acceleration and force of each freedom of the tree (followers included).
    pub(crate) v: Vec<S>,
    pub(crate) a: Vec<S>,
    pub(crate) tau: Vec<S>,
    pub(crate) place: Vec<Place<S>>,
    pub(crate) motion: Vec<BodyMotion<S>>,
    pub(crate) axis_motion: Vec<AxisMotion<S>>,
    pub(crate) force: Vec<Force<S>>,
    pub(crate) composite: Vec<Composite<S>>,
    pub(crate) articulated: Vec<Articulated<S>>,
    pub(crate) pivot: Vec<Pivot<S>>,
    /// A dense nv×nv matrix, row-major, for factorisations.
    pub(crate) matrix: Vec<S>,
    pub(crate) vector: Vec<S>,
    /// `world_from_body`, or the same from the body's reference point.
    pub(crate) world: Vec<Place<S>>,
    /// The reference points: of a tree's root in the world, of others from their tree's root.
    pub(crate) points: Vec<V3<S>>,
    /// Each from the point of the parent's tree.
    pub(crate) levers: Vec<V3<S>>,
    pub(crate) column: Vec<Screw<S>>,
    /// A 6×freedoms matrix by rows: one momentum a column.
    pub(crate) rows: Vec<S>,
    /// The same by blocks of columns.
    pub(crate) momentum_block: Vec<MomentumBlock<S>>,
    pub(crate) branch_block: Vec<BranchBlock<S>>,
    pub(crate) column_rate: Vec<Screw<S>>,
    /// Each body's velocity, and its rate, as motions of the whole space.
    pub(crate) twist: Vec<Screw<S>>,
    pub(crate) twist_rate: Vec<Screw<S>>,
    pub(crate) flow: Vec<Flow<S>>,
    /// λ: the coordinate that carries each coordinate, or `sparse::NONE`.
    pub(crate) carrier: Vec<usize>,
    /// Bodies between a frame and the root.
    pub(crate) chain: Vec<usize>,
    /// Twice nq numbers: a configuration and its rate.
    pub(crate) coordinates: Vec<S>,
    /// Each body: a force of what hangs on it.
    pub(crate) beyond: Vec<Force<S>>,
    pub(crate) derivatives: Scratch<S>,
    /// Of the watch over the rank of M.
    pub(crate) rank: extent::Scratch,
}

/// A place for a workspace.
struct Made<'a>(PhantomData<&'a ()>);

impl<'a> Form for Made<'a> {
    type Over<S: Scalar> = &'a mut Option<Workspace<S>>;
}

/// How much a workspace is for.
#[derive(Clone, Copy)]
enum Extent {
    Everything,
    /// [`check_rank`](crate::check_rank) alone: O(n) memory, without followers.
    Rank,
}

/// What a workspace is made from.
struct Maker<'a> {
    model: &'a Model,
    extent: Extent,
}

impl Make<OverNumber> for Maker<'_> {
    fn make<S: Scalar>(&self) -> Workspace<S> {
        let model = self.model;
        match self.extent {
            Extent::Everything => Workspace::sized(model, coordinate_carriers(model), model.nv * model.nv),
            Extent::Rank => {
                Workspace::sized(model, Vec::new(), if model.has_mimic { model.nv * model.nv } else { 0 })
            }
        }
    }
}

/// A workspace over a float, with the machine's number up to a set of instructions.
fn over_float<T: Float>(maker: &Maker<'_>, limit: InstructionSet) -> Workspace<T> {
    Workspace { fast: OneState::new::<T>(limit, maker), ..maker.make() }
}

fn over_f64(maker: &Maker<'_>, limit: InstructionSet, made: &mut Option<Workspace<f64>>) {
    *made = Some(over_float(maker, limit));
}

fn over_f32(maker: &Maker<'_>, limit: InstructionSet, made: &mut Option<Workspace<f32>>) {
    *made = Some(over_float(maker, limit));
}

impl<S: Scalar> Workspace<S> {
    /// Memory for this model: the only allocation of the non-allocating calls.
    pub fn new(model: &Model) -> Self {
        Self::limited(model, InstructionSet::best())
    }

    /// As [`Workspace::new`], but its algorithms run on no newer instructions than these: to reproduce the results of a
    /// machine without the newer ones. They are the same to rounding; between AVX2 and AVX-512 they are the same bits.
    pub fn limited(model: &Model, limit: InstructionSet) -> Self {
        Self::make(&Maker { model, extent: Extent::Everything }, limit)
    }

    #[inline(always)]
    fn make(maker: &Maker<'_>, limit: InstructionSet) -> Self {
        let mut made = None;
        // A branch on a constant: what is made of floats is compiled in this library alone.
        if const { S::IS_FLOAT } {
            match S::as_float::<Made<'_>>(&mut made) {
                AsFloat::F64(made) => over_f64(maker, limit, made),
                AsFloat::F32(made) => over_f32(maker, limit, made),
                AsFloat::Other(_) => {}
            }
        } else {
            made = Some(maker.make());
        }
        let Some(made) = made else { unreachable!("a float says which one it is") };
        made
    }

    /// Refuses another robot's workspace, and a q of another length: the first line of every call.
    #[inline(always)]
    #[track_caller]
    pub(crate) fn admit(&self, model: &Model, q: &[S]) {
        self.robot.check(model, "the workspace");
        check_length("q", q.len(), model.nq);
    }

    /// Memory of one number alone, as kernels compute with.
    #[cfg(feature = "batch")]
    pub(crate) fn scratch(model: &Model) -> Self {
        Maker { model, extent: Extent::Everything }.make()
    }

    /// The instructions that its recursions run on; where these are AVX2, derivatives may run on AVX-512.
    pub fn instruction_set(&self) -> InstructionSet {
        match self.fast.as_ref().map(OneState::instruction_set) {
            None => InstructionSet::Portable,
            Some(InstructionSet::Avx512) => InstructionSet::Avx2,
            Some(set) => set,
        }
    }

    /// For [`check_rank`](crate::check_rank) alone: O(n) memory, without followers.
    pub(crate) fn for_rank(model: &Model) -> Self {
        Self::make(&Maker { model, extent: Extent::Rank }, InstructionSet::best())
    }

    /// With room for so many entries of M, and for derivatives where the carriers are given.
    #[inline(never)]
    fn sized(model: &Model, carrier: Vec<usize>, entries: usize) -> Self {
        let (bodies, dofs, nv) = (model.bodies.len(), model.dofs.len(), model.nv);
        let zero = S::zero();
        let (v3, m3, sym) = (V3::zero(), M3::zero(), Sym3::zero());
        let force = Force::zero();
        Self {
            robot: model.identity.clone(),
            fast: None,
            angle: filled(zero, bodies),
            sine: filled(zero, bodies),
            cosine: filled(zero, bodies),
            v: filled(zero, dofs),
            a: filled(zero, dofs),
            tau: filled(zero, dofs),
            place: filled(Place { rotation: m3, translation: v3 }, bodies),
            motion: filled(BodyMotion { angular: v3, gradient: m3, origin: v3, alpha: v3 }, bodies),
            axis_motion: filled(AxisMotion { angular: v3, alpha: v3, origin: v3 }, bodies),
            force: filled(force, bodies),
            composite: filled(Composite { mass: zero, first_moment: v3, inertia: sym }, bodies),
            articulated: filled(
                Articulated { mass: sym, coupling: m3, coupling_back: m3, inertia: sym, bias: force },
                bodies,
            ),
            pivot: filled(Pivot { column: force, residual: zero }, dofs),
            matrix: filled(zero, entries),
            vector: filled(zero, nv),
            world: filled(Place { rotation: m3, translation: v3 }, bodies),
            points: filled(v3, model.points.count),
            levers: filled(v3, model.points.count),
            column: filled(force, dofs),
            rows: filled(zero, 6 * dofs),
            momentum_block: filled([[zero; BLOCK_WIDTH]; 6], momentum_blocks(dofs)),
            branch_block: filled(BranchBlock::zero(), momentum_blocks(dofs)),
            column_rate: filled(force, dofs),
            twist: filled(force, bodies),
            twist_rate: filled(force, bodies),
            flow: filled(Flow { momentum: v3, stir: m3 }, bodies),
            beyond: filled(force, bodies),
            derivatives: Scratch::new(model, &carrier),
            carrier,
            rank: extent::Scratch::new(model),
            chain: vec![0; bodies],
            coordinates: filled(zero, 2 * model.nq),
        }
    }
}

/// So many of one value: one function for each type of field. Written out for each field, these loops would be most of
/// what a workspace of wide registers takes to compile.
#[inline(never)]
fn filled<T: Clone>(value: T, count: usize) -> Vec<T> {
    vec![value; count]
}

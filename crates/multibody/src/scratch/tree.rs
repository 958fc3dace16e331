//! The memory that the recursions over the tree work in, a part for each stage.

use core::marker::PhantomData;

use dynamics::Scalar;
use number::dispatch::{Make, OneState};
use number::{AsFloat, Float, Form};

use crate::scratch::branch_block::BranchBlock;
use crate::scratch::compiled_once::OverNumber;
use crate::scratch::derivatives::Scratch;
use crate::scratch::momentum_block::momentum_blocks;
use crate::scratch::native::NativeScratch;
use crate::scratch::pullback;
use crate::spatial::algebra::{M3, Sym3, V3};
use crate::spatial::screw::{
    Articulated, AxisMotion, BodyMotion, Composite, Flow, Force, Pivot, Place, Screw,
};
use crate::{InstructionSet, Model};

/// What kernels read and write, over one number.
#[derive(Clone, Debug)]
pub(crate) struct TreeMemory<S: Scalar> {
    /// Where kernels compute instead, on a machine with a better number than `f64` or `f32`.
    pub(crate) fast: Option<OneState<OverNumber>>,
    pub(crate) native: NativeScratch<S>,
    pub(crate) angles: Angles<S>,
    pub(crate) freedoms: PerFreedom<S>,
    pub(crate) bodies: InBodies<S>,
    pub(crate) screws: Screws<S>,
    pub(crate) inertias: Inertias<S>,
    pub(crate) blocks: Blocks<S>,
    pub(crate) derivatives: Scratch<S>,
    pub(crate) pullback: pullback::Scratch<S>,
}

/// Positions of the one-freedom joints, their sines and cosines; one entry a body.
#[derive(Clone, Debug)]
pub(crate) struct Angles<S> {
    pub(crate) angle: Vec<S>,
    pub(crate) sine: Vec<S>,
    pub(crate) cosine: Vec<S>,
}

/// Velocity, acceleration and force of each freedom of the tree (followers included).
#[derive(Clone, Debug)]
pub(crate) struct PerFreedom<S> {
    pub(crate) v: Vec<S>,
    pub(crate) a: Vec<S>,
    pub(crate) tau: Vec<S>,
}

/// One entry a body, given in the body's own frame.
#[derive(Clone, Debug)]
pub(crate) struct InBodies<S: Scalar> {
    /// `parent_from_body`.
    pub(crate) place: Vec<Place<S>>,
    /// Of the frame's origin, and ω.
    pub(crate) velocity: Vec<Screw<S>>,
    pub(crate) motion: Vec<BodyMotion<S>>,
    /// Motion along the world's axes.
    pub(crate) axis_motion: Vec<AxisMotion<S>>,
    pub(crate) force: Vec<Force<S>>,
    /// A force of what hangs on the body.
    pub(crate) beyond: Vec<Force<S>>,
}

/// Placements and motions in one inertial frame; see [`screws`](crate::stages::screws).
#[derive(Clone, Debug)]
pub(crate) struct Screws<S: Scalar> {
    /// `world_from_body`, or the same from the body's reference point.
    pub(crate) world: Vec<Place<S>>,
    /// The reference points: of a tree's root in the world, of others from their tree's root.
    pub(crate) points: Vec<V3<S>>,
    /// Each from the point of the parent's tree.
    pub(crate) levers: Vec<V3<S>>,
    /// Each freedom's motion S.
    pub(crate) column: Vec<Screw<S>>,
    /// Ṡ.
    pub(crate) column_rate: Vec<Screw<S>>,
    /// Each body's velocity V, and V̇ or what of it is known, as motions of the whole space.
    pub(crate) twist: Vec<Screw<S>>,
    pub(crate) twist_rate: Vec<Screw<S>>,
    pub(crate) flow: Vec<Flow<S>>,
    /// Bodies between a frame and the root.
    pub(crate) chain: Vec<usize>,
}

/// What of a body, and of all that hangs on it, resists motion.
#[derive(Clone, Debug)]
pub(crate) struct Inertias<S: Scalar> {
    /// Moving as one.
    pub(crate) composite: Vec<Composite<S>>,
    /// With the joints beyond free.
    pub(crate) articulated: Vec<Articulated<S>>,
    /// One entry a freedom, which is eliminated.
    pub(crate) pivot: Vec<Pivot<S>>,
}

/// Momenta of the freedoms, one a column, side by side.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<S> {
    /// A 6×freedoms matrix by rows.
    pub(crate) rows: Vec<S>,
    /// Momenta and their rates by blocks of columns, for C.
    pub(crate) branch_block: Vec<BranchBlock<S>>,
}

/// A place for a memory.
struct Made<'a>(PhantomData<&'a ()>);

impl<'a> Form for Made<'a> {
    type Over<S: Scalar> = &'a mut Option<TreeMemory<S>>;
}

/// What a memory is made from. Where the carriers are left empty there is no room for derivatives.
struct Maker<'a> {
    model: &'a Model,
    carrier: &'a [usize],
}

impl Make<OverNumber> for Maker<'_> {
    fn make<S: Scalar>(&self) -> TreeMemory<S> {
        TreeMemory::portable(self.model, self.carrier)
    }
}

/// A memory over a float, with the machine's number up to a set of instructions.
fn over_float<T: Float>(maker: &Maker<'_>, limit: InstructionSet) -> TreeMemory<T> {
    let fast = OneState::new::<T>(limit, maker);
    let instructions = fast.as_ref().map_or(InstructionSet::Portable, OneState::instruction_set);
    TreeMemory { fast, native: NativeScratch::new(instructions), ..maker.make() }
}

fn over_f64(maker: &Maker<'_>, limit: InstructionSet, made: &mut Option<TreeMemory<f64>>) {
    *made = Some(over_float(maker, limit));
}

fn over_f32(maker: &Maker<'_>, limit: InstructionSet, made: &mut Option<TreeMemory<f32>>) {
    *made = Some(over_float(maker, limit));
}

impl<S: Scalar> TreeMemory<S> {
    /// On instructions up to these. `carrier` is λ of each coordinate; where it is left empty there is no room for
    /// derivatives.
    #[inline(always)]
    pub(crate) fn limited(model: &Model, carrier: &[usize], limit: InstructionSet) -> Self {
        let maker = &Maker { model, carrier };
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

    /// Of this number alone, as kernels compute with.
    #[inline(never)]
    pub(crate) fn portable(model: &Model, carrier: &[usize]) -> Self {
        let (bodies, dofs, points) = (model.bodies.len(), model.dofs.len(), model.points.count);
        let zero = S::zero();
        let (v3, m3, sym) = (V3::zero(), M3::zero(), Sym3::zero());
        let force = Force::zero();
        let articulated =
            Articulated { mass: sym, coupling: m3, coupling_back: m3, inertia: sym, bias: force };
        Self {
            fast: None,
            native: NativeScratch::new(InstructionSet::Portable),
            angles: Angles {
                angle: filled(zero, bodies),
                sine: filled(zero, bodies),
                cosine: filled(zero, bodies),
            },
            freedoms: PerFreedom { v: filled(zero, dofs), a: filled(zero, dofs), tau: filled(zero, dofs) },
            bodies: InBodies {
                place: filled(Place { rotation: m3, translation: v3 }, bodies),
                motion: filled(BodyMotion { angular: v3, gradient: m3, origin: v3, alpha: v3 }, bodies),
                velocity: filled(force, bodies),
                axis_motion: filled(AxisMotion { angular: v3, alpha: v3, origin: v3 }, bodies),
                force: filled(force, bodies),
                beyond: filled(force, bodies),
            },
            screws: Screws {
                world: filled(Place { rotation: m3, translation: v3 }, bodies),
                points: filled(v3, points),
                levers: filled(v3, points),
                column: filled(force, dofs),
                column_rate: filled(force, dofs),
                twist: filled(force, bodies),
                twist_rate: filled(force, bodies),
                flow: filled(Flow { momentum: v3, stir: m3 }, bodies),
                chain: vec![0; bodies],
            },
            inertias: Inertias {
                composite: filled(Composite { mass: zero, first_moment: v3, inertia: sym }, bodies),
                articulated: filled(articulated, bodies),
                pivot: filled(Pivot { column: force, residual: zero, inverse: zero }, dofs),
            },
            blocks: Blocks {
                rows: filled(zero, 6 * dofs),
                branch_block: filled(BranchBlock::zero(), momentum_blocks(dofs)),
            },
            derivatives: Scratch::new(model, carrier),
            pullback: pullback::Scratch::new(model),
        }
    }
}

/// So many of one value: one function for each type of field. Written out for each field, these loops would be most of
/// what a memory of wide registers takes to compile.
#[inline(never)]
fn filled<T: Clone>(value: T, count: usize) -> Vec<T> {
    vec![value; count]
}

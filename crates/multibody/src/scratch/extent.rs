//! What the terms of a body's inertia add up to when none of them cancel.

use crate::Model;
use crate::joint::Motion;
use crate::model::Body;

/// Mass, and first and second moments of what hangs on a body, with every distance taken along the joints:
/// m = Σ mᵢ, H = Σ mᵢℓᵢ, J = Σ mᵢℓᵢ², ℓ ≥ the distance from the body's origin.
///
/// N of a freedom is made of them. The true moment about an axis can be far smaller, as when an arm is folded back
/// onto it; the terms that it was added up from were as large as N, and so are their roundings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// m \[kg\].
    pub mass: f64,
    /// H \[kg·m\].
    pub first: f64,
    /// J \[kg·m²\].
    pub second: f64,
    /// The least dₖ/Nₖ of the freedoms from this body on.
    pub least: f64,
}

impl Extent {
    /// Of one body.
    fn of(body: &Body) -> Self {
        let norm = |entries: &[f64]| entries.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self {
            mass: body.mass.abs(),
            first: norm(&body.first_moment),
            second: norm(body.inertia.as_flattened()),
            least: 1.0,
        }
    }

    /// Takes in what hangs on a child whose origin is this far away.
    #[inline(always)]
    pub(crate) fn add(&mut self, child: &Self, distance: f64) {
        self.mass += child.mass;
        self.first += distance * child.mass + child.first;
        self.second += distance * (distance * child.mass + 2.0 * child.first) + child.second;
        self.least = self.least.min(child.least);
    }

    /// N of freedom k, without armature: the size of sᵀI s.
    #[inline(always)]
    pub(crate) fn along(&self, motion: Motion, k: usize) -> f64 {
        let (slide, turn) = motion.reach(k);
        slide * (slide * self.mass + 2.0 * turn * self.first) + turn * turn * self.second
    }
}

/// The watch's part of a workspace.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    /// Each body alone.
    pub(crate) own: Vec<Extent>,
    /// Each body with what hangs on it.
    pub(crate) extent: Vec<Extent>,
    /// |p|: how far each body's origin is from its parent's.
    pub(crate) distance: Vec<f64>,
    /// √Nₖ of each freedom of the tree.
    pub(crate) root: Vec<f64>,
    /// Whether these are the same in all configurations, as origins of bodies on hinges keep their distances; and whether they are known.
    pub(crate) keeps_extents: bool,
    pub(crate) has_extents: bool,
    /// 1/dₖ.
    pub(crate) inverse: Vec<f64>,
    /// |zᵢ| √Nᵢ by freedom or coordinate.
    pub(crate) share: Vec<f64>,
    /// √N and z by coordinate, of robots whose branches are coupled.
    pub(crate) reduced: Vec<f64>,
    pub(crate) motion: Vec<f64>,
    /// Of the same robots M, nv×nv, row-major.
    pub(crate) matrix: Vec<f64>,
}

impl Scratch {
    pub(crate) fn new(model: &Model) -> Self {
        let (bodies, dofs) = (model.bodies.len(), model.dofs.len());
        let own: Vec<Extent> = model.bodies.iter().map(Extent::of).collect();
        let reduced = if model.couples_branches { model.nv } else { 0 };
        Self {
            extent: own.clone(),
            own,
            distance: vec![0.0; bodies],
            root: vec![0.0; dofs],
            keeps_extents: !model.couples_branches
                && model.bodies.iter().all(|body| body.motion == Motion::Revolute),
            has_extents: false,
            inverse: vec![0.0; dofs],
            share: vec![0.0; dofs],
            reduced: vec![0.0; reduced],
            motion: vec![0.0; reduced],
            matrix: vec![0.0; reduced * reduced],
        }
    }
}

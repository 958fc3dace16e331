//! The sum of the terms of a body's inertia without cancellation.

use crate::Model;
use crate::joint::PrimitiveJoint;
use crate::model::Body;

/// Mass, and first and second moments of a body's subtree. Distances ℓ are measured along the joints, so they
/// are at least the distance from the body's origin.
///
/// m = Σ mᵢ, H = Σ mᵢℓᵢ, J = Σ mᵢℓᵢ².
///
/// They give N of a DoF. The true moment about an axis can be far smaller, for example if an arm is folded
/// back onto the axis. The terms of its sum are as large as N, and so is their rounding.
#[derive(Clone, Copy, Debug)]
pub struct MassExtent {
    /// m \[kg\].
    pub mass: f64,
    /// H \[kg·m\].
    pub first: f64,
    /// J \[kg·m²\].
    pub second: f64,
    /// The least dₖ/Nₖ of the DoFs in this body's subtree.
    pub least: f64,
}

impl MassExtent {
    /// The extent of one body.
    fn of(body: &Body) -> Self {
        let norm = |entries: &[f64]| entries.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self {
            mass: body.mass.abs(),
            first: norm(&body.first_moment),
            second: norm(body.inertia.as_flattened()),
            least: 1.0,
        }
    }

    /// Adds a child's subtree, at this distance from the child's origin.
    #[inline(always)]
    pub(crate) fn add(&mut self, child: &Self, distance: f64) {
        self.mass += child.mass;
        self.first += distance * child.mass + child.first;
        self.second += distance * (distance * child.mass + 2.0 * child.first) + child.second;
        self.least = self.least.min(child.least);
    }

    /// N of DoF k, without armature: the size of sᵀI s.
    #[inline(always)]
    pub(crate) fn along(&self, motion: PrimitiveJoint, k: usize) -> f64 {
        let (slide, turn) = motion.reach(k);
        slide * (slide * self.mass + 2.0 * turn * self.first) + turn * turn * self.second
    }
}

/// The memory of the rank check.
#[derive(Clone, Debug)]
pub struct RankBuffers {
    /// Each body alone.
    pub own: Vec<MassExtent>,
    /// Each body with its subtree.
    pub extent: Vec<MassExtent>,
    /// |p|: the distance of each body's origin from its parent's.
    pub distance: Vec<f64>,
    /// √Nₖ of each DoF of the tree.
    pub root: Vec<f64>,
    /// Whether N is the same in all configurations: the origins of bodies on hinges keep their distances.
    pub(crate) keeps_extents: bool,
    /// Whether these N are known.
    pub(crate) has_extents: bool,
    /// 1/dₖ.
    pub inverse: Vec<f64>,
    /// |zᵢ| √Nᵢ by DoF or coordinate.
    pub share: Vec<f64>,
    /// √N and z by coordinate, for robots with coupled branches.
    pub(crate) reduced: Vec<f64>,
    pub motion: Vec<f64>,
    /// M of such robots, nv×nv, row-major.
    pub matrix: Vec<f64>,
}

impl RankBuffers {
    pub fn new(model: &Model) -> Self {
        let (bodies, dofs) = (model.bodies.len(), model.dofs.len());
        let own: Vec<MassExtent> = model.bodies.iter().map(MassExtent::of).collect();
        let reduced = if model.needs_dense_factor { model.nv } else { 0 };
        Self {
            extent: own.clone(),
            own,
            distance: vec![0.0; bodies],
            root: vec![0.0; dofs],
            keeps_extents: !model.needs_dense_factor
                && model.bodies.iter().all(|body| body.motion == PrimitiveJoint::Revolute),
            has_extents: false,
            inverse: vec![0.0; dofs],
            share: vec![0.0; dofs],
            reduced: vec![0.0; reduced],
            motion: vec![0.0; reduced],
            matrix: vec![0.0; reduced * reduced],
        }
    }
}

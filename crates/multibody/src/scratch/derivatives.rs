//! The derivatives' part of a workspace.

use dynamics::Scalar;

use crate::Model;
use crate::factor::tile::WIDTH;
use crate::factor::tree_factor::TreeFactor;
use crate::scratch::freedoms::Paths;
use crate::scratch::passes::{Pass, Solved, passes};
use crate::scratch::slope::Slope;
use crate::spatial::screw::Force;

/// Scratch for the derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<S: Scalar> {
    pub(crate) slope: Vec<Slope<S>>,
    pub(crate) paths: Paths<S>,
    pub(crate) mass: TreeFactor<S>,
    /// τ − the forces at a = 0, then a.
    pub(crate) vector: Vec<S>,
    /// ∂τ/∂q and ∂τ/∂v, by rows of whole eights. Entries between freedoms of which neither carries the
    /// other are zero from the start, and never written.
    pub(crate) by_position: Vec<[S; WIDTH]>,
    pub(crate) by_velocity: Vec<[S; WIDTH]>,
    pub(crate) passes: Vec<Pass>,
    /// What is solved for, by groups of columns, and the rows on the way to one of them.
    pub(crate) solved: Vec<Solved<S>>,
    pub(crate) carriers: Vec<Solved<S>>,
    /// A one among zeros: eight numbers out of these are a row of 1, or zero.
    pub(crate) unit: [S; 2 * WIDTH],
}

impl<S: Scalar> Scratch<S> {
    /// `carrier` is λ of each coordinate; where it is left empty there is no room for matrices.
    pub(crate) fn new(model: &Model, carrier: &[usize]) -> Self {
        let (dofs, nv) = (model.dofs.len(), carrier.len());
        let zero = S::zero();
        let force = Force::zero();
        let mass = TreeFactor::new(carrier);
        let rows = mass.deepest();
        let groups = nv.div_ceil(WIDTH);
        let slopes = vec![[zero; WIDTH]; groups * nv];
        let mut unit = [zero; 2 * WIDTH];
        unit[WIDTH] = S::one();
        Self {
            slope: vec![Slope { once: force, twice: force, swept: force }; dofs],
            paths: Paths::new(model),
            vector: vec![zero; nv],
            by_position: slopes.clone(),
            by_velocity: slopes,
            passes: passes::<S>(carrier, &mass.tiles),
            solved: vec![Solved::zero(); groups * nv],
            carriers: vec![Solved::zero(); groups * rows],
            unit,
            mass,
        }
    }
}

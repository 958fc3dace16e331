//! The derivatives' part of a workspace.

use dynamics::Scalar;

use super::columns::{Column, Slope};
use super::layout::WIDTH;
use super::path::{LANES, Paths, depths};
use super::solve_rows::{ColumnGroup, Solved, column_groups};
use super::tree_factor::TreeFactor;
use crate::Model;
use crate::workspace::Force;

/// Scratch for the derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<S: Scalar> {
    /// How many freedoms of the tree carry each.
    pub(super) depth: Vec<usize>,
    pub(super) slope: Vec<Slope<S>>,
    pub(super) columns: Vec<Column<S>>,
    pub(super) paths: Paths<S>,
    /// The freedoms on the way to one of them, where joints follow others.
    pub(super) way: Vec<usize>,
    /// Where four products with one freedom's numbers are made, twice: side by side in memory, they are side by side
    /// in a register before.
    pub(super) products: [[S; LANES]; 2],
    /// One freedom's row of M, where joints follow others.
    pub(super) reduced: Vec<[S; LANES]>,
    pub(super) mass: TreeFactor<S>,
    /// ∂τ/∂q and ∂τ/∂v by groups of columns, each by rows. Entries between freedoms of which neither carries the
    /// other are zero from the start, and never written.
    pub(super) by_position: Vec<[S; WIDTH]>,
    pub(super) by_velocity: Vec<[S; WIDTH]>,
    pub(super) groups: Vec<ColumnGroup>,
    /// A group of columns of what is solved for, and the rows on the way to one of them.
    pub(super) solved: Vec<[Solved<S>; 2]>,
    pub(super) carriers: Vec<[Solved<S>; 2]>,
}

impl<S: Scalar> Scratch<S> {
    /// `carrier` is λ of each coordinate.
    pub(crate) fn new(model: &Model, carrier: &[usize]) -> Self {
        let (dofs, nv) = (model.dofs.len(), model.nv);
        let depth = depths(model);
        let of_coordinates = if model.has_mimic { (0..nv).collect() } else { depth.clone() };
        let deepest = depth.iter().max().map_or(0, |deepest| deepest + 1);
        let blocks = deepest.div_ceil(LANES);
        let zero = S::zero();
        let (force, pair) = (Force::zero(), [Solved::zero(); 2]);
        let mass = TreeFactor::new(of_coordinates, carrier.to_vec());
        let rows = mass.deepest();
        let slopes = vec![[zero; WIDTH]; nv * nv.div_ceil(WIDTH)];
        Self {
            slope: vec![Slope { once: force, twice: force, swept: force }; dofs],
            columns: vec![Column::zero(); dofs],
            paths: Paths::new(model, &depth),
            way: vec![0; deepest],
            products: [[zero; LANES]; 2],
            reduced: vec![[zero; LANES]; blocks],
            by_position: slopes.clone(),
            by_velocity: slopes,
            groups: column_groups::<S>(model, carrier),
            solved: vec![pair; nv],
            carriers: vec![pair; rows],
            depth,
            mass,
        }
    }
}

//! The freedoms from the root to each one, four side by side.
//!
//! A freedom stands at its depth, the number of freedoms that carry it. Where ways part within a block of four
//! depths, each has a block of its own, and the freedoms before the parting stand in all of them.

use dynamics::Scalar;

use super::columns::Slope;
use super::layout::{Address, Layout};
use crate::Model;
use crate::algebra::V3;
use crate::workspace::Screw;

/// Freedoms side by side.
pub(crate) const LANES: usize = 4;

/// First row of ψ′, which the angular part of ψ follows.
pub(super) const TWICE: usize = 0;
/// First row of Ṡ + ψ, which the angular part of S follows.
pub(super) const SWEPT: usize = 9;
/// First row of S, its angular part before the linear one.
pub(super) const TURN: usize = 15;
const ROWS: usize = 21;

/// What four freedoms impose on those they carry. No load of a row crosses a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct PathBlock<S> {
    rows: [[S; LANES]; ROWS],
    /// The four depths, counted from the root's.
    pub(super) level: usize,
    /// The block of the four depths before.
    pub(super) before: usize,
    /// Where the freedoms' entries stand; of lanes that no freedom takes, those of the last freedom.
    dense: [Address; LANES],
    grouped: [Address; LANES],
}

/// A place of a freedom in a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seat {
    pub dof: usize,
    pub block: usize,
    pub lane: usize,
}

/// All ways from the root.
#[derive(Clone, Debug)]
pub(crate) struct Paths<S> {
    pub(super) blocks: Vec<PathBlock<S>>,
    seats: Vec<Seat>,
    /// The last block of the way to each body's last freedom.
    pub(super) last: Vec<usize>,
}

impl<S: Scalar> Paths<S> {
    /// The ways of a model; `depth` is of [`depths`].
    pub(super) fn new(model: &Model, depth: &[usize]) -> Self {
        let mut taken: Vec<Vec<usize>> = Vec::new();
        let mut blocks: Vec<PathBlock<S>> = Vec::new();
        let mut last: Vec<usize> = Vec::with_capacity(model.bodies.len());
        for body in &model.bodies {
            let mut before = last.get(body.parent).copied();
            for dof in body.dof..body.dof + body.motion.nv() {
                let lane = depth[dof] % LANES;
                let fresh = |before| PathBlock {
                    rows: [[S::zero(); LANES]; ROWS],
                    level: depth[dof] / LANES,
                    before,
                    dense: [Address::default(); LANES],
                    grouped: [Address::default(); LANES],
                };
                let at = match before {
                    Some(block) if lane > 0 && taken[block].len() == lane => block,
                    Some(block) if lane > 0 => {
                        let shared = taken[block][..lane].to_vec();
                        taken.push(shared);
                        blocks.push(fresh(blocks[block].before));
                        blocks.len() - 1
                    }
                    before => {
                        taken.push(Vec::new());
                        blocks.push(fresh(before.unwrap_or(usize::MAX)));
                        blocks.len() - 1
                    }
                };
                taken[at].push(dof);
                before = Some(at);
            }
            last.push(before.unwrap_or(usize::MAX));
        }
        for (block, dofs) in blocks.iter_mut().zip(&taken) {
            for lane in 0..LANES {
                let dof = model.dofs[dofs[lane.min(dofs.len() - 1)]].coordinate;
                block.dense[lane] = Layout::dense(model.nv).address(dof);
                block.grouped[lane] = Layout::groups(model.nv).address(dof);
            }
        }
        let seats = taken.iter().enumerate();
        let seats = seats.flat_map(|(block, dofs)| {
            dofs.iter().enumerate().map(move |(lane, &dof)| Seat { dof, block, lane })
        });
        Self { seats: seats.collect(), blocks, last }
    }

    /// Writes S of all freedoms.
    #[inline(always)]
    pub(super) fn write_screws(&mut self, screws: &[Screw<S>]) {
        for &Seat { dof, block, lane } in &self.seats {
            self.blocks[block].write_screw(lane, &screws[dof]);
        }
    }

    /// Writes ψ, ψ′ and Ṡ + ψ of all freedoms.
    #[inline(always)]
    pub(super) fn write_slopes(&mut self, slopes: &[Slope<S>]) {
        for &Seat { dof, block, lane } in &self.seats {
            self.blocks[block].write_slope(lane, &slopes[dof]);
        }
    }
}

impl<S: Scalar> PathBlock<S> {
    #[inline(always)]
    fn write_screw(&mut self, lane: usize, s: &Screw<S>) {
        self.write::<TURN>(lane, s.angular);
        self.write::<{ TURN + 3 }>(lane, s.linear);
    }

    #[inline(always)]
    fn write_slope(&mut self, lane: usize, slope: &Slope<S>) {
        self.write::<TWICE>(lane, slope.twice.linear);
        self.write::<{ TWICE + 3 }>(lane, slope.twice.angular);
        self.write::<{ TWICE + 6 }>(lane, slope.once.angular);
        self.write::<SWEPT>(lane, slope.swept.linear);
        self.write::<{ SWEPT + 3 }>(lane, slope.swept.angular);
    }

    #[inline(always)]
    fn write<const FIRST: usize>(&mut self, lane: usize, vector: V3<S>) {
        let [x, y, z] = vector.array();
        let lane = lane % LANES;
        self.rows[FIRST][lane] = x;
        self.rows[FIRST + 1][lane] = y;
        self.rows[FIRST + 2][lane] = z;
    }

    /// Where the freedoms' entries stand.
    #[inline(always)]
    pub(super) fn addresses(&self, layout: Layout) -> &[Address; LANES] {
        if layout.grouped { &self.grouped } else { &self.dense }
    }

    /// Σₖ weightₖ row_{first+k}.
    #[inline(always)]
    pub(super) fn project<const FIRST: usize, const K: usize>(&self, weights: &[S; K]) -> [S; LANES] {
        let mut sum = self.rows[FIRST];
        for l in 0..LANES {
            sum[l] *= weights[0];
        }
        for k in 1..K {
            let row = &self.rows[FIRST + k];
            for l in 0..LANES {
                sum[l] = weights[k].mul_add(row[l], sum[l]);
            }
        }
        sum
    }
}

/// How many freedoms carry each freedom of the tree.
pub(super) fn depths(model: &Model) -> Vec<usize> {
    let mut depths = Vec::with_capacity(model.dofs.len());
    for body in &model.bodies {
        let carried = model.bodies.get(body.parent);
        let first = carried.map_or(0, |parent: &crate::model::Body| {
            let last: usize = parent.dof + parent.motion.nv() - 1;
            depths[last] + 1
        });
        depths.extend(first..first + body.motion.nv());
    }
    depths
}

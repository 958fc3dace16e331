//! The convex problem of a step: which velocity change do bounds, cones and inertia agree on?
//!
//! min over x of ½xᵀMx + fᵀx + Σ ψ(c),  c = c₀ + A x, with multipliers p = −∇ψ(c) in a convex set K, block by block: p = Π_K(p̄ − c/R), ψ(c) = ½R|p|². With
//! p̄ = 0 this is a contact, bound or row that yields by R for each unit of impulse **(Todorov 2014)**; with p̄ ← p until p̄ = p, the method of multipliers,
//! nothing of R is left: c lies in K's polar cone and is orthogonal to p. **(Rockafellar 1976)** M is positive definite, so x is unique.
//!
//! Newton's method with H = M + AᵀR⁻¹ΠʹA, whose entries are where M's are, if each block moves with freedoms that carry one another:
//! then H is factored as M is, with the tree's zeros. The line search finds the root of a growing function.
//!
//! **Coulomb's law.** A cone's rows are (normal, tangential…). The polar of the cone |p_t| ≤ μp_n demands c_n ≥ μ|c_t|: what slides would
//! rise. With c_n + s in place of c_n and s = μ|c_t| of the solution, c_n ⟂ p_n as it should be. **(De Saxcé & Feng 1998)** s is
//! found by Newton's method on the solution's own derivative by s.

mod descent;
mod dissection;
mod entries;
mod islands;
mod many_shifts;
mod one_block;
mod projection;
mod response;
mod rows;
mod shifts;
mod solution;
mod square;
mod sweeps;

use core::ops::Range;

use self::islands::Islands;
use self::projection::Slopes;
use self::rows::Rows;
use self::shifts::Search;
use self::sweeps::Sweeps;
use super::interrupt::Interrupt;
use crate::factor::paths::{Paths, usual_entries};
use crate::factor::sparse;

/// Where a block's multipliers lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Set {
    /// One row, its multiplier between these.
    Interval(f64, f64),
    /// { |p_t| ≤ slope·p_n }.
    Cone(f64),
}

#[derive(Clone, Debug)]
struct Block {
    set: Set,
    rows: Range<usize>,
    /// Its coordinates, in `support`.
    support: Range<usize>,
    /// Its first entry of A.
    entries: usize,
    /// R: speed by which it yields per impulse.
    softness: f64,
    /// s.
    shift: f64,
    /// Whether it calls for a solution of the part that it is in.
    is_due: bool,
}

crate::clone_in_place::clone_in_place! {
    /// The problem, and the memory of its solution.
    #[derive(Debug)]
    pub(crate) struct ConeProblem {
        /// How many coordinates.
        n: usize,
        blocks: Vec<Block>,
        /// The indices of the blocks that are cones.
        cones: Vec<usize>,
        support: Vec<usize>,
        entries: Vec<f64>,
        /// The same for the loops, once all blocks are there.
        rows: Rows,
        is_arranged: bool,
        /// c₀ for each row.
        pub(crate) start: Vec<f64>,
        /// p̄, then p.
        pub(crate) multiplier: Vec<f64>,
        /// Multipliers that act already: x is what the others make of them.
        pub(super) counted: Vec<f64>,
        /// p without those.
        missing: Vec<f64>,
        /// 1/R of each row, and what an impulse on the block moves it by.
        inverses: Vec<f64>,
        moved: Vec<f64>,
        /// The bounds of each row's multiplier, a cone's rows without any.
        lower: Vec<f64>,
        upper: Vec<f64>,
        /// 1/R of each row whose multiplier is between them, 0 of one on a bound; memory for others.
        weights: Vec<f64>,
        next: Vec<f64>,
        /// The energy that there is to be moved.
        start_energy: f64,
        /// p and c of the present x.
        p: Vec<f64>,
        pub(crate) c: Vec<f64>,
        /// A δ.
        change: Vec<f64>,
        /// f.
        pub(crate) force: Vec<f64>,
        /// x.
        pub(crate) x: Vec<f64>,
        step: Vec<f64>,
        /// M x + f.
        drag: Vec<f64>,
        slope: Vec<f64>,
        /// M and H, packed.
        mass: Vec<f64>,
        hessian: Vec<f64>,
        weighted: Vec<f64>,
        paths: Paths,
        /// ∂p/∂p̄ of each cone.
        slopes: Vec<Slopes>,
        known: Known,
        search: Search,
        islands: Islands,
        sweeps: Sweeps,
        /// Ends a solution without a result.
        pub(super) interrupt: Interrupt,
        /// Newton steps of the last solution.
        pub(crate) rounds: usize,
        /// Whether the last solution has Coulomb's law, or that of the cones alone.
        pub(crate) is_coulomb: bool,
    }
}

/// What is there for the present x.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// Whether `hessian` is a factor, and whether with slopes that are nearly these.
    is_factored: bool,
    is_fresh: bool,
    /// Whether `c` and `drag` are those of x.
    is_followed: bool,
}

impl ConeProblem {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        let rows = || Vec::with_capacity(6 * n + 96);
        Self {
            n,
            blocks: Vec::with_capacity(2 * n + 32),
            cones: Vec::with_capacity(32),
            support: Vec::with_capacity(32 * n),
            entries: Vec::with_capacity(96 * n),
            rows: Rows::new(n, 2 * n + 32, 128 * n),
            is_arranged: false,
            start: rows(),
            multiplier: rows(),
            counted: rows(),
            missing: rows(),
            inverses: rows(),
            moved: rows(),
            lower: rows(),
            upper: rows(),
            weights: rows(),
            next: rows(),
            start_energy: 0.0,
            p: rows(),
            c: rows(),
            change: rows(),
            force: zeros(),
            x: zeros(),
            step: zeros(),
            drag: zeros(),
            slope: zeros(),
            mass: Vec::with_capacity(usual_entries(n)),
            hessian: Vec::with_capacity(usual_entries(n)),
            weighted: Vec::with_capacity(6 * (n + 4)),
            paths: Paths::new(n),
            slopes: Vec::with_capacity(2 * n + 32),
            known: Known::default(),
            search: Search::new(n),
            islands: Islands::default(),
            sweeps: Sweeps::default(),
            interrupt: Interrupt::default(),
            rounds: 0,
            is_coulomb: true,
        }
    }

    /// With room for the solution part by part.
    pub(super) fn with_islands(mut self) -> Self {
        self.islands = Islands::new(self.n);
        self
    }

    /// Takes M, all of it, with λ of its zeros.
    pub(crate) fn take(&mut self, matrix: &[f64], carrier: &[usize]) {
        self.paths.choose(carrier);
        self.paths.pack(matrix, &mut self.mass);
    }

    /// The same of a packed M, where λ may leave fewer zeros.
    pub(super) fn take_packed(&mut self, (paths, matrix): (&Paths, &[f64]), carrier: &[usize]) {
        self.paths.choose(carrier);
        if self.paths.is_like(paths) {
            self.mass.clear();
            self.mass.extend_from_slice(matrix);
        } else {
            self.paths.repack(paths, matrix, &mut self.mass);
        }
    }

    /// Joins in λ what each of the blocks from this row on moves with.
    pub(super) fn couple_from(&self, row: usize, carrier: &mut [usize]) {
        for block in self.blocks.iter().filter(|block| block.rows.start >= row) {
            for pair in self.support[block.support.clone()].windows(2) {
                sparse::couple(carrier, [pair[0], pair[1]]);
            }
        }
    }

    /// M's factor.
    pub(super) fn factor_of_mass(&self) -> Vec<f64> {
        let mut factor = self.mass.clone();
        self.paths.factor(&mut factor);
        factor
    }

    /// x ← M⁻¹x by that factor.
    pub(super) fn solve_by(&self, factor: &[f64], x: &mut [f64]) {
        self.paths.solve(factor, x);
    }

    /// Without blocks, f = 0.
    pub(crate) fn clear(&mut self) {
        self.is_arranged = false;
        self.blocks.clear();
        self.support.clear();
        for vector in [&mut self.entries, &mut self.start, &mut self.multiplier, &mut self.counted] {
            vector.clear();
        }
        self.force.fill(0.0);
    }

    /// A block of so many rows over these coordinates; c₀ = p̄ = s = 0 and all entries 0. Its first row's index.
    pub(crate) fn push(&mut self, set: Set, rows: usize, support: impl Iterator<Item = usize>) -> usize {
        self.is_arranged = false;
        let (first, begin, entries) = (self.start.len(), self.support.len(), self.entries.len());
        self.support.extend(support);
        let count = self.support.len() - begin;
        for vector in [&mut self.start, &mut self.multiplier] {
            vector.resize(first + rows, 0.0);
        }
        self.entries.resize(entries + rows * count, 0.0);
        self.blocks.push(Block {
            set,
            rows: first..first + rows,
            support: begin..begin + count,
            entries,
            softness: 0.0,
            shift: 0.0,
            is_due: true,
        });
        first
    }

    /// A row along these coordinates, each with its factor, that many times. Its index.
    pub(super) fn push_row(&mut self, set: Set, times: f64, terms: &[(usize, f64)]) -> usize {
        self.is_arranged = false;
        let (row, begin, entries) = (self.start.len(), self.support.len(), self.entries.len());
        for &(k, factor) in terms {
            self.support.push(k);
            self.entries.push(times * factor);
        }
        self.start.push(0.0);
        self.multiplier.push(0.0);
        let support = begin..self.support.len();
        let rows = row..row + 1;
        self.blocks.push(Block { set, rows, support, entries, softness: 0.0, shift: 0.0, is_due: true });
        row
    }

    /// The last block's coordinates and its entries, row by row.
    pub(crate) fn last(&mut self) -> (&[usize], &mut [f64]) {
        self.is_arranged = false;
        match self.blocks.last() {
            Some(block) => (&self.support[block.support.clone()], &mut self.entries[block.entries..]),
            None => (&[], &mut []),
        }
    }

    /// R of the last block, for [`solve_soft`](Self::solve_soft).
    pub(crate) fn soften(&mut self, softness: f64) {
        if let Some(block) = self.blocks.last_mut() {
            block.softness = softness;
        }
    }

    /// R of all blocks.
    pub(crate) fn soften_all(&mut self, softness: f64) {
        self.blocks.iter_mut().for_each(|block| block.softness = softness);
    }

    /// Whether the last block calls for a solution of the part that it is in; parts without such a block have the solution x = 0.
    pub(super) fn set_due(&mut self, is_due: bool) {
        if let Some(block) = self.blocks.last_mut() {
            block.is_due = is_due;
        }
    }

    /// The s that the last block begins with.
    pub(crate) fn begin_with_shift(&mut self, shift: f64) {
        if let Some(block) = self.blocks.last_mut() {
            block.shift = shift;
        }
    }

    /// The first row of a cone: s.
    pub(crate) fn shift_of(&self, row: usize) -> f64 {
        let block = self.blocks.binary_search_by_key(&row, |block| block.rows.start);
        block.map_or(0.0, |at| self.blocks[at].shift)
    }

    /// Each block's set, and how many rows it has.
    pub(super) fn sets(&self) -> impl Iterator<Item = (Set, usize)> + '_ {
        self.blocks.iter().map(|block| (block.set, block.rows.len()))
    }

    /// Adds Aᵀp to `to`, of the rows' multipliers.
    pub(crate) fn add_forces(&self, p: &[f64], to: &mut [f64]) {
        for block in &self.blocks {
            let support = &self.support[block.support.clone()];
            let rows = self.entries[block.entries..].chunks_exact(support.len().max(1));
            for (row, p) in rows.zip(&p[block.rows.clone()]) {
                for (&k, a) in support.iter().zip(row) {
                    to[k] += a * p;
                }
            }
        }
    }

    /// A x to `to`.
    pub(crate) fn multiply(&self, x: &[f64], to: &mut Vec<f64>) {
        to.clear();
        for block in &self.blocks {
            let support = &self.support[block.support.clone()];
            let rows = self.entries[block.entries..].chunks_exact(support.len().max(1));
            to.extend(
                rows.take(block.rows.len())
                    .map(|row| support.iter().zip(row).map(|(&k, a)| a * x[k]).sum::<f64>()),
            );
        }
    }

    /// Arranges the blocks' rows, of which all are there.
    pub(super) fn arrange(&mut self) {
        if !self.is_arranged {
            self.rows.arrange(&self.blocks, &self.support, &self.entries);
            self.is_arranged = true;
        }
    }

    /// p̄ acts already, and x is what is missing: in the place of f is f + Aᵀp̄.
    pub(super) fn count_multipliers(&mut self) {
        self.counted.clone_from(&self.multiplier);
    }

    /// Adds Aᵀp of the solution to `to`.
    pub(super) fn add_found_forces(&mut self, to: &mut [f64]) {
        self.arrange();
        self.rows.add_forces(&self.support, &self.multiplier, to);
    }

    /// Aᵀ(p − p̄) − f of the solution to `to`: what x was to be M⁻¹ of.
    pub(super) fn find_impulses(&mut self, to: &mut [f64]) {
        self.arrange();
        self.missing.clear();
        self.missing.extend(self.multiplier.iter().zip(&self.counted).map(|(p, counted)| p - counted));
        to.iter_mut().zip(&self.force).for_each(|(to, force)| *to = -force);
        self.rows.add_forces(&self.support, &self.missing, to);
    }

    /// [`multiply`](Self::multiply), fast.
    pub(super) fn find_products(&mut self, x: &[f64], to: &mut Vec<f64>) {
        self.arrange();
        to.resize(self.start.len(), 0.0);
        self.rows.multiply(&self.support, x, to);
    }

    /// Adds A v to c₀.
    pub(crate) fn add_speeds(&mut self, v: &[f64]) {
        let mut speeds = core::mem::take(&mut self.change);
        self.find_products(v, &mut speeds);
        self.start.iter_mut().zip(&speeds).for_each(|(start, speed)| *start += speed);
        self.change = speeds;
    }
}

/// Normal, two tangential, torsional and two rolling directions.
pub(crate) const MOST_ROWS: usize = 6;

//! The contact problem of a step: the velocity change x that inertia, bounds and friction cones agree on.
//!
//! # The convex problem
//!
//! With the mass matrix M, the impulses −f, the rows' Jacobian A and their velocities c₀ at x = 0:
//!
//! ```text
//! min over x of  ½xᵀM x + fᵀx + Σ ψ(c),   c = c₀ + A x,
//! ψ(c) = ½R|p|²,   p = −∇ψ(c) = Π_K(p̄ − c/R)
//! ```
//!
//! The multipliers p of each block of rows are in a convex set. This set K is an interval for a bound, a
//! joint's friction or an equality. It is the cone |p_t| ≤ μp_n for a contact with friction. Π_K is the
//! projection onto K. R \[velocity per impulse\] is the penalty's softness, and p̄ an estimate of the
//! multipliers. M is positive definite, so x is unique.
//!
//! - With p̄ = 0, a block is soft: it yields by R for each unit of impulse **(Todorov 2014)**. `solve_soft`
//!   solves this problem.
//! - With p̄ ← p repeated until p̄ = p, the result is independent of R. This is the method of multipliers
//!   **(Rockafellar 1976)**. Then −c is in the normal cone of K at p: the block is rigid. For a friction
//!   cone, c is in the dual cone and orthogonal to p. [`ConeProblem::solve_rigid`] solves this problem.
//!
//! # Coulomb's law
//!
//! The rows of a cone are (normal, tangential…). The dual of the cone |p_t| ≤ μp_n demands c_n ≥ μ|c_t|, so
//! in the convex problem a sliding contact would separate. The solver replaces c_n by c_n + s with the shift
//! s = μ|c_t| of the solution. Then c_n ≥ 0 and c_n p_n = 0 hold, as Signorini's law demands **(De Saxcé &
//! Feng 1998)**. s is found by Newton's method with the derivative of the solution by s.
//!
//! # Steps of the solver
//!
//! - `islands` splits the problem into independent parts, and orders the trees of each by nested dissection
//!   (`dissection`).
//! - `sweeps` finds p̄ and s near the solution by Gauss-Seidel sweeps, in parts with many cones.
//! - `solution` runs the outer iterations: minimize over x, update p̄ and s, and test convergence.
//! - `newton` minimizes over x, with H = M + AᵀR⁻¹Π′A. H has the zeros of M if each block acts on coordinates
//!   of one path to the root. Then it is factored as M is.
//! - `descent` searches along a Newton step for the root of the derivative, which increases monotonically.
//! - `shifts` updates s by Newton's method. `many_shifts` does it with one factorization for many sliding
//!   contacts.
//!
//! `tolerances` holds all tolerances, with their reasons.
//!
//! # Limits
//!
//! - Rigid contact with Coulomb's law may have no solution **(Painlevé 1895)**, or several. If the search for
//!   s fails, the result is that for s = 0, and [`ConeProblem::is_coulomb`] is false. With s = 0, sliding
//!   contacts separate at μ|c_t|.
//! - Redundant rows determine only the sum of their multipliers. The solution has one of the possible
//!   distributions.
//! - The condition number of H is about 1/R times that of M.

mod block;
mod descent;
mod dissection;
mod entries;
mod hessian;
mod island_solution;
mod islands;
mod many_shifts;
mod newton;
mod one_block;
mod products;
mod projection;
mod response;
mod rows;
mod set;
mod shift_search;
mod shifts;
mod solution;
mod sweep_memory;
mod sweeps;
mod tolerances;

use core::ops::Range;

use robot_dynamics_core::factorization::paths::{Paths, usual_entries};
use robot_dynamics_core::factorization::sparse;

use self::block::Block;
use self::islands::Islands;
use self::projection::ProjectionDerivative;
use self::rows::RowGroups;
use self::shift_search::ShiftSearch;
use self::sweep_memory::Sweeps;
use super::interrupt::Interrupt;

pub use self::set::{MOST_ROWS, Set};

robot_dynamics_core::clone_in_place::clone_in_place! {
    /// The convex problem of a step, and the memory for its solution.
    #[derive(Debug)]
    pub struct ConeProblem {
        /// The number of coordinates.
        n: usize,
        blocks: Vec<Block>,
        /// The indices of the blocks that are cones.
        cones: Vec<usize>,
        support: Vec<usize>,
        entries: Vec<f64>,
        /// A in the layout of the solver's loops, once all blocks are there.
        rows: RowGroups,
        is_arranged: bool,
        /// c₀ of each row.
        pub start: Vec<f64>,
        /// p̄ before the solution, p after it.
        pub(crate) multiplier: Vec<f64>,
        /// The multipliers whose impulses the velocities already contain: x is caused by the others.
        pub(super) counted: Vec<f64>,
        /// p minus `counted`.
        missing: Vec<f64>,
        /// 1/R of each row, and the velocity that a unit impulse on its block causes.
        inverses: Vec<f64>,
        moved: Vec<f64>,
        /// The bounds of each row's multiplier; infinite for the rows of cones.
        lower: Vec<f64>,
        upper: Vec<f64>,
        /// 1/R of each row whose multiplier is between its bounds, 0 for one on a bound; then a buffer for
        /// the next weights.
        weights: Vec<f64>,
        next: Vec<f64>,
        /// The energy of the rows' initial velocities.
        start_energy: f64,
        /// p and c at the present x.
        p: Vec<f64>,
        pub c: Vec<f64>,
        /// A δ.
        change: Vec<f64>,
        /// f.
        pub force: Vec<f64>,
        /// x.
        pub x: Vec<f64>,
        step: Vec<f64>,
        /// M x + f.
        residual: Vec<f64>,
        slope: Vec<f64>,
        /// M and H, packed.
        mass: Vec<f64>,
        hessian: Vec<f64>,
        weighted: Vec<f64>,
        paths: Paths,
        /// ∂p/∂p̄ of each cone, times R.
        derivatives: Vec<ProjectionDerivative>,
        known: ValidQuantities,
        search: ShiftSearch,
        islands: Islands,
        /// The problem of one part.
        part: Option<Box<ConeProblem>>,
        sweeps: Sweeps,
        /// Ends a solution early, without a result.
        pub(super) interrupt: Interrupt,
        /// The number of Newton steps in the last solution.
        pub rounds: usize,
        /// Whether the last solution satisfies Coulomb's law, or only the convex problem with s = 0.
        pub is_coulomb: bool,
    }
}

/// The quantities that are valid for the present x.
#[derive(Clone, Copy, Debug, Default)]
struct ValidQuantities {
    /// Whether `hessian` holds a factor, and whether its derivatives are nearly those at x.
    is_factored: bool,
    is_fresh: bool,
    /// Whether `c` and `residual` are those of x.
    is_followed: bool,
}

impl ConeProblem {
    pub fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        let rows = || Vec::with_capacity(6 * n + 96);
        Self {
            n,
            blocks: Vec::with_capacity(2 * n + 32),
            cones: Vec::with_capacity(32),
            support: Vec::with_capacity(32 * n),
            entries: Vec::with_capacity(96 * n),
            rows: RowGroups::new(n, 2 * n + 32, 128 * n),
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
            residual: zeros(),
            slope: zeros(),
            mass: Vec::with_capacity(usual_entries(n)),
            hessian: Vec::with_capacity(usual_entries(n)),
            weighted: Vec::with_capacity(6 * (n + 4)),
            paths: Paths::new(n),
            derivatives: Vec::with_capacity(2 * n + 32),
            known: ValidQuantities::default(),
            search: ShiftSearch::new(n),
            islands: Islands::default(),
            part: None,
            sweeps: Sweeps::default(),
            interrupt: Interrupt::default(),
            rounds: 0,
            is_coulomb: true,
        }
    }

    /// Sets M, given as a full square matrix; `dof_parent` (λ) describes its zeros.
    pub fn set_matrix(&mut self, matrix: &[f64], dof_parent: &[usize]) {
        self.paths.choose(dof_parent);
        self.paths.pack(matrix, &mut self.mass);
    }

    /// Sets a packed M. Its λ may describe more zeros than `dof_parent` does.
    pub(super) fn set_packed_matrix(&mut self, (paths, matrix): (&Paths, &[f64]), dof_parent: &[usize]) {
        self.paths.choose(dof_parent);
        if self.paths.is_like(paths) {
            self.mass.clear();
            self.mass.extend_from_slice(matrix);
        } else {
            self.paths.repack(paths, matrix, &mut self.mass);
        }
    }

    /// Extends λ by the coupling of the blocks from this row on.
    pub(super) fn couple_from(&self, row: usize, dof_parent: &mut [usize]) {
        for block in self.blocks.iter().filter(|block| block.rows.start >= row) {
            for pair in self.support[block.support.clone()].windows(2) {
                sparse::couple(dof_parent, [pair[0], pair[1]]);
            }
        }
    }

    /// Returns the factor of M.
    pub(super) fn factor_of_mass(&self) -> Vec<f64> {
        let mut factor = self.mass.clone();
        self.paths.factor(&mut factor);
        factor
    }

    /// x ← M⁻¹x by the factor of M.
    pub(super) fn solve_by(&self, factor: &[f64], x: &mut [f64]) {
        self.paths.solve(factor, x);
    }

    /// Removes all blocks and sets f = 0.
    pub fn clear(&mut self) {
        self.is_arranged = false;
        self.blocks.clear();
        self.support.clear();
        for vector in [&mut self.entries, &mut self.start, &mut self.multiplier, &mut self.counted] {
            vector.clear();
        }
        self.force.fill(0.0);
    }

    /// Adds a block of `rows` rows over these coordinates, with c₀ = p̄ = s = 0 and entries 0. Returns the
    /// index of its first row.
    pub fn push(&mut self, set: Set, rows: usize, support: impl Iterator<Item = usize>) -> usize {
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

    /// Adds a row with these coordinates and factors, multiplied by `times`. Returns its index.
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

    /// The coordinates of the last block, and its entries row by row.
    pub fn last(&mut self) -> (&[usize], &mut [f64]) {
        self.is_arranged = false;
        match self.blocks.last() {
            Some(block) => (&self.support[block.support.clone()], &mut self.entries[block.entries..]),
            None => (&[], &mut []),
        }
    }

    /// Sets R of the last block, for [`solve_soft`](Self::solve_soft).
    pub(crate) fn soften(&mut self, softness: f64) {
        if let Some(block) = self.blocks.last_mut() {
            block.softness = softness;
        }
    }

    /// Sets R of all blocks.
    pub(crate) fn soften_all(&mut self, softness: f64) {
        self.blocks.iter_mut().for_each(|block| block.softness = softness);
    }

    /// Sets whether the last block requires a solution of its part. A part without such a block has the
    /// solution x = 0.
    pub(super) fn set_due(&mut self, is_due: bool) {
        if let Some(block) = self.blocks.last_mut() {
            block.is_due = is_due;
        }
    }

    /// Sets the initial s of the last block.
    pub(crate) fn begin_with_shift(&mut self, shift: f64) {
        if let Some(block) = self.blocks.last_mut() {
            block.shift = shift;
        }
    }

    /// The shift s of the cone whose first row this is.
    pub(crate) fn shift_of(&self, row: usize) -> f64 {
        let block = self.blocks.binary_search_by_key(&row, |block| block.rows.start);
        block.map_or(0.0, |at| self.blocks[at].shift)
    }

    /// The multiplier of a row beyond that whose impulse the velocities already contain.
    pub(super) fn missing_multiplier(&self, row: usize) -> f64 {
        self.multiplier[row] - self.counted.get(row).copied().unwrap_or(0.0)
    }

    /// Calls `visit` with each block: its set, its rows, its coordinates, and its entries row by row.
    pub(crate) fn each_block(&self, mut visit: impl FnMut(Set, Range<usize>, &[usize], &[f64])) {
        for block in &self.blocks {
            let support = &self.support[block.support.clone()];
            let count = support.len() * block.rows.len();
            visit(block.set, block.rows.clone(), support, &self.entries[block.entries..][..count]);
        }
    }

    /// The set of each block, and its number of rows.
    pub(super) fn sets(&self) -> impl Iterator<Item = (Set, usize)> + '_ {
        self.blocks.iter().map(|block| (block.set, block.rows.len()))
    }
}

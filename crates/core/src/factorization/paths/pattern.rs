//! The zero pattern of packed rows: their positions, and the branches that form chains.

use core::ops::Range;

use super::four::WIDTH;
use crate::clone_in_place::clone_in_place;
use crate::factorization::sparse::NONE;

/// The number of rows above which a matrix is assumed to be mostly zeros.
const LARGE: usize = 512;

/// Paths of at most this many DoFs are gathered. Longer ones, which few robots have, are followed entry by
/// entry.
pub(super) const LONGEST: usize = 64;

clone_in_place! {
    /// The zero pattern of a matrix: the ancestors of each DoF.
    #[derive(Debug)]
    pub struct Paths {
        pub(super) dof_parent: Vec<usize>,
        /// The column of each entry, with 0 for padding; and the start of each row, in units of four entries.
        pub(super) columns: Vec<usize>,
        pub(super) starts: Vec<usize>,
        pub(super) rows: Vec<RowSpan>,
        pub(super) branches: Vec<Branch>,
        pub(super) runs: Vec<Run>,
        /// Whether some path is too long to gather.
        pub(super) is_long: bool,
    }
}

/// A chain of DoFs, each the parent of the next.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    pub(super) first: usize,
    pub(super) end: usize,
    /// The number of ancestors of the first DoF.
    pub(super) depth: usize,
    /// Its runs.
    pub(super) runs: Range<usize>,
}

/// The position of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowSpan {
    /// Its first entry.
    pub(super) begin: usize,
    /// Its diagonal.
    pub(super) diagonal: usize,
}

impl RowSpan {
    /// The start of the next row.
    #[inline(always)]
    pub(super) fn end(self) -> usize {
        self.diagonal - self.diagonal % WIDTH + WIDTH
    }

    /// The number of entries left of its diagonal.
    #[inline(always)]
    pub(super) fn depth(self) -> usize {
        self.diagonal - self.begin
    }
}

/// The rows of a branch whose diagonals lie in the same four.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) rows: Range<usize>,
    /// The number of fours left of the one with the diagonals, and the position in it of the first diagonal.
    pub(super) fours: usize,
    pub(super) first: usize,
    /// The first row's first four.
    pub(super) begin: usize,
}

impl Paths {
    /// With memory for n DoFs.
    pub fn new(n: usize) -> Self {
        let (dof_parent, rows) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let most = usual_entries(n);
        let (columns, starts) = (Vec::with_capacity(most), Vec::with_capacity(most));
        let (branches, runs) = (Vec::with_capacity(n), Vec::with_capacity(n));
        Self { dof_parent, columns, starts, rows, branches, runs, is_long: false }
    }

    /// Sets λ; does nothing if it is equal to the last one.
    pub fn choose(&mut self, dof_parent: &[usize]) {
        if self.dof_parent == dof_parent {
            return;
        }
        self.dof_parent.clear();
        self.dof_parent.extend_from_slice(dof_parent);
        self.columns.clear();
        self.rows.clear();
        self.branches.clear();
        self.runs.clear();
        self.is_long = false;
        let mut first = 0;
        for (k, &dof_parent) in dof_parent.iter().enumerate() {
            let begin = self.columns.len();
            if dof_parent != NONE {
                let RowSpan { begin, diagonal } = self.rows[dof_parent];
                self.columns.extend_from_within(begin..=diagonal);
            }
            let row = RowSpan { begin, diagonal: self.columns.len() };
            self.columns.push(k);
            self.columns.resize(row.end(), 0);
            self.rows.push(row);
            self.is_long |= row.end() - row.begin > LONGEST;
            if k > 0 && (dof_parent == NONE || dof_parent + 1 != k) {
                self.add_branch(first, k);
                first = k;
            }
        }
        if first < dof_parent.len() {
            self.add_branch(first, dof_parent.len());
        }
        self.starts.clear();
        self.starts.extend(self.columns.iter().map(|&column| self.rows[column].begin / WIDTH));
    }

    /// The DoFs from the root to a branch, in ascending order.
    #[inline(always)]
    pub(super) fn path_to(&self, branch: &Branch) -> &[usize] {
        &self.columns[self.rows[branch.first].begin..][..branch.depth]
    }

    /// Adds the branch of rows from `first` to `end`, with its runs.
    pub(super) fn add_branch(&mut self, first: usize, end: usize) {
        let (depth, begin) = (self.rows[first].depth(), self.runs.len());
        let mut next = first;
        while next < end {
            let at = depth + (next - first);
            let last = (next + WIDTH - at % WIDTH).min(end);
            let begin = self.rows[next].begin / WIDTH;
            self.runs.push(Run { rows: next..last, fours: at / WIDTH, first: at % WIDTH, begin });
            next = last;
        }
        self.branches.push(Branch { first, end, depth, runs: begin..self.runs.len() });
    }
}

/// The number of entries to reserve for n rows: the largest possible number, unless n is very large.
pub fn usual_entries(n: usize) -> usize {
    most_entries(n.min(LARGE))
}

/// The largest possible number of entries in n rows.
fn most_entries(n: usize) -> usize {
    (0..n).map(|diagonal| RowSpan { begin: 0, diagonal }.end()).sum()
}

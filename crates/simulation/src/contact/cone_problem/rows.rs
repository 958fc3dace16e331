//! The layout of A for the solver's loops: blocks over the same coordinates are adjacent, and rows are padded
//! to whole registers.

use core::ops::Range;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::paths::{
    WIDTH, filled_up, fours, fours_mut, product, subtract, with_constant,
};
use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use super::block::Block;
use super::set::Set;

/// Adjacent blocks over the same coordinates, or adjacent blocks of one row over one coordinate each.
#[derive(Clone, Debug)]
struct Group {
    rows: Range<usize>,
    support: Range<usize>,
    /// The index of its first entry.
    begin: usize,
    is_single: bool,
}

clone_in_place! {
    /// The rows of A in groups.
    #[derive(Debug)]
    pub(super) struct RowGroups {
        groups: Vec<Group>,
        entries: Vec<f64>,
        /// The index of the first entry of each block.
        begins: Vec<usize>,
        /// The blocks of one row over several coordinates.
        wide: Vec<usize>,
        /// A vector in the coordinates of one group.
        gathered: Vec<f64>,
    }
}

impl RowGroups {
    /// Allocates memory for n coordinates, and for this many blocks and entries.
    pub(super) fn new(n: usize, blocks: usize, entries: usize) -> Self {
        Self {
            groups: Vec::with_capacity(blocks),
            entries: Vec::with_capacity(entries),
            begins: Vec::with_capacity(blocks),
            wide: Vec::with_capacity(blocks),
            gathered: vec![0.0; filled_up(n)],
        }
    }

    /// Allocates memory for n coordinates.
    pub(super) fn make_room(&mut self, n: usize) {
        self.gathered.resize(filled_up(n).max(self.gathered.len()), 0.0);
    }

    /// Copies the entries of these blocks, which are stored row by row.
    pub(super) fn arrange(&mut self, blocks: &[Block], support: &[usize], a: &[f64]) {
        self.groups.clear();
        self.entries.clear();
        self.begins.clear();
        self.wide.clear();
        for (index, block) in blocks.iter().enumerate() {
            let (own, begin) = (&support[block.support.clone()], self.entries.len());
            let (count, is_interval) = (own.len(), matches!(block.set, Set::Interval(..)));
            let is_single = is_interval && count == 1;
            self.begins.push(begin);
            if is_interval && !is_single {
                self.wide.push(index);
            }
            if is_single {
                self.entries.push(a[block.entries]);
            } else if count > 0 {
                for row in a[block.entries..][..count * block.rows.len()].chunks_exact(count) {
                    self.entries.extend_from_slice(row);
                    self.entries.resize(self.entries.len() + filled_up(count) - count, 0.0);
                }
            }
            match self.groups.last_mut() {
                Some(last) if is_single && last.is_single => {
                    (last.rows.end, last.support.end) = (block.rows.end, block.support.end);
                }
                Some(last) if !is_single && !last.is_single && support[last.support.clone()] == *own => {
                    last.rows.end = block.rows.end;
                }
                _ => {
                    let (rows, support) = (block.rows.clone(), block.support.clone());
                    self.groups.push(Group { rows, support, begin, is_single });
                }
            }
        }
    }

    /// The blocks of one row over one coordinate: the coordinate, the entry and the row.
    #[inline(always)]
    pub(super) fn singles(&self, support: &[usize]) -> impl Iterator<Item = (usize, f64, usize)> {
        self.groups.iter().filter(|group| group.is_single).flat_map(|group| {
            let terms = support[group.support.clone()].iter().zip(&self.entries[group.begin..]);
            terms.zip(group.rows.clone()).map(|((k, a), row)| (*k, *a, row))
        })
    }

    /// The blocks of one row over several coordinates.
    pub(super) fn wide_rows(&self) -> impl Iterator<Item = usize> {
        self.wide.iter().copied()
    }

    /// The entries of a block with this number of coordinates and rows, padded row by row.
    #[inline(always)]
    pub(super) fn of_block(&self, block: usize, count: usize, rows: usize) -> &[f64] {
        let length = if count == 1 && rows == 1 { 1 } else { filled_up(count) * rows };
        &self.entries[self.begins[block]..][..length]
    }

    /// Computes A x into `to`, which has one entry for each row.
    pub(super) fn multiply(&mut self, support: &[usize], x: &[f64], to: &mut [f64]) {
        run_here(Multiply { rows: self, support, x, to });
    }

    /// Adds Aᵀp to `to`.
    pub(super) fn add_forces(&mut self, support: &[usize], p: &[f64], to: &mut [f64]) {
        run_here(AddForces { rows: self, support, p, to });
    }
}

struct Multiply<'a> {
    rows: &'a mut RowGroups,
    support: &'a [usize],
    x: &'a [f64],
    to: &'a mut [f64],
}

impl Call for Multiply<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { rows: RowGroups { groups, entries, gathered, .. }, support, x, to } = self;
        for Group { rows, support: own, begin, is_single } in groups {
            let (support, to, a) = (&support[own.clone()], &mut to[rows.clone()], &entries[*begin..]);
            if *is_single {
                for ((to, &k), a) in to.iter_mut().zip(support).zip(a) {
                    *to = a * x[k];
                }
                continue;
            }
            let width = filled_up(support.len());
            gather(support, x, &mut gathered[..width]);
            let (a, x) = (fours(&a[..width * to.len()]), fours(&gathered[..width]));
            with_constant!(width / WIDTH, |N| {
                for (to, row) in to.iter_mut().zip(a.chunks_exact(N.max(1))) {
                    *to = product(row, &x[..N]);
                }
            });
        }
    }
}

struct AddForces<'a> {
    rows: &'a mut RowGroups,
    support: &'a [usize],
    p: &'a [f64],
    to: &'a mut [f64],
}

impl Call for AddForces<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { rows: RowGroups { groups, entries, gathered, .. }, support, p, to } = self;
        for Group { rows, support: own, begin, is_single } in groups {
            let (support, p, a) = (&support[own.clone()], &p[rows.clone()], &entries[*begin..]);
            if *is_single {
                for ((&k, p), a) in support.iter().zip(p).zip(a) {
                    to[k] += a * p;
                }
                continue;
            }
            if p.iter().all(|p| *p == 0.0) {
                continue;
            }
            let width = filled_up(support.len());
            let gathered = &mut gathered[..width];
            gathered.fill(0.0);
            let (a, sums) = (fours(&a[..width * p.len()]), fours_mut(gathered));
            with_constant!(width / WIDTH, |N| {
                let sums = &mut sums[..N];
                for (p, row) in p.iter().zip(a.chunks_exact(N.max(1))) {
                    subtract(sums, -p, row);
                }
            });
            support.iter().zip(&*gathered).for_each(|(&k, force)| to[k] += force);
        }
    }
}

/// Copies x in these coordinates to `to`, padded with zeros.
#[inline(always)]
fn gather(support: &[usize], x: &[f64], to: &mut [f64]) {
    let (to, rest) = to.split_at_mut(support.len());
    to.iter_mut().zip(support).for_each(|(to, &k)| *to = x[k]);
    rest.fill(0.0);
}

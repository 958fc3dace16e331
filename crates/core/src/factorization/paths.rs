//! The factorization of [`sparse`](super::sparse) in packed form. Row k of the lower triangle holds its
//! entries at the ancestors of DoF k in ascending order, then the diagonal.
//!
//! The ancestors of an ancestor of k are the first ancestors of k. So the entries of a column have the same
//! position in all rows of a path, and the innermost loops run over slices. Each row begins at a multiple of
//! four entries, and those loops take four entries at a time. The padding after a diagonal is meaningless,
//! and only those loops read it.
//!
//! Consecutive rows that form a chain are one branch. Vectors are gathered along the whole path to a branch's
//! end, and written back when that branch is done.

mod four;
mod pattern;
mod sweeps;
mod unsymmetric_factor;

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use self::four::in_parts;
use self::pattern::RowSpan;

pub use self::four::{Four, WIDTH, add, add_three, fours, fours_mut, product, subtract, with_constant};
pub use self::pattern::{Paths, usual_entries};

impl Paths {
    /// The number of ancestors of DoF k: the position of its column in the rows of its descendants.
    pub fn depth(&self, k: usize) -> usize {
        self.rows[k].depth()
    }

    /// Row k of a packed matrix, with its padding.
    pub fn row_of<'a>(&self, k: usize, m: &'a mut [f64]) -> &'a mut [f64] {
        &mut m[self.rows[k].begin..self.rows[k].end()]
    }

    /// The diagonal entry of row k.
    pub fn diagonal_of<'a>(&self, k: usize, m: &'a mut [f64]) -> &'a mut f64 {
        &mut m[self.rows[k].diagonal]
    }

    /// The columns and the entries of row k of a packed matrix, its diagonal last.
    pub fn entries_of<'a>(&'a self, k: usize, m: &'a [f64]) -> (&'a [usize], &'a [f64]) {
        let RowSpan { begin, diagonal } = self.rows[k];
        (&self.columns[begin..=diagonal], &m[begin..=diagonal])
    }

    /// The entry of row k in the column of an ancestor of k, or of k itself.
    pub fn entry_of<'a>(&self, k: usize, column: usize, m: &'a mut [f64]) -> &'a mut f64 {
        let at = self.rows[k].begin + self.depth(column);
        debug_assert_eq!(self.columns[at], column);
        &mut m[at]
    }

    /// The number of entries, with padding.
    pub fn size(&self) -> usize {
        self.columns.len()
    }

    /// The rows of a packed matrix: each row's number, its columns, its entries there, and its diagonal.
    #[inline(always)]
    fn rows<'a>(
        &'a self,
        m: &'a [f64],
    ) -> impl DoubleEndedIterator<Item = (usize, &'a [usize], &'a [f64], f64)> {
        self.rows.iter().enumerate().map(|(k, row)| {
            let entries = row.begin..row.diagonal;
            (k, &self.columns[entries.clone()], &m[entries], m[row.diagonal])
        })
    }

    /// The diagonal of a packed matrix.
    pub fn diagonal<'a>(&'a self, m: &'a [f64]) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
        self.rows.iter().map(|row| m[row.diagonal])
    }

    /// Packs the lower triangle of a row-major matrix.
    pub fn pack(&self, dense: &[f64], packed: &mut Vec<f64>) {
        packed.resize(self.size(), 0.0);
        for (at, row) in self.rows.iter().zip(dense.chunks_exact(self.rows.len().max(1))) {
            let (entries, rest) = packed[at.begin..at.end()].split_at_mut(at.depth() + 1);
            let columns = &self.columns[at.begin..=at.diagonal];
            entries.iter_mut().zip(columns).for_each(|(entry, &column)| *entry = row[column]);
            rest.fill(0.0);
        }
    }

    /// Packs a symmetric matrix given by its upper triangle.
    pub fn pack_upper(&self, dense: &[f64], packed: &mut [f64]) {
        let n = self.rows.len();
        for (k, at) in self.rows.iter().enumerate() {
            let columns = &self.columns[at.begin..=at.diagonal];
            for (entry, &column) in packed[at.begin..].iter_mut().zip(columns) {
                *entry = dense[column * n + k];
            }
        }
    }

    /// Packs an upper triangle whose row i, from the diagonal on, begins at `begins[i]` and ends where the
    /// next one begins.
    pub fn pack_rows(&self, rows: &[f64], begins: &[usize], packed: &mut [f64]) {
        for (k, at) in self.rows.iter().enumerate() {
            let columns = &self.columns[at.begin..=at.diagonal];
            for (entry, &column) in packed[at.begin..].iter_mut().zip(columns) {
                let place = begins[column] + k - column;
                *entry = if place < begins[column + 1] { rows[place] } else { 0.0 };
            }
        }
    }

    /// Whether the zero patterns are equal.
    pub fn is_like(&self, other: &Self) -> bool {
        self.dof_parent == other.dof_parent
    }

    /// Packs again a matrix that is packed with more zeros.
    pub fn repack(&self, from: &Self, matrix: &[f64], packed: &mut Vec<f64>) {
        packed.clear();
        packed.resize(self.size(), 0.0);
        for (k, columns, entries, diagonal) in from.rows(matrix) {
            let row = self.row_of(k, packed);
            columns.iter().zip(entries).for_each(|(&column, entry)| row[self.depth(column)] = *entry);
            row[self.depth(k)] = diagonal;
        }
    }

    /// λ.
    pub fn dof_parent(&self) -> &[usize] {
        &self.dof_parent
    }

    /// As [`sparse::factor`](super::sparse::factor).
    pub fn factor(&self, m: &mut [f64]) {
        run_here(Factor { paths: self, m, quotient: |entry, _, inverse| entry * inverse });
    }

    /// As [`sparse::factor_by_division`](super::sparse::factor_by_division), with the same bits.
    pub fn factor_by_division(&self, m: &mut [f64]) {
        run_here(Factor { paths: self, m, quotient: |entry, pivot, _| entry / pivot });
    }

    /// `quotient` computes the quotient from an entry, the pivot and its inverse.
    #[inline(always)]
    fn factor_by(&self, m: &mut [f64], quotient: impl Fn(f64, f64, f64) -> f64) {
        let m = fours_mut(m);
        for row in self.rows.iter().rev() {
            let (above, own) = m.split_at_mut(row.begin / WIDTH);
            let depth = row.depth();
            let pivot = own[depth / WIDTH][depth % WIDTH];
            let pivot = if (0.0..f64::INFINITY).contains(&pivot) { pivot } else { f64::NAN };
            let inverse = 1.0 / pivot;
            let own = &mut own[..=depth / WIDTH];
            // A row with zeros at its beginning, as in a stack of many bodies, causes no fill-in there.
            let entries = &own.as_flattened()[..depth];
            let begin = entries.iter().position(|entry| *entry != 0.0).unwrap_or(depth) / WIDTH;
            let starts = &self.starts[row.begin..row.diagonal];
            for chunk in (begin..depth.div_ceil(WIDTH)).rev() {
                let factors = own[chunk].map(|entry| quotient(entry, pivot, inverse));
                let starts = &starts[WIDTH * chunk..];
                let starts = &starts[..starts.len().min(WIDTH)];
                in_parts!(begin, chunk + 1, |N, at| {
                    let left = &own[at..][..N];
                    for (&start, factor) in starts.iter().zip(factors) {
                        subtract(&mut above[start + at..][..N], factor, left);
                    }
                });
                own[chunk] = factors;
            }
            own[depth / WIDTH][depth % WIDTH] = pivot;
        }
    }

    /// As [`sparse::solve`](super::sparse::solve).
    pub fn solve(&self, l: &[f64], x: &mut [f64]) {
        run_here(Solve { paths: self, l, x });
    }

    /// The same for four vectors x side by side.
    pub fn solve_four(&self, l: &[f64], x: &mut [Four]) {
        run_here(SolveFour { paths: self, l, x });
    }

    /// `product` = M x.
    pub fn multiply(&self, m: &[f64], x: &[f64], product: &mut [f64]) {
        run_here(Multiply { paths: self, m, x, product });
    }
}

/// [`Paths::factor`] and [`Paths::factor_by_division`].
struct Factor<'a, Q> {
    paths: &'a Paths,
    m: &'a mut [f64],
    quotient: Q,
}

impl<Q: Fn(f64, f64, f64) -> f64> Call for Factor<'_, Q> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.paths.factor_by(self.m, self.quotient);
    }
}

/// [`Paths::solve`].
struct Solve<'a> {
    paths: &'a Paths,
    l: &'a [f64],
    x: &'a mut [f64],
}

impl Call for Solve<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.paths.solve_here(self.l, self.x);
    }
}

/// [`Paths::solve_four`].
struct SolveFour<'a> {
    paths: &'a Paths,
    l: &'a [f64],
    x: &'a mut [Four],
}

impl Call for SolveFour<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { paths, l, x } = self;
        for (k, columns, row, _) in paths.rows(l).rev() {
            let own = [x[k]];
            columns.iter().zip(row).for_each(|(&i, l)| subtract(&mut x[i..=i], *l, &own));
        }
        for (k, columns, row, pivot) in paths.rows(l) {
            let mut own = [x[k].map(|x| x / pivot)];
            columns.iter().zip(row).for_each(|(&i, l)| subtract(&mut own, *l, &x[i..=i]));
            [x[k]] = own;
        }
    }
}

/// [`Paths::multiply`].
struct Multiply<'a> {
    paths: &'a Paths,
    m: &'a [f64],
    x: &'a [f64],
    product: &'a mut [f64],
}

impl Call for Multiply<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.paths.multiply_here(self.m, self.x, self.product);
    }
}

/// The length of a row of this many entries, with padding.
pub fn filled_up(count: usize) -> usize {
    count.next_multiple_of(WIDTH)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::Paths;
    use crate::factorization::sparse;
    use crate::factorization::sparse::{NONE, dof_ancestors};

    /// Random trees: the factor, the solution and M x equal those of `sparse`.
    #[test]
    fn packed_rows_solve_as_parent_array() {
        let mut paths = Paths::new(3);
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            // Some paths are too long to gather.
            let n = if seed % 20 == 19 { 90 } else { 1 + (seed % 12) as usize };
            let mut below = |k: usize| usize::try_from(random.next_u64() % (k as u64 + 1)).unwrap();
            let mut tree: Vec<usize> = (0..n).map(|k| below(k).checked_sub(1).unwrap_or(NONE)).collect();
            if n > 12 || seed % 5 == 0 {
                tree = (0..n)
                    .map(|k| k.checked_sub(1 + usize::from(k % 9 == 8 && seed % 40 == 19)).unwrap_or(NONE))
                    .collect();
            }
            let mut matrix = vec![0.0; n * n];
            for k in 0..n {
                for i in dof_ancestors(&tree, k) {
                    matrix[k * n + i] = random.uniform(-1.0, 1.0);
                    matrix[i * n + k] = matrix[k * n + i];
                }
                matrix[k * n + k] = n as f64 + 1.0;
            }
            let x: Vec<f64> = (0..n).map(|_| random.uniform(-1.0, 1.0)).collect();
            paths.choose(&tree);
            assert!((0..n).all(|k| paths.depth(k) == dof_ancestors(&tree, k).count()));
            let packed = |matrix: &[f64]| {
                let mut packed = Vec::new();
                paths.pack(matrix, &mut packed);
                packed
            };
            let mut of_upper = vec![0.0; paths.size()];
            paths.pack_upper(&matrix, &mut of_upper);
            assert_eq!(of_upper, packed(&matrix), "seed {seed}");
            // With two paths joined.
            let mut joined = tree.clone();
            sparse::couple(&mut joined, [n / 2, n - 1]);
            let (mut wider, mut repacked, mut afresh) = (Paths::new(n), vec![f64::NAN], Vec::new());
            wider.choose(&joined);
            wider.repack(&paths, &of_upper, &mut repacked);
            wider.pack(&matrix, &mut afresh);
            assert_eq!(repacked, afresh, "seed {seed}");
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13 * n as f64);
            let mut by_division = [matrix.clone(), packed(&matrix)];
            sparse::factor_by_division(&tree, &mut by_division[0]);
            paths.factor_by_division(&mut by_division[1]);
            let entries = |packed: &[f64]| {
                paths
                    .rows
                    .iter()
                    .flat_map(|row| packed[row.begin..=row.diagonal].to_vec())
                    .collect::<Vec<_>>()
            };
            assert_eq!(entries(&packed(&by_division[0])), entries(&by_division[1]));
            let (mut factor, mut other) = (matrix.clone(), packed(&matrix));
            sparse::factor(&tree, &mut factor);
            paths.factor(&mut other);
            assert!(near(&entries(&packed(&factor)), &entries(&other)), "seed {seed}");
            let (mut one, mut two) = (x.clone(), x.clone());
            sparse::solve(&tree, &factor, &mut one);
            paths.solve(&other, &mut two);
            assert!(near(&one, &two), "seed {seed}");
            let mut four: Vec<[f64; 4]> = x.iter().map(|x| [*x, 2.0 * x, -x, 0.0]).collect();
            paths.solve_four(&other, &mut four);
            for (lane, factor) in [1.0, 2.0, -1.0, 0.0].into_iter().enumerate() {
                let own: Vec<f64> = four.iter().map(|four| four[lane]).collect();
                assert!(near(&one.iter().map(|x| factor * x).collect::<Vec<_>>(), &own), "seed {seed}");
            }
            let mut product = vec![f64::NAN; n];
            paths.multiply(&packed(&matrix), &x, &mut product);
            let row = |k: usize| matrix[k * n..(k + 1) * n].iter().zip(&x).map(|(m, x)| m * x).sum::<f64>();
            assert!(near(&(0..n).map(row).collect::<Vec<_>>(), &product), "seed {seed}");
        }
    }
}

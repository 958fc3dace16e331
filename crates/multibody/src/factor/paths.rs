//! The factorisation of [`sparse`](super::sparse), packed: row k of the lower triangle holds its entries at the freedoms that carry k,
//! rising, then the diagonal.
//!
//! What carries a carrier of k is the beginning of what carries k, so that entries of one column have one place in all rows of a path
//! and the innermost loops go along slices. Each row begins at a multiple of four entries and those loops take four at a time: what
//! they leave behind a diagonal is of no meaning, and nothing reads it but they.

use number::dispatch::{Call, Hardware, run_here};

use super::sparse::NONE;

/// Entries that are handled at a time.
const WIDTH: usize = 4;

/// The zeros of a matrix: which freedoms carry each.
#[derive(Clone, Debug)]
pub(crate) struct Paths {
    carrier: Vec<usize>,
    /// Of each entry its column, and of what fills up a row 0.
    columns: Vec<usize>,
    rows: Vec<Row>,
}

/// Where a row is.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// Its first entry.
    begin: usize,
    /// Its diagonal.
    diagonal: usize,
}

impl Row {
    /// Where the next row begins.
    #[inline(always)]
    fn end(self) -> usize {
        self.diagonal - self.diagonal % WIDTH + WIDTH
    }
}

impl Paths {
    /// With room for n freedoms.
    pub(crate) fn new(n: usize) -> Self {
        let (carrier, rows) = (Vec::with_capacity(n), Vec::with_capacity(n));
        Self { carrier, columns: Vec::with_capacity(most_entries(n)), rows }
    }

    /// Takes these λ; nothing to do where they are the last ones.
    pub(crate) fn choose(&mut self, carrier: &[usize]) {
        if self.carrier == carrier {
            return;
        }
        self.carrier.clear();
        self.carrier.extend_from_slice(carrier);
        self.columns.clear();
        self.rows.clear();
        for (k, &carrier) in carrier.iter().enumerate() {
            let begin = self.columns.len();
            if carrier != NONE {
                let Row { begin, diagonal } = self.rows[carrier];
                self.columns.extend_from_within(begin..=diagonal);
            }
            let row = Row { begin, diagonal: self.columns.len() };
            self.columns.push(k);
            self.columns.resize(row.end(), 0);
            self.rows.push(row);
        }
    }

    /// How many freedoms carry freedom k: the place of its column in the rows of all that it carries.
    pub(crate) fn depth(&self, k: usize) -> usize {
        self.rows[k].diagonal - self.rows[k].begin
    }

    /// Row k of a packed matrix, and what fills it up.
    pub(crate) fn row_of<'a>(&self, k: usize, m: &'a mut [f64]) -> &'a mut [f64] {
        &mut m[self.rows[k].begin..self.rows[k].end()]
    }

    /// The diagonal entry of row k.
    pub(crate) fn diagonal_of<'a>(&self, k: usize, m: &'a mut [f64]) -> &'a mut f64 {
        &mut m[self.rows[k].diagonal]
    }

    /// The entry of row k in the column of what carries k, or k itself.
    pub(crate) fn entry_of<'a>(&self, k: usize, column: usize, m: &'a mut [f64]) -> &'a mut f64 {
        let at = self.rows[k].begin + self.depth(column);
        debug_assert_eq!(self.columns[at], column);
        &mut m[at]
    }

    /// How many entries there are, with those that fill up the rows.
    pub(crate) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The rows of a packed matrix: of each its number, its columns, its entries there, and its diagonal.
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
    pub(crate) fn diagonal<'a>(
        &'a self,
        m: &'a [f64],
    ) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
        self.rows.iter().map(|row| m[row.diagonal])
    }

    /// The lower triangle of a matrix, row-major.
    pub(crate) fn pack(&self, dense: &[f64], packed: &mut Vec<f64>) {
        packed.clear();
        for (at, row) in self.rows.iter().zip(dense.chunks_exact(self.rows.len().max(1))) {
            packed.extend(self.columns[at.begin..=at.diagonal].iter().map(|&column| row[column]));
            packed.resize(at.end(), 0.0);
        }
    }

    /// As [`sparse::factor`](super::sparse::factor).
    pub(crate) fn factor(&self, m: &mut [f64]) {
        run_here(Factor { paths: self, m, quotient: |entry, _, inverse| entry * inverse });
    }

    /// As [`sparse::factor_by_division`](super::sparse::factor_by_division), to the bit.
    pub(crate) fn factor_by_division(&self, m: &mut [f64]) {
        run_here(Factor { paths: self, m, quotient: |entry, pivot, _| entry / pivot });
    }

    /// `quotient` of an entry, the pivot and its inverse.
    #[inline(always)]
    fn factor_by(&self, m: &mut [f64], quotient: impl Fn(f64, f64, f64) -> f64) {
        for row in self.rows.iter().rev() {
            let (above, own) = m[..row.end()].split_at_mut(row.begin);
            let depth = row.diagonal - row.begin;
            let pivot = if own[depth] >= 0.0 && own[depth] < f64::INFINITY { own[depth] } else { f64::NAN };
            let inverse = 1.0 / pivot;
            let columns = &self.columns[row.begin..row.diagonal];
            // What a row has no entries for at its beginning, as in a pile of many bodies, it fills in nowhere.
            let begin = own[..depth].iter().position(|entry| *entry != 0.0).unwrap_or(depth) / WIDTH;
            for chunk in (begin..depth.div_ceil(WIDTH)).rev() {
                let (first, end) = (WIDTH * chunk, WIDTH * (chunk + 1));
                let factors: [f64; WIDTH] =
                    core::array::from_fn(|k| quotient(own[first + k], pivot, inverse));
                for (&column, factor) in columns[first..].iter().zip(factors) {
                    let (at, from) = (self.rows[column].begin, WIDTH * begin);
                    subtract(&mut above[at + from..at + end], factor, &own[from..end]);
                }
                own[first..end].copy_from_slice(&factors);
            }
            own[depth] = pivot;
        }
    }

    /// As [`sparse::solve`](super::sparse::solve).
    pub(crate) fn solve(&self, l: &[f64], x: &mut [f64]) {
        run_here(Solve { paths: self, l, x });
    }

    #[inline(always)]
    fn solve_here(&self, l: &[f64], x: &mut [f64]) {
        for (k, columns, row, _) in self.rows(l).rev() {
            let own = x[k];
            columns.iter().zip(row).for_each(|(&i, l)| x[i] -= l * own);
        }
        for (k, columns, row, pivot) in self.rows(l) {
            x[k] = x[k] / pivot - sum_at(columns, row, x);
        }
    }

    /// `product` = M x.
    pub(crate) fn multiply(&self, m: &[f64], x: &[f64], product: &mut [f64]) {
        run_here(Multiply { paths: self, m, x, product });
    }

    #[inline(always)]
    fn multiply_here(&self, m: &[f64], x: &[f64], product: &mut [f64]) {
        for (k, columns, row, diagonal) in self.rows(m) {
            let own = x[k];
            columns.iter().zip(row).for_each(|(&i, m)| product[i] += m * own);
            product[k] = diagonal * own + sum_at(columns, row, x);
        }
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

/// Most entries of n rows.
pub(crate) fn most_entries(n: usize) -> usize {
    (0..n).map(|diagonal| Row { begin: 0, diagonal }.end()).sum()
}

/// How many entries a row of so many takes, with what fills it up.
pub(crate) fn filled_up(count: usize) -> usize {
    count.next_multiple_of(WIDTH)
}

/// a ← a − f b, of rows that are filled up.
#[inline(always)]
fn subtract(a: &mut [f64], f: f64, b: &[f64]) {
    let (a, b) = (a.as_chunks_mut::<WIDTH>().0, b.as_chunks::<WIDTH>().0);
    for (a, b) in a.iter_mut().zip(b) {
        // All are read before one is written: so the compiler may take them at a time.
        let (old, b) = (*a, *b);
        *a = core::array::from_fn(|k| old[k] - f * b[k]);
    }
}

/// a ← a + Σ f b, of rows that are filled up.
#[inline(always)]
pub(crate) fn add<const N: usize>(a: &mut [f64], factors: [f64; N], rows: [&[f64]; N]) {
    let rows = rows.map(|row| row.as_chunks::<WIDTH>().0);
    for (at, a) in a.as_chunks_mut::<WIDTH>().0.iter_mut().enumerate() {
        let mut sums = *a;
        for (f, row) in factors.iter().zip(&rows) {
            let row = row[at];
            sums = core::array::from_fn(|k| sums[k] + f * row[k]);
        }
        *a = sums;
    }
}

/// Σ of entries and x in their columns, in four sums at a time.
#[inline(always)]
fn sum_at(columns: &[usize], row: &[f64], x: &[f64]) -> f64 {
    let (columns, last_columns) = columns.as_chunks::<WIDTH>();
    let (row, last) = row.as_chunks::<WIDTH>();
    let mut sums = [0.0; WIDTH];
    for (columns, row) in columns.iter().zip(row) {
        (0..WIDTH).for_each(|k| sums[k] += row[k] * x[columns[k]]);
    }
    let rest: f64 = last_columns.iter().zip(last).map(|(&i, entry)| entry * x[i]).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use dynamics::SplitMix64;

    use super::Paths;
    use crate::factor::sparse::{self, NONE, carriers};

    /// Random trees: the same factor, the same solution, and M x.
    #[test]
    fn packed_rows_solve_as_carriers() {
        let mut paths = Paths::new(3);
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            let n = 1 + (seed % 12) as usize;
            let mut below = |k: usize| usize::try_from(random.next_u64() % (k as u64 + 1)).unwrap();
            let tree: Vec<usize> = (0..n).map(|k| below(k).checked_sub(1).unwrap_or(NONE)).collect();
            let mut matrix = vec![0.0; n * n];
            for k in 0..n {
                for i in carriers(&tree, k) {
                    matrix[k * n + i] = random.uniform(-1.0, 1.0);
                    matrix[i * n + k] = matrix[k * n + i];
                }
                matrix[k * n + k] = n as f64 + 1.0;
            }
            let x: Vec<f64> = (0..n).map(|_| random.uniform(-1.0, 1.0)).collect();
            paths.choose(&tree);
            assert!((0..n).all(|k| paths.depth(k) == carriers(&tree, k).count()));
            let packed = |matrix: &[f64]| {
                let mut packed = Vec::new();
                paths.pack(matrix, &mut packed);
                packed
            };
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
            let mut product = vec![f64::NAN; n];
            paths.multiply(&packed(&matrix), &x, &mut product);
            let row = |k: usize| matrix[k * n..(k + 1) * n].iter().zip(&x).map(|(m, x)| m * x).sum::<f64>();
            assert!(near(&(0..n).map(row).collect::<Vec<_>>(), &product), "seed {seed}");
        }
    }
}

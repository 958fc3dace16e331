//! The factorisation of [`sparse`](super::sparse), packed: row k of the lower triangle holds its entries at the freedoms that carry k,
//! rising, then the diagonal.
//!
//! What carries a carrier of k is the beginning of what carries k, so that entries of one column have one place in all rows of a path
//! and the innermost loops go along slices.

use super::sparse::NONE;

/// The zeros of a matrix: which freedoms carry each.
#[derive(Clone, Debug)]
pub(crate) struct Paths {
    carrier: Vec<usize>,
    /// For each row the columns of its entries, but for the diagonal, and the diagonal's.
    columns: Vec<usize>,
    /// Where each row begins, and the end of the last one.
    first: Vec<usize>,
}

impl Paths {
    /// With room for n freedoms.
    pub(crate) fn new(n: usize) -> Self {
        let (carrier, first) = (Vec::with_capacity(n), Vec::with_capacity(n + 1));
        Self { carrier, columns: Vec::with_capacity(n * (n + 1) / 2), first }
    }

    /// Takes these λ; nothing to do where they are the last ones.
    pub(crate) fn choose(&mut self, carrier: &[usize]) {
        if self.carrier == carrier {
            return;
        }
        self.carrier.clear();
        self.carrier.extend_from_slice(carrier);
        self.columns.clear();
        self.first.clear();
        for (k, &carrier) in carrier.iter().enumerate() {
            self.first.push(self.columns.len());
            if carrier != NONE {
                self.columns.extend_from_within(self.first[carrier]..self.first[carrier + 1]);
            }
            self.columns.push(k);
        }
        self.first.push(self.columns.len());
    }

    /// How many freedoms carry freedom k: the place of its column in the rows of all that it carries.
    pub(crate) fn depth(&self, k: usize) -> usize {
        self.first[k + 1] - self.first[k] - 1
    }

    /// Row k of a packed matrix.
    pub(crate) fn row_of<'a>(&self, k: usize, m: &'a mut [f64]) -> &'a mut [f64] {
        &mut m[self.first[k]..self.first[k + 1]]
    }

    /// How many entries there are.
    pub(crate) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The rows of a packed matrix: of each its number, its columns, its entries there, and its diagonal.
    fn rows<'a>(
        &'a self,
        m: &'a [f64],
    ) -> impl DoubleEndedIterator<Item = (usize, &'a [usize], &'a [f64], f64)> {
        self.first.windows(2).enumerate().map(|(k, ends)| {
            let (begin, diagonal) = (ends[0], ends[1] - 1);
            (k, &self.columns[begin..diagonal], &m[begin..diagonal], m[diagonal])
        })
    }

    /// The diagonal of a packed matrix.
    pub(crate) fn diagonal<'a>(
        &'a self,
        m: &'a [f64],
    ) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
        self.first[1..].iter().map(|end| m[end - 1])
    }

    /// The lower triangle of a matrix, row-major.
    pub(crate) fn pack(&self, dense: &[f64], packed: &mut Vec<f64>) {
        let n = self.carrier.len();
        packed.clear();
        for k in 0..n {
            let row = &dense[k * n..(k + 1) * n];
            packed.extend(self.columns[self.first[k]..self.first[k + 1]].iter().map(|&column| row[column]));
        }
    }

    /// As [`sparse::factor`](super::sparse::factor).
    pub(crate) fn factor(&self, m: &mut [f64]) {
        self.factor_by(m, |entry, _, inverse| entry * inverse);
    }

    /// As [`sparse::factor_by_division`](super::sparse::factor_by_division), to the bit.
    pub(crate) fn factor_by_division(&self, m: &mut [f64]) {
        self.factor_by(m, |entry, pivot, _| entry / pivot);
    }

    /// `quotient` of an entry, the pivot and its inverse.
    #[inline(always)]
    fn factor_by(&self, m: &mut [f64], quotient: impl Fn(f64, f64, f64) -> f64) {
        for ends in self.first.windows(2).rev() {
            let columns = &self.columns[ends[0]..ends[1] - 1];
            let (above, own) = m[..ends[1]].split_at_mut(ends[0]);
            let Some((diagonal, own)) = own.split_last_mut() else { continue };
            // Of a number that is no square √ is NaN; of others this adds nothing.
            let pivot = diagonal.sqrt().mul_add(0.0, *diagonal);
            *diagonal = pivot;
            let inverse = 1.0 / pivot;
            for (place, &column) in columns.iter().enumerate().rev() {
                let factor = quotient(own[place], pivot, inverse);
                let begin = self.first[column];
                subtract(&mut above[begin..=begin + place], factor, &own[..=place]);
                own[place] = factor;
            }
        }
    }

    /// As [`sparse::solve`](super::sparse::solve).
    pub(crate) fn solve(&self, l: &[f64], x: &mut [f64]) {
        for (k, columns, row, _) in self.rows(l).rev() {
            let own = x[k];
            columns.iter().zip(row).for_each(|(&i, l)| x[i] -= l * own);
        }
        for (k, columns, row, pivot) in self.rows(l) {
            let known: f64 = columns.iter().zip(row).map(|(&i, l)| l * x[i]).sum();
            x[k] = x[k] / pivot - known;
        }
    }

    /// `product` = M x.
    pub(crate) fn multiply(&self, m: &[f64], x: &[f64], product: &mut [f64]) {
        for (k, columns, row, diagonal) in self.rows(m) {
            let own = x[k];
            let mut sum = diagonal * own;
            for (&i, m) in columns.iter().zip(row) {
                sum += m * x[i];
                product[i] += m * own;
            }
            product[k] = sum;
        }
    }
}

/// a ← a − f b.
#[inline(always)]
fn subtract(a: &mut [f64], f: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= f * b);
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
            assert_eq!(packed(&by_division[0]), by_division[1]);
            let (mut factor, mut other) = (matrix.clone(), packed(&matrix));
            sparse::factor(&tree, &mut factor);
            paths.factor(&mut other);
            assert!(near(&packed(&factor), &other), "seed {seed}");
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

//! The factor of held rows, and the solution of their equations for many right sides.
//!
//! M = LᵀDL gives the whitened rows W = A L⁻¹D^(−1/2), with A M⁻¹Aᵀ = W Wᵀ. Gram–Schmidt, applied twice,
//! gives W = T Q with orthonormal rows of Q. With y = D^(1/2)L a, the equations M a − Aᵀλ = f, A a = c are
//!
//! > y = g + Qᵀw,  w = T⁻¹c − Q g,  g = D^(−1/2)L⁻ᵀ f,  λ = T⁻ᵀ w,
//!
//! and a = L⁻¹D^(−1/2) y. Rows that depend on earlier ones have zero rows in Q, and λ = 0. All matrices are
//! row-major, and all steps add multiples of rows, which the compiler turns into vector instructions.
//!
//! Source: Golub, Van Loan, *Matrix Computations* (2013), ch. 5.2.

use robot_dynamics_core::factorization::sparse::dof_ancestors;
use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use super::super::row_factor::ROUNDING;

/// The whitened rows and their factor.
#[derive(Clone, Debug)]
pub(super) struct RowBasis {
    nv: usize,
    count: usize,
    /// λ of the tree of M, and the factor L with D on its diagonal, nv×nv.
    pub(super) dof_parent: Vec<usize>,
    pub(super) lower: Vec<f64>,
    /// D^(−1/2).
    roots: Vec<f64>,
    /// Qᵀ, nv×K.
    basis: Vec<f64>,
    /// T, K×K, and the factors of both passes.
    triangle: Vec<f64>,
    passes: [Vec<f64>; 2],
    lengths: Vec<f64>,
}

/// The right sides f and c, which become a and λ.
pub(super) struct RightSides<'a> {
    /// f, then a: nv rows.
    pub(super) forces: &'a mut [f64],
    /// c, then λ: K rows.
    pub(super) rates: &'a mut [f64],
    /// The number of right sides.
    pub(super) width: usize,
}

impl RowBasis {
    pub(super) fn new(dof_parent: Vec<usize>, count: usize) -> Self {
        let nv = dof_parent.len();
        Self {
            nv,
            count,
            dof_parent,
            lower: vec![0.0; nv * nv],
            roots: vec![0.0; nv],
            basis: vec![0.0; nv * count],
            triangle: vec![0.0; count * count],
            passes: [(); 2].map(|()| vec![0.0; count * count]),
            lengths: vec![0.0; count],
        }
    }

    /// Factors the rows A, K×nv, after `lower` was set. A row whose independent part is below `dependence`
    /// of its length counts as dependent.
    pub(super) fn factor(&mut self, rows: &[f64], dependence: f64) {
        for (k, root) in self.roots.iter_mut().enumerate() {
            *root = 1.0 / self.lower[k * self.nv + k].sqrt();
        }
        run_here(Factor { basis: self, rows, dependence });
    }

    /// Solves the equations for all right sides.
    pub(super) fn solve(&self, sides: RightSides<'_>) {
        run_here(Solve { basis: self, sides });
    }

    /// The number of independent rows.
    pub(super) fn rank(&self) -> usize {
        (0..self.count).filter(|i| self.triangle[i * self.count + i] > 0.0).count()
    }

    /// X ← D^(−1/2)L⁻ᵀ X.
    #[inline(always)]
    fn whiten(&self, width: usize, x: &mut [f64]) {
        for k in (0..self.nv).rev() {
            let (before, own) = x.split_at_mut(k * width);
            let own = &mut own[..width];
            for i in dof_ancestors(&self.dof_parent, k) {
                add_multiple(-self.lower[k * self.nv + i], own, &mut before[i * width..(i + 1) * width]);
            }
            scale(self.roots[k], own);
        }
    }

    /// X ← L⁻¹D^(−1/2) X.
    #[inline(always)]
    fn unwhiten(&self, width: usize, x: &mut [f64]) {
        for k in 0..self.nv {
            let (before, own) = x.split_at_mut(k * width);
            let own = &mut own[..width];
            scale(self.roots[k], own);
            for i in dof_ancestors(&self.dof_parent, k) {
                add_multiple(-self.lower[k * self.nv + i], &before[i * width..(i + 1) * width], own);
            }
        }
    }
}

struct Factor<'a> {
    basis: &'a mut RowBasis,
    /// A.
    rows: &'a [f64],
    dependence: f64,
}

impl Call for Factor<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let (nv, count) = (self.basis.nv, self.basis.count);
        let mut basis = std::mem::take(&mut self.basis.basis);
        for k in 0..nv {
            for i in 0..count {
                basis[k * count + i] = self.rows[i * nv + k];
            }
        }
        self.basis.whiten(count, &mut basis);
        let RowBasis { triangle, passes: [first, second], lengths, .. } = self.basis;
        lengths.fill(0.0);
        for row in basis.chunks_exact(count.max(1)) {
            lengths.iter_mut().zip(row).for_each(|(length, x)| *length += x * x);
        }
        for length in lengths.iter_mut() {
            *length = length.sqrt();
        }
        let least = ROUNDING * lengths.iter().fold(0.0_f64, |most, length| most.max(*length));
        for length in lengths.iter_mut() {
            *length = (self.dependence * *length).max(least);
        }
        orthonormalize(count, &mut basis, first, lengths);
        // The second pass removes the rounding of the first; rows of zeros stay.
        lengths.fill(0.5);
        orthonormalize(count, &mut basis, second, lengths);
        triangle.fill(0.0);
        for i in 0..count {
            for k in 0..=i {
                let factor = first[i * count + k];
                add_multiple(
                    factor,
                    &second[k * count..(k + 1) * count],
                    &mut triangle[i * count..][..count],
                );
            }
        }
        self.basis.basis = basis;
    }
}

/// Makes the columns of an nv×K matrix orthonormal, W = T Q, from the first to the last. A column whose rest
/// is not above its entry of `least` becomes zero, and its diagonal entry of T too.
#[inline(always)]
fn orthonormalize(count: usize, columns: &mut [f64], triangle: &mut [f64], least: &[f64]) {
    triangle.fill(0.0);
    for i in 0..count {
        let square: f64 = columns.iter().skip(i).step_by(count).map(|x| x * x).sum();
        let length = square.sqrt();
        let is_independent = length > least[i];
        let scale = if is_independent { 1.0 / length } else { 0.0 };
        columns.iter_mut().skip(i).step_by(count).for_each(|x| *x *= scale);
        // Row i of Tᵀ: the components of the later rows along this one.
        let component = &mut triangle[i * count..(i + 1) * count];
        for row in columns.chunks_exact(count) {
            add_multiple(row[i], &row[i + 1..], &mut component[i + 1..]);
        }
        component[i] = if is_independent { length } else { 0.0 };
        for row in columns.chunks_exact_mut(count) {
            let (own, later) = row.split_at_mut(i + 1);
            add_multiple(-own[i], &component[i + 1..], later);
        }
    }
    for i in 0..count {
        for j in 0..i {
            triangle[i * count + j] = triangle[j * count + i];
            triangle[j * count + i] = 0.0;
        }
    }
}

struct Solve<'a> {
    basis: &'a RowBasis,
    sides: RightSides<'a>,
}

impl Call for Solve<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let (basis, RightSides { forces, rates, width }) = (self.basis, self.sides);
        let (count, t) = (basis.count, &basis.triangle);
        let inverse = |i: usize| {
            let pivot = t[i * count + i];
            if pivot > 0.0 { 1.0 / pivot } else { 0.0 }
        };
        basis.whiten(width, forces);
        for i in 0..count {
            let (before, own) = rates.split_at_mut(i * width);
            let own = &mut own[..width];
            for (j, row) in before.chunks_exact(width).enumerate() {
                add_multiple(-t[i * count + j], row, own);
            }
            scale(inverse(i), own);
        }
        let rows = || basis.basis.chunks_exact(count.max(1));
        for (g, q) in forces.chunks_exact(width).zip(rows()) {
            for (w, &q) in rates.chunks_exact_mut(width).zip(q) {
                add_multiple(-q, g, w);
            }
        }
        for (y, q) in forces.chunks_exact_mut(width).zip(rows()) {
            for (w, &q) in rates.chunks_exact(width).zip(q) {
                add_multiple(q, w, y);
            }
        }
        for i in (0..count).rev() {
            let (own, after) = rates[i * width..].split_at_mut(width);
            for (j, row) in after.chunks_exact(width).enumerate() {
                add_multiple(-t[(i + 1 + j) * count + i], row, own);
            }
            scale(inverse(i), own);
        }
        basis.unwhiten(width, forces);
    }
}

#[inline(always)]
fn scale(c: f64, x: &mut [f64]) {
    for x in x {
        *x *= c;
    }
}

/// `y` += c x.
#[inline(always)]
fn add_multiple(c: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += c * x;
    }
}

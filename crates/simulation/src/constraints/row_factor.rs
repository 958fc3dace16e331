//! The rows of A made orthonormal in the metric M⁻¹, by the sparse factor M = LᵀDL: A = T E, E M⁻¹Eᵀ = 1.
//!
//! Gram–Schmidt is applied twice to every row. Λ = A M⁻¹Aᵀ = T Tᵀ is never formed, because its condition
//! number is the square of T's. Dependent rows get a zero row in E and are listed. Cost: O(K² nv + K nv
//! depth). Source: Golub, Van Loan, *Matrix Computations* (2013), ch. 5.2.

use nalgebra::{DMatrix, DVector, DVectorView, DVectorViewMut};
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::{Model, Workspace, check_rank, mass_matrix};
use robot_dynamics_description::check_length;
use robot_dynamics_number::check_finite;

use super::rows::ConstraintRows;
use super::{ConstraintError, ConstraintOptions, ConstraintSet, NamedDependentRow, RedundantRows};

/// M(q) and its factor.
pub(super) struct MassFactor {
    pub mass: DMatrix<f64>,
    dof_parent: Vec<usize>,
    lower: Vec<f64>,
}

impl MassFactor {
    pub(super) fn new(model: &Model, workspace: &mut Workspace, q: &[f64]) -> Result<Self, ConstraintError> {
        check_rank(model, workspace, q)?;
        let nv = model.nv();
        let mut lower = vec![0.0; nv * nv];
        mass_matrix(model, workspace, q, &mut lower);
        let mass = DMatrix::from_row_slice(nv, nv, &lower);
        let dof_parent = workspace.dense.dof_parent.clone();
        sparse::factor(&dof_parent, &mut lower);
        Ok(Self { mass, dof_parent, lower })
    }

    /// M⁻¹ f.
    pub(super) fn solve(&self, force: &DVector<f64>) -> DVector<f64> {
        let mut x = force.clone();
        sparse::solve(&self.dof_parent, &self.lower, x.as_mut_slice());
        x
    }

    /// M⁻¹ F, column by column.
    pub(super) fn solve_columns(&self, mut forces: DMatrix<f64>) -> DMatrix<f64> {
        for mut column in forces.column_iter_mut() {
            sparse::solve(&self.dof_parent, &self.lower, column.as_mut_slice());
        }
        forces
    }
}

/// The rows at a state, M and their factors.
pub(super) struct FactoredRows {
    pub rows: ConstraintRows,
    pub mass: MassFactor,
    pub factor: RowFactor,
}

/// Checks the options and the state, and factors M and the rows there.
///
/// # Errors
/// An option, a number of the state or a row is not finite, or M is singular.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub(super) fn factor_rows(
    model: &Model,
    workspace: &mut Workspace,
    (set, options): (&ConstraintSet, &ConstraintOptions),
    (q, v): (&[f64], &[f64]),
) -> Result<FactoredRows, ConstraintError> {
    workspace.check_inputs(model, q);
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), model.nv());
    check_finite("q", q)?;
    check_finite("v", v)?;
    options.check()?;
    let rows = set.rows(model, workspace, q, v);
    let mass = MassFactor::new(model, workspace, q)?;
    let factor = RowFactor::of(set, &mass, &rows, options.dependence)?;
    Ok(FactoredRows { rows, mass, factor })
}

/// A = T E with T lower triangular (K×K) and the non-zero rows of E orthonormal in M⁻¹.
///
/// Gram–Schmidt, applied twice to every row. A row that depends on earlier ones has a zero row in E and a
/// zero pivot in T. So A = T E and Λ = A M⁻¹Aᵀ = T Tᵀ still hold. Λ is never formed, because its condition
/// number is the square of T's. Source: Golub, Van Loan, *Matrix Computations* (2013), ch. 5.2.
pub(super) struct RowFactor {
    /// T.
    pub triangle: DMatrix<f64>,
    /// E, K×nv.
    pub forces: DMatrix<f64>,
    /// E M⁻¹, K×nv.
    pub responses: DMatrix<f64>,
    /// The rows that add to the rank.
    pub independent: Vec<usize>,
    /// The others, each with the earlier rows whose combination it is.
    dependent: Vec<(usize, Vec<usize>)>,
}

/// A row shorter than this fraction of the longest is rounding, such as the row across the plane of a planar
/// loop. For levers of millimetres at a distance of ten metres, rounding is 1e-12 of the other rows.
pub(super) const ROUNDING: f64 = 1e-11;

impl RowFactor {
    /// `dependence` is the fraction of a row's length below which its independent part counts as zero.
    pub(super) fn new(mass: &MassFactor, rows: &DMatrix<f64>, dependence: f64) -> Self {
        let (count, nv) = rows.shape();
        let mut factor = Self {
            triangle: DMatrix::zeros(count, count),
            forces: DMatrix::zeros(count, nv),
            responses: DMatrix::zeros(count, nv),
            independent: Vec::new(),
            dependent: Vec::new(),
        };
        let length = |row: DVector<f64>| row.dot(&mass.solve(&row)).sqrt();
        let lengths: Vec<f64> = (0..count).map(|i| length(rows.row(i).transpose())).collect();
        let least = ROUNDING * lengths.iter().fold(0.0_f64, |most, length| most.max(*length));
        for (i, &length) in lengths.iter().enumerate() {
            let mut rest = rows.row(i).transpose();
            for _pass in 0..2 {
                for &j in &factor.independent {
                    // Component along e_j in the metric M⁻¹.
                    let component = factor.responses.row(j).transpose().dot(&rest);
                    factor.triangle[(i, j)] += component;
                    rest -= factor.forces.row(j).transpose() * component;
                }
            }
            let response = mass.solve(&rest);
            let remainder = rest.dot(&response).sqrt();
            if remainder > (dependence * length).max(least) {
                factor.triangle[(i, i)] = remainder;
                factor.forces.set_row(i, &(rest / remainder).transpose());
                factor.responses.set_row(i, &(response / remainder).transpose());
                factor.independent.push(i);
            } else {
                let combination = factor.combination(i, dependence * length);
                factor.dependent.push((i, combination));
            }
        }
        factor
    }

    /// The factor of a set's rows. Returns an error if a row is not finite.
    pub(super) fn of(
        set: &ConstraintSet,
        mass: &MassFactor,
        rows: &ConstraintRows,
        dependence: f64,
    ) -> Result<Self, ConstraintError> {
        rows.check(set.row_names())?;
        Ok(Self::new(mass, &rows.matrix, dependence))
    }

    pub(super) fn rank(&self) -> usize {
        self.independent.len()
    }

    /// The rows that do not add to the rank.
    pub(super) fn dependent_indices(&self) -> impl Iterator<Item = usize> + '_ {
        self.dependent.iter().map(|(row, _)| *row)
    }

    /// The dependent rows by name.
    fn dependent_rows(&self, set: &ConstraintSet) -> Vec<NamedDependentRow> {
        let name = |&row: &usize| set.row_names()[row].clone();
        let named = |(row, combination): &(usize, Vec<usize>)| NamedDependentRow {
            row: *row,
            name: name(row),
            combination_of: combination.iter().map(name).collect(),
        };
        self.dependent.iter().map(named).collect()
    }

    /// The dependent rows by name.
    ///
    /// # Errors
    /// There are some, and the options refuse them.
    pub(super) fn allowed_dependent_rows(
        &self,
        set: &ConstraintSet,
        options: &ConstraintOptions,
    ) -> Result<Vec<NamedDependentRow>, ConstraintError> {
        let rows = self.dependent_rows(set);
        if options.redundant == RedundantRows::Refuse && !rows.is_empty() {
            return Err(ConstraintError::DependentRows { rank: self.rank(), rows });
        }
        Ok(rows)
    }

    /// The earlier rows with a coefficient in row i = Σ cⱼ row j: Tᵀ c = T row i, by back substitution.
    fn combination(&self, i: usize, negligible: f64) -> Vec<usize> {
        let t = &self.triangle;
        let mut coefficient = DVector::<f64>::zeros(i);
        for &j in self.independent.iter().rev() {
            let later: f64 = (j + 1..i).map(|k| coefficient[k] * t[(k, j)]).sum();
            coefficient[j] = (t[(i, j)] - later) / t[(j, j)];
        }
        let contributes = |&j: &usize| coefficient[j].abs() * t.row(j).amax() > negligible;
        self.independent.iter().copied().filter(contributes).collect()
    }

    /// x of T x = y on the independent rows, 0 on the others.
    pub(super) fn solve_triangle(&self, y: &DVector<f64>) -> DVector<f64> {
        let mut x = DVector::zeros(y.len());
        self.solve_triangle_into(y.column(0), x.column_mut(0));
        x
    }

    /// x of Tᵀ x = y on the independent rows, 0 on the others.
    pub(super) fn solve_triangle_transposed(&self, y: &DVector<f64>) -> DVector<f64> {
        let mut x = DVector::zeros(y.len());
        self.solve_transposed_into(y.column(0), x.column_mut(0));
        x
    }

    /// The same into an x of zeros.
    fn solve_triangle_into(&self, y: DVectorView<'_, f64>, mut x: DVectorViewMut<'_, f64>) {
        for &i in &self.independent {
            let before: f64 = self.triangle.row(i).iter().zip(x.iter()).take(i).map(|(t, x)| t * x).sum();
            x[i] = (y[i] - before) / self.triangle[(i, i)];
        }
    }

    /// The same into an x of zeros.
    fn solve_transposed_into(&self, y: DVectorView<'_, f64>, mut x: DVectorViewMut<'_, f64>) {
        for &i in self.independent.iter().rev() {
            let after: f64 = (i + 1..y.len()).map(|k| self.triangle[(k, i)] * x[k]).sum();
            x[i] = (y[i] - after) / self.triangle[(i, i)];
        }
    }

    /// [`solve_triangle`](Self::solve_triangle) for each column.
    pub(super) fn solve_triangle_columns(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let mut x = DMatrix::zeros(y.nrows(), y.ncols());
        for (x, y) in x.column_iter_mut().zip(y.column_iter()) {
            self.solve_triangle_into(y, x);
        }
        x
    }

    /// [`solve_triangle_transposed`](Self::solve_triangle_transposed) for each column.
    pub(super) fn solve_transposed_columns(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let mut x = DMatrix::zeros(y.nrows(), y.ncols());
        for (x, y) in x.column_iter_mut().zip(y.column_iter()) {
            self.solve_transposed_into(y, x);
        }
        x
    }

    /// Computes P v = v − M⁻¹Eᵀ E v twice: the second pass removes the rounding errors of the first. **(PRM
    /// 10.19)**
    pub(super) fn project_velocity(&self, v: &DVector<f64>) -> DVector<f64> {
        let once = v - self.responses.tr_mul(&(&self.forces * v));
        let again = self.responses.tr_mul(&(&self.forces * &once));
        once - again
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::neutral;
    use robot_dynamics_description::{RandomRobotOptions, random_robot};

    use super::*;

    /// A row in other units counts, a row of rounding errors does not.
    #[test]
    fn rows_of_rounding_add_nothing() {
        let model = Model::new(random_robot(2, &RandomRobotOptions::default())).expect("a robot");
        let q = neutral(&model);
        let mass = MassFactor::new(&model, &mut Workspace::new(&model), &q).expect("a mass matrix");
        let nv = model.nv();
        for (scale, rank) in [(1.0, 2), (1e-8, 2), (1e-16, 1), (0.0, 1)] {
            let rows = DMatrix::from_fn(2, nv, |i, k| if i == 0 { 1.0 } else { scale * (k as f64 - 0.3) });
            assert_eq!(RowFactor::new(&mass, &rows, 1e-9).rank(), rank, "{scale}");
        }
    }
}

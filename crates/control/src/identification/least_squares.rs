//! Weighted least squares for the base parameters: W_b β = τ, with standard errors.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::factorization::singular_values::SingularValues;
use robot_dynamics_number::{InvalidInput, check_result};

use super::base_parameters::{BaseParameters, DEPENDENCE};
use super::{IdentificationError, MotionRecord};

/// Combinations with a part below this fraction of the largest are left out of a weakest direction.
const SHOWN: f64 = 0.1;

impl BaseParameters {
    /// Estimates β from data as the least-squares solution of W_b β = τ, by singular values of the columns
    /// scaled to unit length. Rows are divided by the noise that the record states.
    ///
    /// # Errors
    /// [`IdentificationError`] if there are too few data, if they do not determine a base parameter, or if
    /// the record identifies other joint terms.
    pub fn identify(&self, record: &MotionRecord<'_>) -> Result<IdentificationResult, IdentificationError> {
        if record.columns() != self.combinations.ncols() {
            let requirement = "must be of the record's robot and of its joint terms";
            return Err(InvalidInput::unmet("the base parameters", requirement).into());
        }
        let (equations, unknowns) = (record.torques.len(), self.len());
        if equations < unknowns || unknowns == 0 {
            let coordinates = record.model.nv();
            return Err(IdentificationError::TooFewData { equations, unknowns, coordinates });
        }
        let indices: Vec<usize> = self.parameters.iter().map(|parameter| parameter.index).collect();
        let mut columns = record.stacked().select_columns(&indices);
        let lengths: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
        let not_excited = |rank, missing: usize| {
            let missing = self.parameters[missing].name.clone();
            IdentificationError::NotExcited { rank, unknowns, missing }
        };
        if let Some(missing) = lengths.iter().position(|length| *length == 0.0) {
            return Err(not_excited(lengths.iter().filter(|length| **length > 0.0).count(), missing));
        }
        for (mut column, length) in columns.column_iter_mut().zip(&lengths) {
            column /= *length;
        }
        let torques = DVector::from_column_slice(&record.torques);
        // W = Q R, R V = U Σ: the singular values of W follow from the small matrix R.
        let triangle = columns.clone().qr();
        let SingularValues { product, right: v, values: singular_values } = SingularValues::of(&triangle.r());
        let singular_values = DVector::from_vec(singular_values);
        let (largest, smallest) = (singular_values.max(), singular_values.min());
        let weakest = singular_values.imin();
        if smallest <= DEPENDENCE * largest {
            let rank = singular_values.iter().filter(|x| **x > DEPENDENCE * largest).count();
            return Err(not_excited(rank, v.column(weakest).iamax()));
        }
        // x = V Σ⁻² (R V)ᵀ Qᵀ τ.
        let q = triangle.q();
        let squares = singular_values.component_mul(&singular_values);
        let solve = |right: &DVector<f64>| &v * product.tr_mul(&q.tr_mul(right)).component_div(&squares);
        let mut scaled = solve(&torques);
        scaled += solve(&(&torques - &columns * &scaled));
        let left = &torques - &columns * &scaled;
        let freedom = (equations - unknowns).max(1) as f64;
        let residual = left.norm() / (equations as f64).sqrt();
        // σ² (WᵀW)⁻¹ = σ² V Σ⁻² Vᵀ, σ² = |residual|²/(equations − unknowns).
        let mut spread = v.clone();
        for (mut column, singular) in spread.column_iter_mut().zip(&singular_values) {
            column *= left.norm() / freedom.sqrt() / singular;
        }
        for (mut row, length) in spread.row_iter_mut().zip(&lengths) {
            row /= *length;
        }
        let values = DVector::from_fn(unknowns, |i, _| scaled[i] / lengths[i]);
        check_result("β", values.iter().chain([&residual]))?;
        Ok(IdentificationResult {
            standard_deviations: DVector::from_fn(unknowns, |i, _| spread.row(i).norm()),
            covariance: &spread * spread.transpose(),
            values,
            residual,
            residuals: record.residuals_of(&left),
            condition: largest / smallest,
            weakest: self.named_direction(v.column(weakest).as_slice(), &lengths),
        })
    }

    /// A direction of scaled base parameters by name, with a largest part of 1.
    fn named_direction(&self, scaled: &[f64], lengths: &[f64]) -> Vec<(String, f64)> {
        let direction: Vec<f64> = scaled.iter().zip(lengths).map(|(x, length)| x / length).collect();
        let largest = scaled.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let shown: Vec<usize> = (0..scaled.len()).filter(|&i| scaled[i].abs() >= SHOWN * largest).collect();
        let unit =
            shown.iter().map(|&i| direction[i]).fold(0.0, |a: f64, x| if x.abs() > a.abs() { x } else { a });
        shown.iter().map(|&i| (self.parameters[i].name.clone(), direction[i] / unit)).collect()
    }
}

/// Estimated base parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "Identified")]
pub struct IdentificationResult {
    /// β.
    pub values: DVector<f64>,
    /// Standard deviations of β, if the noise of the torques is independent, and the record states the
    /// ratios of its sizes. Their scale is that of the residual.
    #[doc(alias = "standard errors")]
    pub standard_deviations: DVector<f64>,
    /// The covariance of β.
    pub covariance: DMatrix<f64>,
    /// The root mean square of (τ − W β)/σ, with the noise σ that the record states; without it, of τ − W β
    /// \[N·m or N\].
    pub residual: f64,
    /// The root mean square of τ − W β of each coordinate \[N·m or N\]; NaN if it is not measured.
    pub residuals: Vec<f64>,
    /// The condition number of W_b with columns of unit length; it bounds the amplification of noise.
    pub condition: f64,
    /// The direction that the data determine worst: the names of base parameters and their parts.
    pub weakest: Vec<(String, f64)>,
}

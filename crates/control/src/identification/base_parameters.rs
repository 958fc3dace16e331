//! Base parameters: the combinations β = B π of inertial parameters that determine the torques, and their
//! values.
//!
//! QR factorization of the regressors of random states, by Gram–Schmidt applied twice, from the first link to
//! the last. Parameters that cannot be distinguished go to the link nearer to the base. **(Gautier, Khalil
//! 1990)** Cost: O(states · nv · (10 links)²).
//!
//! A record that does not move every joint determines fewer combinations (`of_record`).

use core::fmt;

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::factorization::singular_values::SingularValues;
use robot_dynamics_core::{Model, Workspace, joint_torque_regressor, random_state};
use robot_dynamics_number::{SplitMix64, check_finite, check_result};

use super::error::check_inertial_parameters;
use super::{IdentificationError, MotionRecord, inertial_parameter_names};

/// A column is dependent if its part independent of the earlier columns is below this fraction of its length.
///
/// Rounding leaves about 1e-14. The smallest independent column of an arm with links of 1 cm and of 1 m is
/// about 1e-4.
const DEPENDENCE: f64 = 1e-9;

/// A base parameter: an inertial parameter with the contributions of others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BaseParameter {
    /// The index in π of the parameter that names it.
    pub index: usize,
    /// Its name, for example `forearm.hx`.
    pub name: String,
    /// (name, coefficient) of the parameters that contribute to it.
    pub others: Vec<(String, f64)>,
}

impl fmt::Display for BaseParameter {
    /// `forearm.hx + 0.5·hand.m`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        for (name, coefficient) in &self.others {
            let sign = if *coefficient < 0.0 { '-' } else { '+' };
            match coefficient.abs() {
                size if (size - 1.0).abs() < 1e-12 => write!(f, " {sign} {name}")?,
                size => write!(f, " {sign} {size:.6}·{name}")?,
            }
        }
        Ok(())
    }
}

/// β = B π: the combinations of the inertial parameters that determine the torques of a robot.
///
/// ```
/// use robot_dynamics::algorithms::inertial_parameters;
/// use robot_dynamics::control::BaseParameters;
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// let model = Model::new(random_robot(1, &RandomRobotOptions::default()))?;
/// let base = BaseParameters::of(&model, 100, 1);
/// let values = base.values(&inertial_parameters(&model))?;
/// println!("{} = {}", base.parameters[0], values[0]);
/// assert!(base.len() < inertial_parameters(&model).len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BaseParameters {
    /// The base parameters.
    pub parameters: Vec<BaseParameter>,
    /// The names of the parameters that affect no torque.
    pub invisible: Vec<String>,
    /// B, base × 10·links, with the identity on the base columns.
    pub combinations: DMatrix<f64>,
}

impl BaseParameters {
    /// The base parameters of a robot, from the regressors of random states without data. The number of
    /// equations, `states` times nv, should exceed 10·links; equal seeds give equal results.
    ///
    /// The method is a QR factorization by Gram–Schmidt orthogonalization, applied twice to every column,
    /// from the first link to the last. Parameters that cannot be distinguished are assigned to the link
    /// nearer to the base, as is customary. **(Gautier, Khalil 1990)**
    pub fn of(model: &Model, states: usize, seed: u64) -> Self {
        let (nv, names) = (model.nv(), inertial_parameter_names(model));
        let mut random = SplitMix64::new(seed);
        let mut workspace = Workspace::new(model);
        let columns = names.len();
        let mut rows = Vec::with_capacity(states * nv * columns);
        let mut regressor = vec![0.0; nv * columns];
        for _ in 0..states {
            let state = random_state(model, &mut random);
            joint_torque_regressor(model, &mut workspace, &state.q, &state.v, &state.a, &mut regressor);
            rows.extend_from_slice(&regressor);
        }
        Self::of_columns(&DMatrix::from_row_slice(states * nv, columns, &rows), &names)
    }

    /// The base parameters of data. There are fewer than for the robot if the motions do not move every
    /// joint.
    pub fn of_record(record: &MotionRecord<'_>) -> Self {
        Self::of_columns(&record.stacked(), &inertial_parameter_names(record.model))
    }

    fn of_columns(w: &DMatrix<f64>, names: &[String]) -> Self {
        let count = names.len();
        let largest = (0..count).map(|j| w.column(j).norm()).fold(0.0, f64::max);
        let (mut chosen, mut basis): (Vec<usize>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
        // Column j of R: the components along the basis.
        let mut components = vec![DVector::<f64>::zeros(count); count];
        let mut invisible = Vec::new();
        for j in 0..count {
            let mut rest = w.column(j).into_owned();
            let length = rest.norm();
            if length <= DEPENDENCE * largest {
                invisible.push(names[j].clone());
                continue;
            }
            for _pass in 0..2 {
                for (k, e) in basis.iter().enumerate() {
                    let component = e.dot(&rest);
                    components[j][k] += component;
                    rest.axpy(-component, e, 1.0);
                }
            }
            let remainder = rest.norm();
            if remainder > DEPENDENCE * length {
                components[j][basis.len()] = remainder;
                basis.push(rest / remainder);
                chosen.push(j);
            }
        }
        // W_j = Σ W_chosen K_j: R K_j = components of j.
        let rank = chosen.len();
        let triangle = DMatrix::from_fn(rank, rank, |i, k| components[chosen[k]][i]);
        let mut combinations = DMatrix::zeros(rank, count);
        for j in 0..count {
            let right = components[j].rows(0, rank).into_owned();
            // The pivots are positive.
            let Some(solved) = triangle.solve_upper_triangular(&right) else { continue };
            // Coefficients within the rounding of the column's length are zero.
            let scale = w.column(j).norm();
            for (i, &k) in chosen.iter().enumerate() {
                let is_rounding = solved[i].abs() * w.column(k).norm() <= DEPENDENCE * scale;
                combinations[(i, j)] = if is_rounding { 0.0 } else { solved[i] };
            }
        }
        let parameter = |(row, &index): (usize, &usize)| {
            let others = (0..count).filter(|&j| j != index && combinations[(row, j)] != 0.0);
            BaseParameter {
                index,
                name: names[index].clone(),
                others: others.map(|j| (names[j].clone(), combinations[(row, j)])).collect(),
            }
        };
        let parameters = chosen.iter().enumerate().map(parameter).collect();
        Self { parameters, invisible, combinations }
    }

    /// The number of base parameters, which is the rank of the regressor.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether there are no base parameters.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// β for given inertial parameters.
    ///
    /// # Errors
    /// [`IdentificationError`] if the list has the wrong length or an entry that is not finite.
    pub fn values(&self, parameters: &[f64]) -> Result<DVector<f64>, IdentificationError> {
        let expected = self.combinations.ncols();
        check_inertial_parameters(parameters, expected)?;
        let values = &self.combinations * DVector::from_column_slice(parameters);
        check_result("β", values.iter())?;
        Ok(values)
    }

    /// Estimates β from data as the least-squares solution of W_b β = τ, by singular values of the columns
    /// scaled to unit length.
    ///
    /// # Errors
    /// [`IdentificationError`] if there are too few data, or if they do not determine a base parameter.
    pub fn identify(&self, record: &MotionRecord<'_>) -> Result<IdentificationResult, IdentificationError> {
        let (equations, unknowns) = (record.torques.len(), self.len());
        let too_few = || {
            let coordinates = record.model.nv();
            IdentificationError::TooFewData { equations, unknowns, coordinates }
        };
        if equations < unknowns || unknowns == 0 {
            return Err(too_few());
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
        if smallest <= DEPENDENCE * largest {
            let rank = singular_values.iter().filter(|x| **x > DEPENDENCE * largest).count();
            let weakest = singular_values.imin();
            let missing = v.column(weakest).iamax();
            return Err(not_excited(rank, missing));
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
        let spread = |i: usize| {
            let sum: f64 = (0..unknowns).map(|k| (v[(i, k)] / singular_values[k]).powi(2)).sum();
            (left.norm_squared() / freedom * sum).sqrt() / lengths[i]
        };
        let values = DVector::from_fn(unknowns, |i, _| scaled[i] / lengths[i]);
        check_result("β", values.iter().chain([&residual]))?;
        Ok(IdentificationResult {
            standard_deviations: DVector::from_fn(unknowns, |i, _| spread(i)),
            values,
            residual,
            condition: largest / smallest,
        })
    }

    /// The inertial parameters with this β that are nearest to `prior`, weighted by the scales of its links,
    /// for use in a model.
    ///
    /// π = π₀ + D Bᵀ(B D Bᵀ)⁻¹(β − B π₀). D has the squares of the prior's parameters, or of the largest in
    /// the same link if a parameter is 0.
    ///
    /// # Errors
    /// [`IdentificationError`] if a list has the wrong length or an entry that is not finite.
    ///
    /// # Panics
    /// Panics if β has the wrong length.
    #[track_caller]
    pub fn nearest_parameters(
        &self,
        values: &DVector<f64>,
        prior: &[f64],
    ) -> Result<DVector<f64>, IdentificationError> {
        assert_eq!(values.len(), self.len(), "{} base values, the robot has {}", values.len(), self.len());
        check_finite("the base values", values.as_slice())?;
        let missing = values - self.values(prior)?;
        let scale = DVector::from_fn(prior.len(), |i, _| {
            let link = &prior
                [i / robot_dynamics_core::PARAMETERS_PER_LINK * robot_dynamics_core::PARAMETERS_PER_LINK..];
            let most =
                link[..robot_dynamics_core::PARAMETERS_PER_LINK].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            let own = if prior[i] == 0.0 { most } else { prior[i].abs() };
            if own > 0.0 { own * own } else { 1.0 }
        });
        let mut weighted = self.combinations.clone();
        for (mut column, scale) in weighted.column_iter_mut().zip(&scale) {
            column *= *scale;
        }
        let gram = &weighted * self.combinations.transpose();
        // B has full row rank and D is positive.
        let solved = gram.cholesky().map_or_else(|| DVector::zeros(missing.len()), |g| g.solve(&missing));
        let nearest = DVector::from_column_slice(prior) + weighted.tr_mul(&solved);
        check_result("the nearest parameters", nearest.iter())?;
        Ok(nearest)
    }
}

/// Estimated base parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "Identified")]
pub struct IdentificationResult {
    /// β.
    pub values: DVector<f64>,
    /// Standard deviations of β, if the noise of all torques is independent and of equal size.
    pub standard_deviations: DVector<f64>,
    /// The root mean square of τ − W β \[N·m or N\].
    pub residual: f64,
    /// The condition number of W_b with columns of unit length; it bounds the amplification of noise.
    pub condition: f64,
}

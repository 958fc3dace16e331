//! Base parameters: which combinations of inertial parameters the torques show, and their values.

use core::fmt;

use dynamics::SplitMix64;
use nalgebra::{DMatrix, DVector};

use super::error::{check_entries, check_results};
use super::{IdentificationError, MotionRecord, inertial_parameter_names};
use crate::factor::singular_values::SingularValues;
use crate::{Model, Workspace, joint_torque_regressor, random_state};

/// A column whose part independent of the columns before it is below this fraction of its length is dependent.
///
/// Rounding leaves about 1e-14; the weakest genuine column of an arm with links of 1 cm and of 1 m is some 1e-4.
const DEPENDENCE: f64 = 1e-9;

/// One base parameter: an inertial parameter with what others add to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BaseParameter {
    /// The index of the parameter it is named after, in π.
    pub index: usize,
    /// Its name, for example `forearm.hx`.
    pub name: String,
    /// (name, coefficient) of the parameters that act through it.
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

/// β = B π: the combinations of the inertial parameters that the torques of a robot show.
///
/// ```
/// use multibody::{BaseParameters, Model, RandomRobotOptions, inertial_parameters, random_robot};
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
    /// The names of parameters that no torque shows.
    pub invisible: Vec<String>,
    /// B, base × 10·links, a unit matrix on the base columns.
    pub combinations: DMatrix<f64>,
}

impl BaseParameters {
    /// Of a robot, from the regressors of random states; no data are needed. `states` states of nv rows each
    /// should exceed 10·links; equal seeds give equal results.
    ///
    /// By QR, Gram–Schmidt run twice on every column, from the first link to the last: what cannot be told
    /// apart is added to the link nearer to the base, as is the custom. **(Gautier, Khalil 1990)**
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

    /// Of the data: what these motions show, which is less where they do not move every joint.
    pub fn of_record(record: &MotionRecord<'_>) -> Self {
        Self::of_columns(&record.stacked(), &inertial_parameter_names(record.model))
    }

    fn of_columns(w: &DMatrix<f64>, names: &[String]) -> Self {
        let count = names.len();
        let largest = (0..count).map(|j| w.column(j).norm()).fold(0.0, f64::max);
        let (mut chosen, mut basis): (Vec<usize>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
        // Column j of R: components along the basis.
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
            // Coefficients that are rounding of the column's length are none.
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

    /// How many there are: the rank of the regressor.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether the torques show nothing at all.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// β of a list of inertial parameters.
    ///
    /// # Errors
    /// [`IdentificationError`]: a list of the wrong length, or with a number that is not finite.
    pub fn values(&self, parameters: &[f64]) -> Result<DVector<f64>, IdentificationError> {
        let expected = self.combinations.ncols();
        if parameters.len() != expected {
            return Err(IdentificationError::WrongLength { found: parameters.len(), expected });
        }
        check_entries("the inertial parameters", parameters)?;
        let values = &self.combinations * DVector::from_column_slice(parameters);
        check_results("β", values.iter())?;
        Ok(values)
    }

    /// β from data: the least-squares solution of W_b β = τ, by singular values with columns scaled to length 1.
    ///
    /// # Errors
    /// [`IdentificationError`]: too few data, or data that leave a base parameter undetermined.
    pub fn identify(&self, record: &MotionRecord<'_>) -> Result<Identified, IdentificationError> {
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
        // W = Q R, R V = U Σ: the singular values of W from a matrix of its few columns.
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
        // σ² (WᵀW)⁻¹ = σ² V Σ⁻² Vᵀ, σ² = |left|²/(equations − unknowns).
        let spread = |i: usize| {
            let sum: f64 = (0..unknowns).map(|k| (v[(i, k)] / singular_values[k]).powi(2)).sum();
            (left.norm_squared() / freedom * sum).sqrt() / lengths[i]
        };
        let values = DVector::from_fn(unknowns, |i, _| scaled[i] / lengths[i]);
        check_results("β", values.iter().chain([&residual]))?;
        Ok(Identified {
            standard_deviations: DVector::from_fn(unknowns, |i, _| spread(i)),
            values,
            residual,
            condition: largest / smallest,
        })
    }

    /// The inertial parameters nearest to `prior`, by links' own scales, whose β is this: what to put into a model.
    ///
    /// π = π₀ + D Bᵀ(B D Bᵀ)⁻¹(β − B π₀) with D the squares of the prior's sizes (or of the largest in their
    /// link where one is 0).
    ///
    /// # Errors
    /// [`IdentificationError`]: a list of the wrong length, or a number that is not finite.
    ///
    /// # Panics
    /// If β has the wrong length.
    #[track_caller]
    pub fn nearest_parameters(
        &self,
        values: &DVector<f64>,
        prior: &[f64],
    ) -> Result<DVector<f64>, IdentificationError> {
        assert_eq!(values.len(), self.len(), "{} base values, the robot has {}", values.len(), self.len());
        check_entries("the base values", values.as_slice())?;
        let missing = values - self.values(prior)?;
        let scale = DVector::from_fn(prior.len(), |i, _| {
            let link = &prior[i / crate::PARAMETERS_PER_LINK * crate::PARAMETERS_PER_LINK..];
            let most = link[..crate::PARAMETERS_PER_LINK].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
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
        check_results("the nearest parameters", nearest.iter())?;
        Ok(nearest)
    }
}

/// What data say about the base parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Identified {
    /// β.
    pub values: DVector<f64>,
    /// Standard deviations of β, if the torques carry independent noise of equal size.
    pub standard_deviations: DVector<f64>,
    /// The root mean square of τ − W β \[N·m or N\].
    pub residual: f64,
    /// The condition number of W_b with columns of length 1: noise grows by at most this.
    pub condition: f64,
}

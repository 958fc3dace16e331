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
use robot_dynamics_core::{Model, PARAMETERS_PER_LINK, Workspace, random_state};
use robot_dynamics_number::{SplitMix64, check_finite, check_result};

use super::error::check_inertial_parameters;
use super::joint_term::{JointTerm, check_terms};
use super::record::write_rows;
use super::{IdentificationError, MotionRecord, parameter_names};

/// A column is dependent if its part independent of the earlier columns is below this fraction of its length.
///
/// Rounding leaves about 1e-14. The smallest independent column of an arm with links of 1 cm and of 1 m is
/// about 1e-4.
pub(super) const DEPENDENCE: f64 = 1e-9;

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
    /// The names of π.
    names: Vec<String>,
}

impl BaseParameters {
    /// The base parameters of a robot, from the regressors of random states without data. The number of
    /// equations, `states` times nv, should exceed 10·links; equal seeds give equal results.
    ///
    /// The method is a QR factorization by Gram–Schmidt orthogonalization, applied twice to every column,
    /// from the first link to the last. Parameters that cannot be distinguished are assigned to the link
    /// nearer to the base, as is customary. **(Gautier, Khalil 1990)**
    pub fn of(model: &Model, states: usize, seed: u64) -> Self {
        Self::of_states(model, &[], states, seed)
    }

    /// The base parameters of a robot whose joint terms are identified as well.
    ///
    /// ```
    /// use robot_dynamics::control::identification::{BaseParameters, JointTerm, JointTermKind};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let terms = JointTerm::of_all(&model, &[JointTermKind::Armature, JointTermKind::Offset]);
    /// let base = BaseParameters::of_with_terms(&model, &terms, 50, 1)?;
    /// let names: Vec<String> = base.parameters.iter().map(ToString::to_string).collect();
    /// // A rotor about a hinge that is fixed in the world acts like the rod's moment of inertia.
    /// assert_eq!(names, ["rod.hx", "rod.hz", "rod.Iyy + hinge.armature", "hinge.offset"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`IdentificationError`] if a joint has several degrees of freedom, or a term occurs twice.
    pub fn of_with_terms(
        model: &Model,
        terms: &[JointTerm],
        states: usize,
        seed: u64,
    ) -> Result<Self, IdentificationError> {
        check_terms(model, terms)?;
        Ok(Self::of_states(model, terms, states, seed))
    }

    fn of_states(model: &Model, terms: &[JointTerm], states: usize, seed: u64) -> Self {
        let (nv, names) = (model.nv(), parameter_names(model, terms));
        let mut random = SplitMix64::new(seed);
        let mut workspace = Workspace::new(model);
        let columns = names.len();
        let mut all = Vec::with_capacity(states * nv * columns);
        let mut rows = vec![0.0; nv * columns];
        for _ in 0..states {
            let state = random_state(model, &mut random);
            write_rows(model, &mut workspace, terms, [&state.q, &state.v, &state.a], &mut rows);
            all.extend_from_slice(&rows);
        }
        Self::of_columns(&DMatrix::from_row_slice(states * nv, columns, &all), &names)
    }

    /// The base parameters of data. There are fewer than for the robot if the motions do not move every
    /// joint.
    pub fn of_record(record: &MotionRecord<'_>) -> Self {
        Self::of_columns(&record.stacked(), &record.parameter_names())
    }

    /// The hidden directions: changes of the parameters that change no torque. Each names a parameter that
    /// grows by 1 and the changes of the others.
    ///
    /// ```
    /// use robot_dynamics::control::BaseParameters;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let hidden = BaseParameters::of(&model, 50, 1).hidden();
    /// assert_eq!(hidden.len(), 7); // ten parameters, of which the torque shows three
    /// assert_eq!(hidden[0].to_string(), "rod.m");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn hidden(&self) -> Vec<BaseParameter> {
        let is_base = |j: &usize| !self.parameters.iter().any(|parameter| parameter.index == *j);
        let direction = |j: usize| {
            let shown = self.parameters.iter().enumerate();
            let shown = shown.filter(|(row, _)| self.combinations[(*row, j)] != 0.0);
            BaseParameter {
                index: j,
                name: self.names[j].clone(),
                others: shown.map(|(row, own)| (own.name.clone(), -self.combinations[(row, j)])).collect(),
            }
        };
        (0..self.names.len()).filter(is_base).map(direction).collect()
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
        Self { parameters, invisible, combinations, names: names.to_vec() }
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
            // A joint's term has no nine others that state the scale.
            let link = &prior[i / PARAMETERS_PER_LINK * PARAMETERS_PER_LINK..];
            let most = link.iter().take(PARAMETERS_PER_LINK).fold(0.0, |a: f64, x| a.max(x.abs()));
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

//! Identification of parameters that belong to bodies, near nominal ones.
//!
//! minimize ½ |W x − τ|² + γ Σ D(x ‖ x₀)
//!
//! with rows in units of the noise and D the entropic divergence of each link's pseudo-inertia. D is convex
//! and grows without bound towards the boundary of the possible bodies. So damped Newton steps from the
//! nominal parameters stay inside, and no conic solver is needed. Damping, friction and armature have
//! D = x/x₀ − ln(x/x₀) − 1 and stay positive. Offsets have ½ ((x − x₀)/s)².
//!
//! The objective over γ is self-concordant. A step is the least-squares solution of [R; √γ S] d =
//! [z − R y; −√γ u] with the triangle R of W and the map S of `entropic`; the Hessian is never formed. γ
//! falls by tens from a value at which the data and D weigh the same.
//!
//! Cost: O(rows · x²) once and O(x³) a step; about thirty steps.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{
    Model, PARAMETERS_PER_LINK, PASSIVE_PARAMETERS_PER_JOINT, parameter_values, with_parameters,
};
use robot_dynamics_description::{ModelError, RobotDescription};
use robot_dynamics_number::{InvalidInput, check_finite, check_result};

use super::consistent_options::ConsistentOptions;
use super::entropic::Block;
use super::{IdentificationError, JointTerm, JointTermKind, MotionRecord};

/// The most Newton steps of one value of γ. Ten suffice, unless least squares fits best with impossible
/// bodies: then hidden combinations move far, and a step decreases the objective by little more than 0.3 γ.
const MOST_STEPS: usize = 2000;

/// The squared Newton decrement over γ below which one more step is exact to 1e-12.
const CONVERGED: f64 = 1e-12;

/// Estimated parameters that belong to bodies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConsistentEstimate {
    /// x: the inertial parameters, then the joint terms.
    pub parameters: Vec<f64>,
    /// The standard deviations of x due to the noise. They do not include the distance by which the
    /// regularization moves the mean of x.
    #[doc(alias = "standard errors")]
    pub standard_deviations: Vec<f64>,
    /// The covariance of x due to the noise.
    pub covariance: DMatrix<f64>,
    /// The root mean square of (τ − W x)/σ, with the noise σ that the record states; without it, of τ − W x
    /// \[N·m or N\].
    pub residual: f64,
    /// The root mean square of τ − W x of each coordinate \[N·m or N\]; NaN if it is not measured.
    pub residuals: Vec<f64>,
    /// The divergence of each moving link from its nominal parameters; 0 for held links.
    pub divergences: Vec<f64>,
    /// The number of parameters that the data determine: the trace of the derivative of W x by τ.
    pub effective_parameters: f64,
    /// The number of Newton steps.
    pub steps: usize,
    terms: Vec<JointTerm>,
}

impl ConsistentEstimate {
    /// The robot with these parameters. Offsets and Stribeck friction are not part of a robot.
    ///
    /// # Errors
    /// [`ModelError`] if a link or joint cannot have them, for example a link that is fixed to another and
    /// compensates gravity differently.
    pub fn description(&self, model: &Model) -> Result<RobotDescription, ModelError> {
        let mut values = parameter_values(model);
        let inertial = self.parameters.len() - self.terms.len();
        values[..inertial].copy_from_slice(&self.parameters[..inertial]);
        for (term, value) in self.terms.iter().zip(&self.parameters[inertial..]) {
            let joint = model.moving_joints().position(|joint| joint.index == term.joint);
            let place = match term.kind {
                JointTermKind::Armature => 0,
                JointTermKind::Damping => 1,
                JointTermKind::Friction => 2,
                JointTermKind::Offset | JointTermKind::Stribeck { .. } => continue,
            };
            if let Some(joint) = joint {
                values[inertial + PASSIVE_PARAMETERS_PER_JOINT * joint + place] = *value;
            }
        }
        with_parameters(model, &values)
    }
}

/// Estimates physically consistent parameters: every link is a possible body, and damping, friction and
/// armature are positive.
///
/// Small γ approaches least squares in the combinations that the data show, as far as bodies with them
/// exist. The hidden combinations stay near the nominal parameters. Links whose nominal parameters are all
/// zero keep them. Source: Lee, Wensing, Park, *Geometric robot dynamic identification: a convex programming
/// approach*, IEEE T-RO 36 (2020).
///
/// ```
/// use robot_dynamics::control::identification::{ConsistentOptions, MotionRecord, identify_consistent};
/// use robot_dynamics::description::{MassProperties, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.links[1].mass_properties = MassProperties::new(2.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity() * 0.01)?.into();
/// let model = Model::new(robot)?;
/// let mut record = MotionRecord::new(&model, false).with_noise(&[0.01])?;
/// for i in 0..50 {
///     let t = 0.1 * f64::from(i);
///     let (q, v, a) = (t.sin(), t.cos(), -t.sin());
///     let tau = model.inverse_dynamics(&[q], &[v], &[a])?[0];
///     record.push(&[q], &[v], &[a], &[1.2 * tau])?; // the real rod is a fifth heavier
/// }
/// let found = identify_consistent(&record, &ConsistentOptions::new(1e-3))?;
/// assert!((found.parameters[1] - 1.2).abs() < 1e-3); // m c_x: 1.2 times 2 kg · 0.5 m
/// let real = Model::new(found.description(&model)?)?;
/// assert!((real.links()[1].mass() - 2.4).abs() < 0.1); // the torque does not show it; D prefers equal shapes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentificationError`] if the record is empty, an option is invalid, a nominal body is flat, or Newton's
/// method does not converge.
pub fn identify_consistent(
    record: &MotionRecord<'_>,
    options: &ConsistentOptions,
) -> Result<ConsistentEstimate, IdentificationError> {
    Ok(solve(record, options)?.estimate)
}

/// The solution of the convex problem.
pub(super) struct Solution {
    pub(super) estimate: ConsistentEstimate,
    /// The value of the objective.
    pub(super) value: f64,
    /// T of x = origin + T y.
    map: DMatrix<f64>,
    /// U with the Hessian UᵀU by y.
    upper: DMatrix<f64>,
}

impl Solution {
    /// U⁻ᵀTᵀ b for columns b of derivatives by x. The inner products of the results are bᵀH⁻¹b.
    pub(super) fn project(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let right = self.map.tr_mul(columns);
        self.upper.tr_solve_upper_triangular(&right).unwrap_or(right)
    }
}

/// Solves the convex problem of [`identify_consistent`].
pub(super) fn solve(
    record: &MotionRecord<'_>,
    options: &ConsistentOptions,
) -> Result<Solution, IdentificationError> {
    options.check(record)?;
    let nominal = options.nominal_of(record);
    check_finite("the nominal parameters", &nominal)?;
    let blocks = options.blocks(record, &nominal)?;
    let unknowns: usize = blocks.iter().map(Block::len).sum();
    if record.torques.is_empty() || unknowns == 0 {
        let coordinates = record.model.nv();
        return Err(IdentificationError::TooFewData { equations: 0, unknowns, coordinates });
    }
    // x = origin + T y.
    let mut origin = DVector::from_vec(nominal);
    let mut map = DMatrix::zeros(origin.len(), unknowns);
    let mut start = Vec::with_capacity(unknowns);
    for block in &blocks {
        for k in 0..block.len() {
            map.view_mut((block.first(), start.len() + k), (block.len(), 1))
                .copy_from_slice(&block.column(k));
            origin[block.first() + k] = block.origin();
        }
        start.extend(block.start());
    }
    let matrix = record.stacked();
    let torques = DVector::from_column_slice(&record.torques);
    let right = &torques - &matrix * &origin;
    let problem = Problem::new(blocks, &(&matrix * &map), &right);
    let (y, steps) = problem.minimize(DVector::from_vec(start), options.regularization)?;
    let parameters = &origin + &map * &y;
    let left = torques - matrix * &parameters;
    check_result("the estimated parameters", parameters.iter().chain(left.iter()))?;
    let Spread { upper, spread, effective } = problem.spread(&y, options.regularization);
    let freedom = (left.len() as f64 - effective).max(1.0);
    let spread = &map * spread * (left.norm_squared() / freedom).sqrt();
    let mut divergences = vec![0.0; record.links()];
    let mut sum = 0.0;
    for (block, own) in problem.parts(&y) {
        sum += block.divergence(own);
        if let Block::Link { first, .. } = block {
            divergences[first / PARAMETERS_PER_LINK] = block.divergence(own);
        }
    }
    let value = 0.5 * left.norm_squared() + options.regularization * sum;
    let estimate = ConsistentEstimate {
        parameters: parameters.as_slice().to_vec(),
        standard_deviations: spread.row_iter().map(|row| row.norm()).collect(),
        covariance: &spread * spread.transpose(),
        residual: left.norm() / (left.len() as f64).sqrt(),
        residuals: record.residuals_of(&left),
        divergences,
        effective_parameters: effective,
        steps,
        terms: record.terms().to_vec(),
    };
    Ok(Solution { estimate, value, map, upper })
}

/// ½ |R y − z|² + γ Σ D(y).
struct Problem {
    blocks: Vec<Block>,
    triangle: DMatrix<f64>,
    right: DVector<f64>,
}

impl Problem {
    /// The problem of W y = τ: its triangle has at most as many rows as unknowns.
    fn new(blocks: Vec<Block>, matrix: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        let factor = matrix.clone().qr();
        Self { blocks, right: factor.q().tr_mul(right), triangle: factor.r() }
    }

    /// The blocks with their parts of y.
    fn parts<'y>(&'y self, y: &'y DVector<f64>) -> impl Iterator<Item = (&'y Block, &'y [f64])> {
        let mut first = 0;
        self.blocks.iter().map(move |block| {
            let own = &y.as_slice()[first..first + block.len()];
            first += block.len();
            (block, own)
        })
    }

    fn value(&self, y: &DVector<f64>, weight: f64) -> f64 {
        let divergence: f64 = self.parts(y).map(|(block, own)| block.divergence(own)).sum();
        0.5 * (&self.triangle * y - &self.right).norm_squared() + weight * divergence
    }

    /// [R; √γ S] and [z − R y; −√γ u].
    fn linearized(&self, y: &DVector<f64>, weight: f64) -> (DMatrix<f64>, DVector<f64>) {
        let (rows, n) = (self.triangle.nrows(), y.len());
        let (mut matrix, mut right) = (DMatrix::zeros(rows + n, n), DVector::zeros(rows + n));
        matrix.rows_mut(0, rows).copy_from(&self.triangle);
        right.rows_mut(0, rows).copy_from(&(&self.right - &self.triangle * y));
        let mut first = 0;
        for (block, own) in self.parts(y) {
            let (map, u) = block.derivatives(own);
            for i in 0..block.len() {
                for k in 0..block.len() {
                    matrix[(rows + first + i, first + k)] = weight.sqrt() * map[i * block.len() + k];
                }
                right[rows + first + i] = -weight.sqrt() * u[i];
            }
            first += block.len();
        }
        (matrix, right)
    }

    /// Newton's method for falling γ. Returns y and the number of steps.
    fn minimize(
        &self,
        mut y: DVector<f64>,
        weight: f64,
    ) -> Result<(DVector<f64>, usize), IdentificationError> {
        let balanced = self.triangle.norm_squared() / y.len() as f64;
        let mut current = balanced.max(weight);
        let mut steps = 0;
        loop {
            let is_last = current <= weight;
            let converged = if is_last { CONVERGED } else { 1e-2 };
            let mut decrement = f64::INFINITY;
            for _step in 0..MOST_STEPS {
                decrement = self.step(&mut y, current)?;
                steps += 1;
                if decrement <= converged {
                    break;
                }
            }
            if decrement > converged {
                return Err(IdentificationError::NotConverged { steps });
            }
            if is_last {
                return Ok((y, steps));
            }
            current = (current / 10.0).max(weight);
        }
    }

    /// One damped Newton step; returns the squared decrement over γ before it.
    fn step(&self, y: &mut DVector<f64>, weight: f64) -> Result<f64, IdentificationError> {
        let (matrix, right) = self.linearized(y, weight);
        let factor = matrix.clone().qr();
        let overflow = || InvalidInput::unmet("the Newton step", "must be finite");
        let direction = factor.r().solve_upper_triangular(&factor.q().tr_mul(&right)).ok_or_else(overflow)?;
        let squared = (matrix * &direction).norm_squared();
        check_result("the Newton step", [&squared])?;
        let decrement = squared / weight;
        let before = self.value(y, weight);
        // At this fraction a self-concordant function is finite and decreases.
        let least = 1.0 / (1.0 + decrement.sqrt());
        let mut fraction = 1.0;
        loop {
            let next = &*y + &direction * fraction;
            let after = self.value(&next, weight);
            let is_close = decrement < 0.05 && after.is_finite();
            if is_close || after <= before - 1e-4 * fraction * squared || fraction <= least {
                *y = if is_close { next } else { self.extended(y, &direction, fraction, weight) };
                return Ok(decrement);
            }
            fraction = (0.5 * fraction).max(least);
        }
    }

    /// The best of the points y + 2ᵏ t d. Hidden combinations may move far, and a Newton step of a logarithm
    /// only doubles a distance.
    fn extended(&self, y: &DVector<f64>, direction: &DVector<f64>, mut t: f64, weight: f64) -> DVector<f64> {
        let mut best = y + direction * t;
        let mut least = self.value(&best, weight);
        loop {
            t *= 2.0;
            let next = y + direction * t;
            let value = self.value(&next, weight);
            if value.is_nan() || value >= least {
                return best;
            }
            (best, least) = (next, value);
        }
    }

    fn spread(&self, y: &DVector<f64>, weight: f64) -> Spread {
        let upper = self.linearized(y, weight).0.qr().r();
        let transposed = self.triangle.transpose();
        let half = upper.tr_solve_upper_triangular(&transposed).unwrap_or_else(|| transposed.clone());
        let effective = half.norm_squared();
        Spread { spread: upper.solve_upper_triangular(&half).unwrap_or(half), upper, effective }
    }
}

/// How the noise spreads y.
struct Spread {
    /// U with the Hessian H = UᵀU.
    upper: DMatrix<f64>,
    /// M = H⁻¹Rᵀ, with which the covariance is σ² M Mᵀ.
    spread: DMatrix<f64>,
    /// The trace of R M.
    effective: f64,
}

//! An independent solver of rigid contact: the alternating direction method of multipliers (ADMM) on the
//! complementarity problem.
//!
//! The problem is to find p in K with c + s ∈ K*, p ⟂ c + s. For each contact c = G p + g and s = (μ|c_t|, 0,
//! 0) (De Saxcé & Feng 1998). For constant s, p minimizes ½pᵀGp + (g + s)ᵀp over K. The method splits p into
//! λ, which minimizes the quadratic function, and z, which lies in K, with the multiplier y for λ = z:
//!
//! ```text
//! λ ← (G + (η + ρ)1)⁻¹(ηλ + ρz − y − g − s),  z ← Π_K(λ + y/ρ),  y ← y + ρ(λ − z),
//! ```
//!
//! and s follows from c = −y − s. η is a proximal term, which makes the matrix invertible for redundant
//! contacts. ρ is adjusted to balance λ − z and the change of z; the source adjusts it by a spectral rule.
//! **(Carpentier, Le Lidec & Montaut, "From Compliant to Rigid Contact Simulation", RSS 2024)**
//!
//! The method and the Newton method of the library's steps have only the problem in common. It uses no
//! Hessian, no penalty and no line search, and its matrices are dense.
//!
//! ```
//! use nalgebra::{DMatrix, dvector};
//! use robot_dynamics::contact::{ContactLaw, ContactProblem};
//! use robot_dynamics::verification::admm;
//! // A point of 1 kg with velocity 1 m/s downwards and 3 m/s sideways, μ = 0.5: 1 N·s stops its fall, with
//! // 0.5 N·s of friction.
//! let laws = vec![ContactLaw::Contact { friction: 0.5, rows: 3 }];
//! let problem = ContactProblem::new(DMatrix::identity(3, 3), dvector![-1.0, 3.0, 0.0], laws);
//! let solution = admm::solve(&problem, &admm::Options::default());
//! assert!(solution.is_settled && (solution.velocity - dvector![0.0, 2.5, 0.0]).norm() < 1e-9);
//! ```

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use robot_dynamics_simulation::{ContactLaw, ContactProblem, ContactViolation};

/// The criteria for stopping.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Options {
    /// The allowed violation of the contact laws, relative to the largest speed in the problem.
    pub tolerance: f64,
    /// The limit of iterations.
    pub rounds: usize,
}

impl Default for Options {
    /// 10⁻¹⁰ in 20 000 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-10, rounds: 20_000 }
    }
}

/// The solution and its accuracy.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solution {
    /// p \[N·s\].
    pub impulse: DVector<f64>,
    /// c = G p + g \[m/s\].
    pub velocity: DVector<f64>,
    /// The violation of the contact laws.
    pub violation: ContactViolation,
    /// The number of iterations.
    pub rounds: usize,
    /// Whether the violation is within the tolerance.
    pub is_settled: bool,
}

/// η, for rows that are scaled to a diagonal of G of about 1.
const PROXIMAL: f64 = 1e-6;
/// The number of iterations between checks of the laws and adjustments of ρ.
const LOOK: usize = 10;
/// The ratio of residuals above which ρ is adjusted, and the largest factor of one adjustment.
const BALANCE: f64 = 3.0;
const MOST_MOVE: f64 = 10.0;

/// Solves the problem. See the [module](self).
///
/// ```
/// use nalgebra::{dmatrix, dvector};
/// use robot_dynamics::contact::{ContactLaw, ContactProblem};
/// use robot_dynamics::verification::admm;
/// let laws = vec![ContactLaw::Contact { friction: 0.0, rows: 1 }];
/// let rises = admm::solve(&ContactProblem::new(dmatrix![2.0], dvector![0.5], laws), &admm::Options::default());
/// assert_eq!((rises.impulse[0], rises.velocity[0]), (0.0, 0.5)); // the ground does not pull a point that separates
/// ```
pub fn solve(problem: &ContactProblem, options: &Options) -> Solution {
    let scale = scales(problem);
    let n = scale.len();
    let g = problem.free_velocity.component_mul(&scale);
    let matrix = DMatrix::from_fn(n, n, |i, j| scale[i] * problem.delassus[(i, j)] * scale[j]);
    let fastest = |velocity: &DVector<f64>| velocity.amax().max(problem.free_velocity.amax());
    let solution = |z: &DVector<f64>, rounds: usize| {
        let impulse = z.component_mul(&scale);
        let velocity = &problem.delassus * &impulse + &problem.free_velocity;
        let violation = problem.violation(&impulse);
        let is_settled = violation.worst() <= options.tolerance * fastest(&velocity).max(f64::MIN_POSITIVE);
        Solution { impulse, velocity, violation, rounds, is_settled }
    };
    let mut rho = 1.0;
    let Some(mut factor) = factored(&matrix, rho) else { return solution(&DVector::zeros(n), 0) };
    let (mut lambda, mut z, mut y) = (DVector::zeros(n), DVector::zeros(n), DVector::zeros(n));
    let mut shift = DVector::zeros(n);
    for round in 1..=options.rounds {
        let right = &lambda * PROXIMAL + &z * rho - &y - &g - &shift;
        let (next, before) = (factor.solve(&right), z.clone());
        let forward = (&next - &lambda).amax() * PROXIMAL;
        lambda = next;
        z = &lambda + &y / rho;
        project_all(&problem.laws, &scale, &mut z);
        y += (&lambda - &z) * rho;
        set_shifts(&problem.laws, &y, &mut shift);
        if round % LOOK == 0 {
            let found = solution(&z, round);
            if found.is_settled {
                return found;
            }
            let apart = (&lambda - &z).amax();
            let moved = ((&z - &before).amax() * rho).max(forward);
            let ratio = (apart / moved.max(f64::MIN_POSITIVE)).clamp(1.0 / MOST_MOVE, MOST_MOVE);
            if !(1.0 / BALANCE..=BALANCE).contains(&ratio) {
                rho = (rho * ratio.sqrt()).clamp(1e-8, 1e8);
                let Some(next) = factored(&matrix, rho) else { return found };
                factor = next;
            }
        }
    }
    solution(&z, options.rounds)
}

/// One factor for each block, which preserves its cone.
fn scales(problem: &ContactProblem) -> DVector<f64> {
    let mut scale = DVector::from_element(problem.free_velocity.len(), 1.0);
    let mut row = 0;
    for law in &problem.laws {
        let rows = row..row + law.rows();
        let mean = rows.clone().map(|k| problem.delassus[(k, k)]).sum::<f64>() / law.rows() as f64;
        if mean > 0.0 {
            rows.for_each(|k| scale[k] = mean.sqrt().recip());
        }
        row += law.rows();
    }
    scale
}

fn factored(matrix: &DMatrix<f64>, rho: f64) -> Option<Cholesky<f64, Dyn>> {
    let mut sum = matrix.clone();
    (0..sum.nrows()).for_each(|k| sum[(k, k)] += PROXIMAL + rho);
    Cholesky::new(sum)
}

/// Π_K, block by block.
fn project_all(laws: &[ContactLaw], scale: &DVector<f64>, z: &mut DVector<f64>) {
    let mut row = 0;
    for law in laws {
        match *law {
            ContactLaw::Bounds { lower, upper } => {
                z[row] = z[row].max(lower / scale[row]).min(upper / scale[row]);
            }
            ContactLaw::Contact { friction, rows } => {
                let side = z.rows(row + 1, rows - 1).norm();
                if friction * side <= -z[row] {
                    z.rows_mut(row, rows).fill(0.0);
                } else if side > friction * z[row] {
                    // The nearest point on the surface of the cone.
                    let normal = (z[row] + friction * side) / (1.0 + friction * friction);
                    if side > 0.0 {
                        z.rows_mut(row + 1, rows - 1).scale_mut(friction * normal / side);
                    }
                    z[row] = normal;
                }
            }
        }
        row += law.rows();
    }
}

/// s = μ|c_t|, with c_t = −y_t.
fn set_shifts(laws: &[ContactLaw], y: &DVector<f64>, shift: &mut DVector<f64>) {
    let mut row = 0;
    for law in laws {
        if let ContactLaw::Contact { friction, rows } = *law {
            shift[row] = friction * y.rows(row + 1, rows - 1).norm();
        }
        row += law.rows();
    }
}

//! Linear systems with interval coefficients, and forward dynamics by them.

use core::fmt;
use std::error::Error;

use nalgebra::DMatrix;
use robot_dynamics_core::{Model, Workspace, bias, mass_matrix};
use robot_dynamics_number::{Classified, ErrorKind};

use crate::Interval;

/// No enclosure was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum EnclosureError {
    /// The matrix in the middle is singular, or a coefficient is unbounded.
    Singular,
    /// A quaternion is not a single number, or the task needs coordinates without quaternions.
    Quaternions,
    /// An interval is unbounded.
    Unbounded,
    /// The intervals are too wide: ‖1 − R M‖ is this number, which must be below 1.
    TooWide {
        /// The norm.
        norm: f64,
    },
}

impl fmt::Display for EnclosureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular => f.write_str("the matrix in the middle of the intervals is singular or unbounded"),
            Self::Quaternions => f.write_str(
                "a box of quaternions contains numbers that are no rotation: hold their joints (--lock, lock_joint)",
            ),
            Self::Unbounded => f.write_str("an interval is unbounded: give finite bounds"),
            Self::TooWide { norm } => write!(
                f,
                "the intervals are too wide: the norm of 1 − R M is {norm:.3}, and must be below 1; divide the box"
            ),
        }
    }
}

impl Error for EnclosureError {}

impl Classified for EnclosureError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Singular => ErrorKind::Singular,
            Self::Quaternions => ErrorKind::Unsupported,
            Self::Unbounded => ErrorKind::InvalidInput,
            Self::TooWide { .. } => ErrorKind::NotConverged,
        }
    }
}

/// An interval of angles of a little more than one turn in place of a wider one, which has the same
/// rotations.
pub(crate) fn one_turn(angles: Interval) -> Interval {
    const FULL_TURN: f64 = 6.3;
    if angles.width() <= FULL_TURN {
        return angles;
    }
    let least = if angles.lower().is_finite() { angles.lower() } else { -0.5 * FULL_TURN };
    Interval::new(least, least + FULL_TURN)
}

/// Refuses unbounded boxes, and quaternions that are not single numbers.
pub(crate) fn check_box(model: &Model, q: &[Interval]) -> Result<(), EnclosureError> {
    assert_eq!(q.len(), model.nq(), "q has {} entries, but {} are needed", q.len(), model.nq());
    if q.iter().any(|x| !x.is_bounded()) {
        return Err(EnclosureError::Unbounded);
    }
    let quaternions = model.joints().iter().filter(|joint| joint.nq > joint.nv);
    let is_box = |x: &Interval| x.lower() < x.upper();
    let mut numbers = quaternions.flat_map(|joint| &q[joint.q()][joint.nq - 4..]);
    if numbers.any(is_box) { Err(EnclosureError::Quaternions) } else { Ok(()) }
}

/// An enclosure of all solutions of M x = b, for every M and b in the intervals; M is n × n, row by row.
///
/// With R near the inverse of the middle of M, x̃ = R b and e = x − x̃ obeys e = R (b − M x̃) + (1 − R M) e. If
/// ‖1 − R M‖ = c < 1 in the largest sum of a row, every M is regular and |eᵢ| ≤ ‖R (b − M x̃)‖/(1 − c).
/// Source: Rump, *Verification methods*, Acta Numerica 19 (2010), §10.
///
/// ```
/// use robot_dynamics_certified::{Interval, solve};
/// let matrix = [2.0, 1.0, 1.0, 3.0].map(|x| Interval::around(x, 1e-3));
/// let x = solve(&matrix, &[3.0.into(), 4.0.into()])?;
/// assert!(x.iter().all(|x| x.contains(1.0) && x.width() < 1e-2));
/// assert!(solve(&[Interval::new(-1.0, 1.0)], &[1.0.into()]).is_err());
/// # Ok::<(), robot_dynamics_certified::EnclosureError>(())
/// ```
///
/// # Errors
/// [`EnclosureError`] if the middle of M is singular, or the intervals are too wide.
///
/// # Panics
/// If M does not have n² entries.
pub fn solve(matrix: &[Interval], right: &[Interval]) -> Result<Vec<Interval>, EnclosureError> {
    LinearSystem::new(matrix, right.len())?.solve(right)
}

/// An interval matrix M whose regularity is proven, for several right sides.
pub(crate) struct LinearSystem<'a> {
    matrix: &'a [Interval],
    /// R.
    inverse: DMatrix<f64>,
    /// ‖1 − R M‖.
    norm: f64,
}

impl<'a> LinearSystem<'a> {
    pub(crate) fn new(matrix: &'a [Interval], n: usize) -> Result<Self, EnclosureError> {
        assert_eq!(matrix.len(), n * n, "the matrix has {} entries, but {n}² are needed", matrix.len());
        if matrix.iter().any(|x| !x.is_bounded()) {
            return Err(EnclosureError::Singular);
        }
        let middle = DMatrix::from_fn(n, n, |i, j| matrix[i * n + j].middle());
        let inverse = middle.try_inverse().ok_or(EnclosureError::Singular)?;
        let mut norm = 0.0_f64;
        for i in 0..n {
            let mut row = Interval::from(0.0);
            for j in 0..n {
                let mut entry = Interval::from(if i == j { 1.0 } else { 0.0 });
                for k in 0..n {
                    entry -= Interval::from(inverse[(i, k)]) * matrix[k * n + j];
                }
                row += Interval::from(entry.magnitude());
            }
            norm = norm.max(row.upper());
        }
        let is_contracting = norm < 1.0;
        if is_contracting {
            Ok(Self { matrix, inverse, norm })
        } else {
            Err(EnclosureError::TooWide { norm })
        }
    }

    /// See [`solve`].
    pub(crate) fn solve(&self, right: &[Interval]) -> Result<Vec<Interval>, EnclosureError> {
        let Self { matrix, inverse, norm } = self;
        let n = right.len();
        if right.iter().any(|x| !x.is_bounded()) {
            return Err(EnclosureError::Singular);
        }
        let start: Vec<f64> =
            (0..n).map(|i| (0..n).map(|j| inverse[(i, j)] * right[j].middle()).sum()).collect();
        if start.iter().any(|x| !x.is_finite()) {
            return Err(EnclosureError::Singular);
        }
        let residual: Vec<Interval> = (0..n)
            .map(|i| (0..n).fold(right[i], |sum, j| sum - matrix[i * n + j] * Interval::from(start[j])))
            .collect();
        let mut largest = 0.0_f64;
        let moved: Vec<Interval> = (0..n)
            .map(|i| {
                let zero = Interval::from(0.0);
                (0..n).fold(zero, |sum, j| sum + Interval::from(inverse[(i, j)]) * residual[j])
            })
            .inspect(|x| largest = largest.max(x.magnitude()))
            .collect();
        // e = R (b − M x̃) + (1 − R M) e, and |e| ≤ ‖R (b − M x̃)‖/(1 − c).
        let rest = Interval::from(largest) / (Interval::from(1.0) - Interval::from(*norm));
        let rest = Interval::from(*norm) * Interval::new(0.0, rest.upper());
        let rest = Interval::new(-rest.upper(), rest.upper());
        Ok((0..n).map(|i| Interval::from(start[i]) + moved[i] + rest).collect())
    }
}

/// Whether every symmetric matrix in an interval matrix is proven to be positive definite; n × n, row by row.
/// Only the lower triangle is read.
///
/// The pivots of M = L D Lᵀ are computed in intervals; all are positive if their lower bounds are.
///
/// ```
/// use robot_dynamics_certified::{Interval, is_positive_definite};
/// let matrix = |width| [2.0, 1.0, 1.0, 3.0].map(|x| Interval::around(x, width));
/// assert!(is_positive_definite(&matrix(0.1), 2) && !is_positive_definite(&matrix(1.0), 2));
/// ```
///
/// # Panics
/// If the matrix does not have n² entries.
pub fn is_positive_definite(matrix: &[Interval], n: usize) -> bool {
    assert_eq!(matrix.len(), n * n, "the matrix has {} entries, but {n}² are needed", matrix.len());
    let mut rest = matrix.to_vec();
    for k in 0..n {
        let pivot = rest[k * n + k];
        let is_positive = pivot.lower() > 0.0 && pivot.is_bounded();
        if !is_positive {
            return false;
        }
        for i in k + 1..n {
            let factor = rest[i * n + k] / pivot;
            for j in k + 1..=i {
                let change = if i == j {
                    // A square is not negative.
                    let square = rest[i * n + k] * rest[i * n + k];
                    Interval::new(square.lower().max(0.0), square.upper()) / pivot
                } else {
                    factor * rest[j * n + k]
                };
                rest[i * n + j] -= change;
            }
        }
    }
    true
}

/// An enclosure of a = M(q)⁻¹(τ − C v − g) for all q, v and τ in the intervals. Quaternions are single
/// numbers: a box of them contains numbers that are no rotation.
///
/// ```
/// use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{Interval, forward_dynamics};
/// let options = RandomRobotOptions { joints: 5, kinds: JointKinds::Turning, ..Default::default() };
/// let model = Model::new(random_robot(3, &options))?;
/// let (q, v) = (vec![Interval::from(0.3); model.nq()], vec![Interval::from(0.1); model.nv()]);
/// let a = forward_dynamics(&model, &q, &v, &v)?;
/// let point = model.forward_dynamics(&vec![0.3; model.nq()], &vec![0.1; model.nv()], &vec![0.1; model.nv()])?;
/// assert!(a.iter().zip(&point).all(|(a, point)| a.contains(*point) && a.width() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EnclosureError`] if M in the middle of the box is singular, or the box is too wide.
///
/// # Panics
/// If an argument has the wrong length.
pub fn forward_dynamics(
    model: &Model,
    q: &[Interval],
    v: &[Interval],
    tau: &[Interval],
) -> Result<Vec<Interval>, EnclosureError> {
    check_box(model, q)?;
    let nv = model.nv();
    let mut workspace = Workspace::new(model);
    let mut mass = vec![Interval::from(0.0); nv * nv];
    let mut right = vec![Interval::from(0.0); nv];
    mass_matrix(model, &mut workspace, q, &mut mass);
    bias(model, &mut workspace, q, v, &mut right);
    assert_eq!(tau.len(), nv, "tau has {} entries, but {nv} are needed", tau.len());
    for (right, tau) in right.iter_mut().zip(tau) {
        *right = *tau - *right;
    }
    solve(&mass, &right)
}

//! The entropic divergence from nominal parameters, in coordinates in which the nominal body is the identity.
//!
//! With J₀ = L Lᵀ and J = L X Lᵀ, D(J ‖ J₀) = tr X − ln det X − 4. The coordinates y of a link are the ten
//! entries of X, those off the diagonal times √2, so that |y| is the Frobenius norm of X. With X = C Cᵀ, the
//! linear map E ↦ C⁻¹ E C⁻ᵀ has a matrix S in these coordinates, and u = entries of CᵀC − 1:
//!
//! ∇D = Sᵀu, ∇²D = SᵀS.
//!
//! A positive number x = x₀ y has D = y − ln y − 1, which is the same with 1×1 matrices. An offset
//! x = x₀ + s y has D = ½ y².

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector};
use robot_dynamics_core::PARAMETERS_PER_LINK;

use super::pseudo_inertia;

type Entries = SVector<f64, PARAMETERS_PER_LINK>;

/// The rows and columns of the ten entries.
const PLACES: [(usize, usize); PARAMETERS_PER_LINK] =
    [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The coordinates of a symmetric matrix.
fn entries(matrix: &Matrix4<f64>) -> Entries {
    let weight = |(i, j): (usize, usize)| if i == j { 1.0 } else { core::f64::consts::SQRT_2 };
    Entries::from_fn(|k, _| weight(PLACES[k]) * matrix[PLACES[k]])
}

/// The symmetric matrix of coordinates.
fn symmetric(entries: &[f64]) -> Matrix4<f64> {
    let mut matrix = Matrix4::zeros();
    for (&(i, j), &entry) in PLACES.iter().zip(entries) {
        let value = if i == j { entry } else { entry / core::f64::consts::SQRT_2 };
        (matrix[(i, j)], matrix[(j, i)]) = (value, value);
    }
    matrix
}

/// The ten parameters of a pseudo-inertia: the inverse of [`pseudo_inertia`].
pub(super) fn parameters_of(pseudo: &Matrix4<f64>) -> [f64; PARAMETERS_PER_LINK] {
    let second = pseudo.fixed_view::<3, 3>(0, 0);
    let inertia = Matrix3::identity() * second.trace() - second;
    let [hx, hy, hz] = [0, 1, 2].map(|i| pseudo[(i, 3)]);
    let at = |i, j| inertia[(i, j)];
    [pseudo[(3, 3)], hx, hy, hz, at(0, 0), at(0, 1), at(1, 1), at(0, 2), at(1, 2), at(2, 2)]
}

/// A group of parameters with one divergence.
#[derive(Clone, Debug)]
pub(super) enum Block {
    /// A link: the first of its ten parameters, and L.
    Link { first: usize, factor: Matrix4<f64> },
    /// A positive number with its nominal value.
    Positive { index: usize, nominal: f64 },
    /// A number of any sign with its nominal value and deviation.
    Offset { index: usize, nominal: f64, deviation: f64 },
}

impl Block {
    /// A link with these nominal parameters; `None` if their pseudo-inertia is not positive definite.
    ///
    /// The principal second moments about the centre of mass are raised to m r² with r the least radius of
    /// gyration. So a rod or a point becomes a body with a thickness.
    pub(super) fn link(
        first: usize,
        nominal: &[f64; PARAMETERS_PER_LINK],
        least_radius: f64,
    ) -> Option<Self> {
        let mut pseudo = pseudo_inertia(nominal);
        if least_radius > 0.0 {
            let mass = pseudo[(3, 3)];
            let moment = pseudo.fixed_view::<3, 1>(0, 3).into_owned();
            let shift = moment * moment.transpose() / mass;
            let central = (pseudo.fixed_view::<3, 3>(0, 0) - shift).symmetric_eigen();
            let raised = central.eigenvalues.map(|value| value.max(mass * least_radius * least_radius));
            let axes = central.eigenvectors;
            let thick = axes * Matrix3::from_diagonal(&raised) * axes.transpose() + shift;
            pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&thick);
        }
        let factor = pseudo.cholesky()?.l();
        // A pivot that is rounding: the body is flat.
        let flat = (0..4).any(|i| factor[(i, i)].powi(2) <= 1e-12 * pseudo[(i, i)]);
        (!flat).then_some(Self::Link { first, factor })
    }

    /// The number of coordinates.
    pub(super) fn len(&self) -> usize {
        if let Self::Link { .. } = self { PARAMETERS_PER_LINK } else { 1 }
    }

    /// The first of its parameters.
    pub(super) fn first(&self) -> usize {
        match self {
            Self::Link { first, .. } => *first,
            Self::Positive { index, .. } | Self::Offset { index, .. } => *index,
        }
    }

    /// The parameters at y = 0.
    pub(super) fn origin(&self) -> f64 {
        if let Self::Offset { nominal, .. } = self { *nominal } else { 0.0 }
    }

    /// The coordinates of the nominal parameters.
    pub(super) fn start(&self) -> Vec<f64> {
        match self {
            Self::Link { .. } => entries(&Matrix4::identity()).as_slice().to_vec(),
            Self::Positive { .. } => vec![1.0],
            Self::Offset { .. } => vec![0.0],
        }
    }

    /// The change of the parameters for a unit of the k-th coordinate.
    pub(super) fn column(&self, k: usize) -> Vec<f64> {
        match self {
            Self::Link { factor, .. } => {
                let mut unit = [0.0; PARAMETERS_PER_LINK];
                unit[k] = 1.0;
                parameters_of(&(factor * symmetric(&unit) * factor.transpose())).to_vec()
            }
            Self::Positive { nominal, .. } => vec![*nominal],
            Self::Offset { deviation, .. } => vec![*deviation],
        }
    }

    /// D(y); infinite outside its domain.
    pub(super) fn divergence(&self, y: &[f64]) -> f64 {
        match self {
            Self::Link { .. } => match symmetric(y).cholesky() {
                Some(factor) => {
                    let log = (0..4).map(|i| 2.0 * factor.l_dirty()[(i, i)].ln()).sum::<f64>();
                    symmetric(y).trace() - log - 4.0
                }
                None => f64::INFINITY,
            },
            Self::Positive { .. } if y[0] > 0.0 => y[0] - y[0].ln() - 1.0,
            Self::Positive { .. } => f64::INFINITY,
            Self::Offset { .. } => 0.5 * y[0] * y[0],
        }
    }

    /// S, row by row, and u. `y` is in the domain.
    pub(super) fn derivatives(&self, y: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Link { .. } => {
                let factor = symmetric(y).cholesky().map_or_else(Matrix4::identity, |own| own.l());
                let inverse = factor.try_inverse().unwrap_or_else(Matrix4::identity);
                let mut map = SMatrix::<f64, PARAMETERS_PER_LINK, PARAMETERS_PER_LINK>::zeros();
                for k in 0..PARAMETERS_PER_LINK {
                    let mut unit = [0.0; PARAMETERS_PER_LINK];
                    unit[k] = 1.0;
                    map.set_column(k, &entries(&(inverse * symmetric(&unit) * inverse.transpose())));
                }
                let u = entries(&(factor.transpose() * factor - Matrix4::identity()));
                (map.transpose().as_slice().to_vec(), u.as_slice().to_vec())
            }
            Self::Positive { .. } => (vec![1.0 / y[0]], vec![y[0] - 1.0]),
            Self::Offset { .. } => (vec![1.0], vec![y[0]]),
        }
    }
}

/// D(J ‖ J₀) = tr(J J₀⁻¹) − ln det(J J₀⁻¹) − 4: the entropic divergence of a link's ten parameters from
/// nominal ones.
///
/// It is zero for equal bodies, positive otherwise, and independent of the axes and the units in which both
/// are given. It is infinite if no body has the parameters. A tenth more mass with an equal shape costs
/// 4 (0.1 − ln 1.1) = 0.019. **(Lee, Wensing, Park 2020)**
///
/// ```
/// use robot_dynamics::control::identification::entropic_divergence;
/// let cube = [1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.0, 0.1];
/// let heavier = cube.map(|parameter| 1.1 * parameter);
/// let divergence = entropic_divergence(&heavier, &cube).expect("a body");
/// assert!((divergence - 4.0 * (0.1 - 1.1_f64.ln())).abs() < 1e-14);
/// // A rod without thickness is the limit of no bodies around it.
/// let rod = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1];
/// assert_eq!(entropic_divergence(&cube, &rod), None);
/// ```
///
/// Returns `None` if the nominal pseudo-inertia is not positive definite.
pub fn entropic_divergence(
    parameters: &[f64; PARAMETERS_PER_LINK],
    nominal: &[f64; PARAMETERS_PER_LINK],
) -> Option<f64> {
    let block = Block::link(0, nominal, 0.0)?;
    let Block::Link { factor, .. } = &block else { return None };
    let inverse = factor.try_inverse()?;
    let relative = inverse * pseudo_inertia(parameters) * inverse.transpose();
    Some(block.divergence(entries(&relative).as_slice()))
}

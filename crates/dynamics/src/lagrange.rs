//! The Lagrange recipe: from M(q) and V(q) to every term of the equation of motion.
//!
//! K = ½ q̇ᵀM q̇ and V determine the motion. The velocity-product forces are derivatives of M through the
//! Christoffel symbols Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ) **(PRM 10.9)**, gravity is ∂V/∂q. If M is
//! written over a generic scalar type ([`Lagrangian`]) the derivatives are exact; if only the numbers M(q)
//! exist, [`christoffel_by_differences`] uses central differences.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_number::{Dual, Scalar};

use crate::Dynamics;

/// A system given by its two energies, written over a generic scalar: M(q) and V(q).
///
/// Wrap it in [`FromLagrangian`] to get every term of [`Dynamics`], with exact derivatives.
pub trait Lagrangian<const N: usize> {
    /// M(q), N×N symmetric; K = ½ q̇ᵀM q̇. **(PRM 10.6)**
    fn mass_over<S: Scalar>(&self, q: &[S; N]) -> [[S; N]; N];

    /// V(q) \[J\].
    fn potential_over<S: Scalar>(&self, q: &[S; N]) -> S;
}

/// The Christoffel symbols of the first kind of a mass matrix: Γⁱⱼₖ, symmetric in j and k. **(PRM 10.9)**
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Christoffel<const N: usize>([[[f64; N]; N]; N]);

impl<const N: usize> Christoffel<N> {
    /// From a table with `table[i][j][k]` = Γⁱⱼₖ.
    pub fn from_table(table: [[[f64; N]; N]; N]) -> Self {
        Self(table)
    }

    /// From the partial derivatives of the mass matrix, `derivatives[k]` = ∂M/∂qₖ.
    pub fn from_mass_derivatives(derivatives: &[SMatrix<f64, N, N>; N]) -> Self {
        let d = derivatives;
        Self(core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                core::array::from_fn(|k| 0.5 * (d[k][(i, j)] + d[j][(i, k)] - d[i][(j, k)]))
            })
        }))
    }

    /// Γⁱⱼₖ.
    ///
    /// # Panics
    /// If an index is N or more.
    pub fn get(&self, i: usize, j: usize, k: usize) -> f64 {
        self.0[i][j][k]
    }

    /// The Coriolis matrix C_ij = Σₖ Γⁱⱼₖ q̇ₖ; with it Ṁ − 2C is skew-symmetric. **(MLS §4.3, lemma 4.2)**
    pub fn coriolis_matrix(&self, qd: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        SMatrix::from_fn(|i, j| (0..N).map(|k| self.0[i][j][k] * qd[k]).sum())
    }

    /// C(q,q̇) q̇: row i is q̇ᵀΓⁱq̇.
    pub fn velocity_product(&self, qd: &SVector<f64, N>) -> SVector<f64, N> {
        self.coriolis_matrix(qd) * qd
    }

    /// The largest |Γⁱⱼₖ − Γ′ⁱⱼₖ|; NaN if any symbol is NaN.
    pub fn max_difference(&self, other: &Self) -> f64 {
        let entries = |symbols: &Self| symbols.0.into_iter().flatten().flatten();
        largest(entries(self).zip(entries(other)).map(|(a, b)| a - b))
    }
}

/// ∂M/∂qₖ for k = 0..N, exact, from one evaluation of M over dual numbers.
///
/// ```
/// use dynamics::{PolarMass, mass_derivatives};
/// use nalgebra::{matrix, vector};
/// // M = diag(m, m r²) with q = (r, θ): ∂M/∂r = diag(0, 2 m r), ∂M/∂θ = 0.
/// let by = mass_derivatives(&PolarMass { m: 2.0, a_g: 9.81 }, &vector![1.5, 0.7]);
/// assert_eq!(by, [matrix![0.0, 0.0; 0.0, 6.0], matrix![0.0, 0.0; 0.0, 0.0]]);
/// ```
pub fn mass_derivatives<L: Lagrangian<N>, const N: usize>(
    system: &L,
    q: &SVector<f64, N>,
) -> [SMatrix<f64, N, N>; N] {
    let mass = system.mass_over(&Dual::variables(&q.data.0[0]));
    core::array::from_fn(|k| SMatrix::from_fn(|i, j| mass[i][j].gradient[k]))
}

/// Γ(q), exact to rounding. **(PRM 10.9)**
///
/// ```
/// use dynamics::{PolarMass, christoffel};
/// use nalgebra::vector;
/// // A mass of 2 kg at r = 1.5 m: −m r θ̇² outwards, 2 m r ṙ θ̇ across.
/// let symbols = christoffel(&PolarMass { m: 2.0, a_g: 9.81 }, &vector![1.5, 0.7]);
/// assert_eq!((symbols.get(0, 1, 1), symbols.get(1, 0, 1)), (-3.0, 3.0));
/// assert_eq!(symbols.velocity_product(&vector![0.5, 2.0]), vector![-12.0, 6.0]);
/// ```
pub fn christoffel<L: Lagrangian<N>, const N: usize>(system: &L, q: &SVector<f64, N>) -> Christoffel<N> {
    Christoffel::from_mass_derivatives(&mass_derivatives(system, q))
}

/// Γ(q) by central differences of any M(q): 2N evaluations, step `step` \[rad or m\]. **(PRM 10.9)**
///
/// The error is O(step²) truncation plus O(ε/step) rounding; 1e-6 leaves about 1e-9 relative.
///
/// ```
/// use dynamics::{Dynamics, PlanarArm, christoffel, christoffel_by_differences};
/// use nalgebra::vector;
/// let (arm, q) = (PlanarArm::reach_3r(), vector![0.3, 1.2, -0.7]);
/// let differences = christoffel_by_differences(|q| arm.mass(q), &q, 1e-6);
/// assert!(differences.max_difference(&christoffel(&arm, &q)) < 1e-8); // ε/step
/// ```
///
/// # Panics
/// If `step` is not positive and finite.
pub fn christoffel_by_differences<const N: usize>(
    mass: impl Fn(&SVector<f64, N>) -> SMatrix<f64, N, N>,
    q: &SVector<f64, N>,
    step: f64,
) -> Christoffel<N> {
    assert!(step > 0.0 && step.is_finite(), "the difference step must be positive and finite, got {step}");
    Christoffel::from_mass_derivatives(&core::array::from_fn(|k| {
        let (mut forward, mut backward) = (*q, *q);
        forward[k] += step;
        backward[k] -= step;
        // The actual step, after rounding.
        (mass(&forward) - mass(&backward)) / (forward[k] - backward[k])
    }))
}

/// Ṁ = Σₖ ∂M/∂qₖ q̇ₖ along the velocity q̇, exact: one directional derivative, no Christoffel symbols.
///
/// ```
/// use dynamics::{PolarMass, mass_rate};
/// use nalgebra::{matrix, vector};
/// // M₂₂ = m r² grows by 2 m r ṙ.
/// let rate = mass_rate(&PolarMass { m: 2.0, a_g: 9.81 }, &vector![1.5, 0.7], &vector![0.5, 2.0]);
/// assert_eq!(rate, matrix![0.0, 0.0; 0.0, 3.0]);
/// ```
pub fn mass_rate<L: Lagrangian<N>, const N: usize>(
    system: &L,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
) -> SMatrix<f64, N, N> {
    let path: [Dual<f64, 1>; N] = core::array::from_fn(|i| Dual { value: q[i], gradient: [qd[i]] });
    let mass = system.mass_over(&path);
    SMatrix::from_fn(|i, j| mass[i][j].gradient[0])
}

/// max |(Ṁ−2C) + (Ṁ−2C)ᵀ|: zero if C is a Coriolis matrix with the skew property, NaN if an entry is NaN.
/// **(MLS lemma 4.2)**
///
/// Use an Ṁ that shares no code with C, for example [`mass_rate`].
///
/// C is not unique. With any S for which S q̇ = 0, C + S gives the same forces and the same motion, but
/// Ṁ − 2(C + S) is not skew-symmetric. Proofs of stability need the C of [`christoffel`].
///
/// ```
/// use dynamics::{PlanarArm, christoffel, mass_rate, skew_symmetry_defect};
/// use nalgebra::{matrix, vector};
/// let arm = PlanarArm::reach_3r();
/// let (q, qd) = (vector![0.3, 1.2, -0.7], vector![1.0, 2.0, -1.0]);
/// let c = christoffel(&arm, &q).coriolis_matrix(&qd);
/// let s = matrix![2.0, -1.0, 0.0; 0.0, 0.5, 1.0; 1.0, 0.0, 1.0]; // every row is orthogonal to q̇
/// assert_eq!(s * qd, vector![0.0, 0.0, 0.0]);
/// assert!(((c + s) * qd - c * qd).norm() < 1e-14); // the same forces
/// let rate = mass_rate(&arm, &q, &qd);
/// assert!(skew_symmetry_defect(&rate, &c) < 1e-14);
/// assert!((skew_symmetry_defect(&rate, &(c + s)) - 8.0).abs() < 1e-14); // that of −2S
/// ```
pub fn skew_symmetry_defect<const N: usize>(
    mass_rate: &SMatrix<f64, N, N>,
    coriolis: &SMatrix<f64, N, N>,
) -> f64 {
    let n = mass_rate - coriolis * 2.0;
    largest((n + n.transpose()).iter().copied())
}

/// The largest |x|, and NaN if any x is NaN, which `f64::max` would ignore.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |worst, x| if x.is_nan() || x.abs() > worst { x.abs() } else { worst })
}

/// Makes a [`Lagrangian`] a [`Dynamics`]: C q̇ through exact Christoffel symbols, g = ∂V/∂q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromLagrangian<L>(pub L);

impl<L: Lagrangian<N>, const N: usize> Dynamics<N> for FromLagrangian<L> {
    fn mass(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let mass = self.0.mass_over(&q.data.0[0]);
        SMatrix::from_fn(|i, j| mass[i][j])
    }

    fn velocity_product(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        christoffel(&self.0, q).velocity_product(qd)
    }

    fn gravity(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        SVector::from(self.0.potential_over(&Dual::variables(&q.data.0[0])).gradient)
    }

    fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        self.0.potential_over(&q.data.0[0])
    }

    fn coriolis_matrix(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        christoffel(&self.0, q).coriolis_matrix(qd)
    }
}

impl<L: Lagrangian<N>, const N: usize> Lagrangian<N> for FromLagrangian<L> {
    fn mass_over<S: Scalar>(&self, q: &[S; N]) -> [[S; N]; N] {
        self.0.mass_over(q)
    }

    fn potential_over<S: Scalar>(&self, q: &[S; N]) -> S {
        self.0.potential_over(q)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{matrix, vector};

    use super::*;
    use crate::Reach2R;

    /// One NaN among finite entries must not look like a small defect.
    #[test]
    fn defects_propagate_nan() {
        assert_eq!(largest([1.0, -3.0, 2.0]), 3.0);
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan());
        let rate = matrix![0.0, f64::NAN; 0.0, 0.0];
        assert!(skew_symmetry_defect(&rate, &SMatrix::zeros()).is_nan());
        let (good, bad) = (Christoffel([[[1.0]]]), Christoffel([[[f64::NAN]]]));
        assert!(good.max_difference(&bad).is_nan());
        assert_eq!(good.max_difference(&Christoffel([[[-0.5]]])), 1.5);
    }

    /// The defect of a matrix that is skew except for one entry is twice that entry.
    #[test]
    fn defect_is_twice_the_symmetric_part() {
        let rate = matrix![0.25, 3.0; -3.0, 0.0];
        assert_eq!(skew_symmetry_defect(&rate, &SMatrix::zeros()), 0.5);
    }

    /// ∂M/∂q1 = 0 and ∂M/∂q2 = −m2 l1 r2 sin q2 (2, 1; 1, 0), by hand.
    #[test]
    fn mass_derivatives_of_the_two_link_arm() {
        let arm = Reach2R::worked_example();
        let [by_q1, by_q2] = mass_derivatives(&arm, &vector![0.3, 0.9]);
        let slope = -0.5 * 0.9_f64.sin();
        assert_eq!(by_q1.norm(), 0.0);
        assert!((by_q2 - matrix![2.0 * slope, slope; slope, 0.0]).norm() < 1e-15);
        let rate = mass_rate(&arm, &vector![0.3, 0.9], &vector![5.0, -2.0]);
        assert!((rate - by_q2 * -2.0).norm() < 1e-15);
    }

    #[test]
    #[should_panic(expected = "the difference step must be positive and finite, got 0")]
    fn zero_step_panics() {
        let _ = christoffel_by_differences(|q| Reach2R::worked_example().mass(q), &vector![0.0, 0.0], 0.0);
    }
}

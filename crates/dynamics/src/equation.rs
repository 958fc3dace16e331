//! The equation of motion M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u as a trait.

use core::fmt;

use nalgebra::{SMatrix, SVector};

/// Why a forward dynamics could not be computed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DynamicsError {
    /// An input or an intermediate quantity is NaN or infinite.
    NonFinite {
        /// Which quantity, by its letter: `q`, `qd`, `u`, `M`, `C q̇`, `g`, `b`.
        quantity: &'static str,
        /// The first offending entry (row, for a matrix).
        index: usize,
    },
    /// M(q) is not positive definite: some motion costs no kinetic energy, so q̈ is not determined.
    SingularMass {
        /// The coordinate at which the Cholesky factorisation broke down.
        coordinate: usize,
        /// The pivot found there, in the units of M's diagonal; it must be positive.
        pivot: f64,
    },
}

impl fmt::Display for DynamicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite { quantity, index } => {
                write!(f, "{quantity}[{index}] is not finite; check the state and the parameters")
            }
            Self::SingularMass { coordinate, pivot } => write!(
                f,
                "the mass matrix is singular: pivot {pivot:e} at coordinate {coordinate} is not positive; \
                 some body moved by that coordinate has no inertia"
            ),
        }
    }
}

impl core::error::Error for DynamicsError {}

/// A mechanical system of `N` coordinates: M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u. **(PRM 10.7)**
///
/// Coordinates `q` are in m or rad, so row i of every force-like vector is in N or N·m. Four methods
/// describe a system; everything else follows from them. The trait is usable as `dyn Dynamics<N>`.
///
/// ```
/// use dynamics::{Dynamics, Reach2R};
/// use nalgebra::vector;
/// let arm: &dyn Dynamics<2> = &Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81);
/// let q = vector![0.3, -0.8];
/// let qdd = arm.forward(&q, &vector![1.0, 2.0], &vector![0.5, 0.1]);
/// let u = arm.inverse(&q, &vector![1.0, 2.0], &qdd);
/// assert!((u - vector![0.5, 0.1]).norm() < 1e-12);
/// ```
pub trait Dynamics<const N: usize> {
    /// The mass matrix M(q): symmetric, positive definite, both triangles filled. **(PRM 10.6)**
    fn mass(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N>;

    /// C(q,q̇) q̇ = q̇ᵀΓ(q) q̇: centrifugal and Coriolis forces, a quadratic form in q̇. **(PRM 10.9)**
    ///
    /// The matrix C is not unique; this product is.
    fn velocity_product(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N>;

    /// g(q) = ∂V/∂q: the force that holds the system still against its potential.
    fn gravity(&self, q: &SVector<f64, N>) -> SVector<f64, N>;

    /// The potential energy V(q) \[J\].
    fn potential_energy(&self, q: &SVector<f64, N>) -> f64;

    /// b(q,q̇): forces that take energy out (damping, friction); zero unless a model says otherwise.
    fn dissipation(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let _ = (q, qd);
        SVector::zeros()
    }

    /// The acceleration q̈ = M⁻¹(u − Cq̇ − g − b), by Cholesky.
    ///
    /// # Panics
    /// Where [`try_forward`](Self::try_forward) would return an error.
    fn forward(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, u: &SVector<f64, N>) -> SVector<f64, N> {
        match self.try_forward(q, qd, u) {
            Ok(qdd) => qdd,
            Err(error) => panic!("forward dynamics: {error}"),
        }
    }

    /// The acceleration q̈ = M⁻¹(u − Cq̇ − g − b), or why there is none.
    ///
    /// # Errors
    /// [`DynamicsError::NonFinite`] names the first quantity with a NaN or an infinity;
    /// [`DynamicsError::SingularMass`] names the coordinate at which M stops being positive definite.
    fn try_forward(
        &self,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, DynamicsError> {
        check_finite("q", q.as_slice())?;
        check_finite("qd", qd.as_slice())?;
        check_finite("u", u.as_slice())?;
        let force = u - self.bias(q, qd);
        check_finite("u − C q̇ − g − b", force.as_slice())?;
        solve_mass(&self.mass(q), &force)
    }

    /// The force u = M q̈ + Cq̇ + g + b that produces the acceleration q̈.
    fn inverse(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, qdd: &SVector<f64, N>) -> SVector<f64, N> {
        self.mass(q) * qdd + self.bias(q, qd)
    }

    /// Everything but inertia: C q̇ + g + b.
    fn bias(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        self.velocity_product(q, qd) + self.gravity(q) + self.dissipation(q, qd)
    }

    /// The kinetic energy K = ½ q̇ᵀM(q) q̇ \[J\].
    fn kinetic_energy(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> f64 {
        0.5 * qd.dot(&(self.mass(q) * qd))
    }

    /// The total energy E = K + V \[J\].
    fn energy(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> f64 {
        self.kinetic_energy(q, qd) + self.potential_energy(q)
    }

    /// The Christoffel Coriolis matrix C_ij = Σₖ Γⁱⱼₖ q̇ₖ, by polarising the quadratic form
    /// [`velocity_product`](Self::velocity_product): C eⱼ = ½(f(q̇+eⱼ) − f(q̇) − f(eⱼ)). **(PRM 10.9)**
    ///
    /// Exact but for rounding: no step size. With this choice Ṁ − 2C is skew-symmetric.
    fn coriolis_matrix(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let product = self.velocity_product(q, qd);
        let mut coriolis = SMatrix::<f64, N, N>::zeros();
        for j in 0..N {
            let mut unit = SVector::<f64, N>::zeros();
            unit[j] = 1.0;
            let column =
                (self.velocity_product(q, &(qd + unit)) - product - self.velocity_product(q, &unit)) * 0.5;
            coriolis.set_column(j, &column);
        }
        coriolis
    }
}

/// Refuses a slice with a NaN or an infinity, naming the quantity and the entry.
///
/// # Errors
/// [`DynamicsError::NonFinite`].
pub fn check_finite(quantity: &'static str, values: &[f64]) -> Result<(), DynamicsError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(DynamicsError::NonFinite { quantity, index }),
        None => Ok(()),
    }
}

/// Solves M x = f for a symmetric positive definite M by Cholesky, M = L Lᵀ.
///
/// # Errors
/// [`DynamicsError`] if M is not finite or not positive definite, with the coordinate at fault.
pub fn solve_mass<const N: usize>(
    mass: &SMatrix<f64, N, N>,
    force: &SVector<f64, N>,
) -> Result<SVector<f64, N>, DynamicsError> {
    if let Some(index) = mass.iter().position(|x| !x.is_finite()) {
        return Err(DynamicsError::NonFinite { quantity: "M", index: index % N });
    }
    let mut lower = *mass;
    for j in 0..N {
        for k in 0..j {
            let factor = lower[(j, k)];
            for i in j..N {
                let product = factor * lower[(i, k)];
                lower[(i, j)] -= product;
            }
        }
        // A pivot below the rounding error of its own row is zero as far as f64 can tell.
        let pivot = lower[(j, j)];
        if pivot <= f64::EPSILON * mass[(j, j)].abs() * N as f64 || pivot.is_nan() {
            return Err(DynamicsError::SingularMass { coordinate: j, pivot });
        }
        let root = pivot.sqrt();
        for i in j..N {
            lower[(i, j)] /= root;
        }
    }
    let mut x = *force;
    for i in 0..N {
        for k in 0..i {
            x[i] -= lower[(i, k)] * x[k];
        }
        x[i] /= lower[(i, i)];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= lower[(k, i)] * x[k];
        }
        x[i] /= lower[(i, i)];
    }
    Ok(x)
}

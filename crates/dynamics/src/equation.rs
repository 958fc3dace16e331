//! The equation of motion M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u as a trait.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_integrators::{IntegratorError, check_computed};
use robot_dynamics_number::check_finite;

/// A mechanical system of `N` coordinates: M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u. **(PRM 10.7)**
///
/// Coordinates `q` are in m or rad, so row i of every force-like vector is in N or N·m. Four methods describe
/// a system; the others follow from them. The trait is object-safe: `dyn Dynamics<N>`.
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

    /// b(q,q̇): dissipative forces (damping, friction); zero by default.
    fn dissipation(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SVector<f64, N> {
        let _ = (q, qd);
        SVector::zeros()
    }

    /// The acceleration q̈ = M⁻¹(u − Cq̇ − g − b), by Cholesky.
    ///
    /// # Panics
    /// If [`try_forward`](Self::try_forward) would return an error.
    fn forward(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, u: &SVector<f64, N>) -> SVector<f64, N> {
        match self.try_forward(q, qd, u) {
            Ok(qdd) => qdd,
            Err(error) => panic!("forward dynamics: {error}"),
        }
    }

    /// The acceleration q̈ = M⁻¹(u − Cq̇ − g − b), or the reason for its absence.
    ///
    /// # Errors
    /// [`IntegratorError::Input`] and [`IntegratorError::NotFinite`] name the first argument, or the first
    /// term, with a NaN or an infinity;
    /// [`IntegratorError::SingularMass`] names the coordinate at which M stops being positive definite.
    fn try_forward(
        &self,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
    ) -> Result<SVector<f64, N>, IntegratorError> {
        check_finite("q", q.as_slice())?;
        check_finite("qd", qd.as_slice())?;
        check_finite("u", u.as_slice())?;
        let force = u - self.bias(q, qd);
        if force.iter().any(|x| !x.is_finite()) {
            // The sum is not finite; find the term that is not.
            check_computed("C q̇", self.velocity_product(q, qd).as_slice())?;
            check_computed("g", self.gravity(q).as_slice())?;
            check_computed("b", self.dissipation(q, qd).as_slice())?;
            check_computed("u − C q̇ − g − b", force.as_slice())?;
        }
        solve_mass(&self.mass(q), &force)
    }

    /// The force u = M q̈ + Cq̇ + g + b that produces the acceleration q̈.
    fn inverse(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, qdd: &SVector<f64, N>) -> SVector<f64, N> {
        self.mass(q) * qdd + self.bias(q, qd)
    }

    /// The forces without inertia: C q̇ + g + b.
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
    /// [`velocity_product`](Self::velocity_product): C eⱼ = (f(q̇+s eⱼ) − f(q̇) − f(s eⱼ))/2s. **(PRM 10.9)**
    ///
    /// Exact for every s up to rounding, which s = max |q̇ᵢ| keeps small at any speed. With this C, Ṁ − 2C is
    /// skew-symmetric.
    fn coriolis_matrix(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        let mut coriolis = SMatrix::<f64, N, N>::zeros();
        let speed = qd.amax();
        if speed == 0.0 {
            return coriolis;
        }
        let product = self.velocity_product(q, qd);
        for j in 0..N {
            let mut along = SVector::<f64, N>::zeros();
            along[j] = speed;
            let mixed = self.velocity_product(q, &(qd + along)) - product - self.velocity_product(q, &along);
            coriolis.set_column(j, &(mixed / (2.0 * speed)));
        }
        coriolis
    }
}

/// Solves M x = f for a symmetric positive definite M by Cholesky, M = L Lᵀ; reads M's lower triangle.
///
/// ```
/// use dynamics::{Dynamics, Reach2R, solve_mass};
/// use nalgebra::{matrix, vector};
/// let (q, u) = (vector![0.3, 1.2], vector![1.0, -2.0]);
/// let mass = Reach2R::worked_example().mass(&q);
/// let qdd = solve_mass(&mass, &u)?; // the acceleration from rest without gravity
/// assert!((mass * qdd - u).norm() < 1e-14);
/// assert!(solve_mass(&matrix![1.0, 2.0; 2.0, 1.0], &u).is_err()); // no mass matrix: vᵀM v can be negative
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// [`IntegratorError`] if M is not finite or not positive definite, with the coordinate, or if x is too large
/// for an `f64`.
pub fn solve_mass<const N: usize>(
    mass: &SMatrix<f64, N, N>,
    force: &SVector<f64, N>,
) -> Result<SVector<f64, N>, IntegratorError> {
    if let Some(index) = mass.iter().position(|x| !x.is_finite()) {
        return Err(IntegratorError::NotFinite { quantity: "M", index: index % N });
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
        // A pivot below the rounding error of its row counts as zero.
        let pivot = lower[(j, j)];
        if pivot <= f64::EPSILON * mass[(j, j)].abs() * N as f64 || pivot.is_nan() {
            return Err(IntegratorError::SingularMass { coordinate: j, pivot });
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
        check_entry(x[i], i)?;
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= lower[(k, i)] * x[k];
        }
        x[i] /= lower[(i, i)];
        check_entry(x[i], i)?;
    }
    Ok(x)
}

/// Detects an overflow at its origin, before 0 · ∞ spreads it over the other coordinates.
fn check_entry(x: f64, index: usize) -> Result<(), IntegratorError> {
    if x.is_finite() { Ok(()) } else { Err(IntegratorError::NotFinite { quantity: "qdd", index }) }
}

#[cfg(test)]
mod tests {
    use nalgebra::{matrix, vector};
    use proptest::prelude::*;
    use robot_dynamics_number::InputProblem;

    use super::*;
    use crate::{PlanarArm, Reach2R, christoffel};

    type V2 = SVector<f64, 2>;

    /// A system with given constant terms.
    #[derive(Clone, Copy)]
    struct Constant {
        mass: SMatrix<f64, 2, 2>,
        product: V2,
        gravity: V2,
        loss: V2,
    }

    const PLAIN: Constant = Constant {
        mass: SMatrix::<f64, 2, 2>::new(4.0, 0.0, 0.0, 1.0),
        product: V2::new(0.0, 0.0),
        gravity: V2::new(0.0, 0.0),
        loss: V2::new(0.0, 0.0),
    };

    impl Dynamics<2> for Constant {
        fn mass(&self, _: &V2) -> SMatrix<f64, 2, 2> {
            self.mass
        }
        fn velocity_product(&self, _: &V2, _: &V2) -> V2 {
            self.product
        }
        fn gravity(&self, _: &V2) -> V2 {
            self.gravity
        }
        fn potential_energy(&self, _: &V2) -> f64 {
            0.0
        }
        fn dissipation(&self, _: &V2, _: &V2) -> V2 {
            self.loss
        }
    }

    /// The error names the quantity that is NaN, and its entry.
    #[test]
    fn error_names_quantity_that_is_not_finite() {
        let (zero, bad) = (V2::zeros(), vector![0.0, f64::NAN]);
        let found = |system: Constant, q: V2, qd: V2, u: V2| match system.try_forward(&q, &qd, &u) {
            Err(IntegratorError::NotFinite { quantity, index: 1 }) => quantity.to_owned(),
            Err(IntegratorError::Input(input))
                if matches!(input.problem, InputProblem::NotFinite { index: Some(1), .. }) =>
            {
                input.quantity
            }
            other => panic!("{other:?}"),
        };
        assert_eq!(found(PLAIN, bad, zero, zero), "q");
        assert_eq!(found(PLAIN, zero, bad, zero), "qd");
        assert_eq!(found(PLAIN, zero, zero, bad), "u");
        assert_eq!(found(Constant { product: bad, ..PLAIN }, zero, zero, zero), "C q̇");
        assert_eq!(found(Constant { gravity: bad, ..PLAIN }, zero, zero, zero), "g");
        assert_eq!(found(Constant { loss: bad, ..PLAIN }, zero, zero, zero), "b");
        let mass = matrix![1.0, 0.0; 0.0, f64::INFINITY];
        assert_eq!(found(Constant { mass, ..PLAIN }, zero, zero, zero), "M");
        // Finite terms with an infinite sum, and a finite force on a tiny mass.
        let huge = vector![0.0, f64::MAX];
        assert_eq!(found(Constant { gravity: -huge, ..PLAIN }, zero, zero, huge), "u − C q̇ − g − b");
        let mass = matrix![1.0, 0.0; 0.0, 1e-300];
        assert_eq!(found(Constant { mass, ..PLAIN }, zero, zero, vector![0.0, 1e200]), "qdd");
    }

    /// The coordinate of the vanishing pivot has no inertia, given those before it.
    #[test]
    fn error_names_coordinate_of_singular_mass() {
        let at = |mass: SMatrix<f64, 3, 3>| match solve_mass(&mass, &vector![1.0, 1.0, 1.0]) {
            Err(IntegratorError::SingularMass { coordinate, pivot }) if pivot.abs() < 1e-15 => coordinate,
            other => panic!("{other:?}"),
        };
        assert_eq!(at(matrix![0.0, 0.0, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0]), 0);
        assert_eq!(at(matrix![1.0, 1.0, 0.0; 1.0, 1.0, 0.0; 0.0, 0.0, 1.0]), 1);
        // Rank 2: row 2 is the sum of the others, in numbers that do not cancel exactly.
        assert_eq!(at(matrix![0.7, 0.1, 0.8; 0.1, 0.3, 0.4; 0.8, 0.4, 1.2]), 2);
        let weightless = Reach2R::uniform(1.0, 2.0, 1.0, 0.0, 9.81);
        let error = weightless.try_forward(&V2::zeros(), &V2::zeros(), &V2::zeros()).unwrap_err();
        assert_eq!(error, IntegratorError::SingularMass { coordinate: 1, pivot: 0.0 });
    }

    /// An indefinite matrix is an error, although it is invertible.
    #[test]
    fn indefinite_mass_is_an_error() {
        let error = solve_mass(&matrix![1.0, 2.0; 2.0, 1.0], &vector![1.0, 1.0]).unwrap_err();
        assert_eq!(error, IntegratorError::SingularMass { coordinate: 1, pivot: -3.0 });
    }

    #[test]
    fn error_messages_name_quantity_and_remedy() {
        let error = IntegratorError::NotFinite { quantity: "M", index: 1 };
        assert_eq!(error.to_string(), "M[1] is not finite; check the state and the parameters");
        let text = IntegratorError::SingularMass { coordinate: 2, pivot: -0.5 }.to_string();
        assert!(text.contains("pivot -5e-1 at coordinate 2") && text.contains("no inertia"), "{text}");
    }

    #[test]
    #[should_panic(expected = "forward dynamics: qd[0] is -inf; every number must be finite")]
    fn forward_panics_with_error_of_try_forward() {
        PLAIN.forward(&V2::zeros(), &vector![f64::NEG_INFINITY, 0.0], &V2::zeros());
    }

    /// Dissipation and gravity are on the left-hand side: u = M q̈ + C q̇ + g + b.
    #[test]
    fn inverse_adds_every_term() {
        let system = Constant {
            product: vector![0.5, 0.0],
            gravity: vector![0.0, 3.0],
            loss: vector![0.25, 0.125],
            ..PLAIN
        };
        let (zero, qdd) = (V2::zeros(), vector![1.0, -1.0]);
        assert_eq!(system.inverse(&zero, &zero, &qdd), vector![4.75, 2.125]);
        assert_eq!(system.forward(&zero, &zero, &vector![4.75, 2.125]), qdd);
    }

    /// Polarisation gives the Christoffel matrix at usual, very low and very high speeds.
    #[test]
    fn polarised_coriolis_matrix_matches_christoffel() {
        struct Plain(PlanarArm<3>); // keeps the default `coriolis_matrix` of the trait
        impl Dynamics<3> for Plain {
            fn mass(&self, q: &SVector<f64, 3>) -> SMatrix<f64, 3, 3> {
                self.0.mass(q)
            }
            fn velocity_product(&self, q: &SVector<f64, 3>, qd: &SVector<f64, 3>) -> SVector<f64, 3> {
                self.0.velocity_product(q, qd)
            }
            fn gravity(&self, q: &SVector<f64, 3>) -> SVector<f64, 3> {
                self.0.gravity(q)
            }
            fn potential_energy(&self, q: &SVector<f64, 3>) -> f64 {
                self.0.potential_energy(q)
            }
        }
        let arm = Plain(PlanarArm::reach_3r());
        let q = vector![0.4, 1.1, -2.0];
        for speed in [1.0, 1e-9, 1e6] {
            let qd = vector![1.0, -0.3, 0.7] * speed;
            let expected = christoffel(&arm.0, &q).coriolis_matrix(&qd);
            // A dozen roundings of terms of the size of the largest entry.
            let defect = (arm.coriolis_matrix(&q, &qd) - expected).norm() / expected.norm();
            assert!(defect < 1e-14, "speed {speed}: {defect:e}");
        }
        assert_eq!(arm.coriolis_matrix(&q, &SVector::zeros()).amax(), 0.0);
    }

    proptest! {
        /// M = A Aᵀ + δ 1 solved for a known x: the error is within N κ(M) ε of x.
        #[test]
        fn cholesky_error_is_bounded_by_condition_number(
            a in prop::array::uniform16(-1.0..1.0_f64),
            x in prop::array::uniform4(-10.0..10.0_f64),
            exponent in -9..1_i32,
        ) {
            let a = SMatrix::<f64, 4, 4>::from_column_slice(&a);
            let mass = a * a.transpose() + SMatrix::identity() * 10f64.powi(exponent);
            let mass = (mass + mass.transpose()) * 0.5;
            let x = SVector::<f64, 4>::from(x);
            let eigenvalues = mass.symmetric_eigenvalues();
            let kappa = eigenvalues.max() / eigenvalues.min();
            let found = solve_mass(&mass, &(mass * x)).unwrap();
            // 4 for the product M x, 2 · 4 for the factorisation and the two triangular solves, twice over.
            let allowed = 24.0 * kappa * f64::EPSILON * x.norm();
            prop_assert!((found - x).norm() <= allowed, "{:e} > {allowed:e}", (found - x).norm());
        }
    }
}

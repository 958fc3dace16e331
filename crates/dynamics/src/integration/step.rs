//! A step of any fixed-step integrator on a system of fixed size.

use nalgebra::SVector;
use robot_dynamics_integrators::{Integrator, IntegratorError, StepScheme};

use super::State;
use super::explicit_stages::explicit_step;
use super::variational_midpoint::compose;
use crate::Dynamics;

/// Steps of a [`Dynamics`] system by an [`Integrator`].
pub trait SystemStep {
    /// Advances (q, q̇) by `h` \[s\] with u held.
    ///
    /// ```
    /// use dynamics::{PlanarBody, SystemStep};
    /// use nalgebra::{Vector3, vector};
    /// use robot_dynamics_integrators::Integrator;
    /// // A stone let go falls ½ g t², which every row of order 2 or more has exactly.
    /// let (stone, rest) = (PlanarBody { m: 2.0, i_zz: 0.1, a_g: 9.81 }, Vector3::zeros());
    /// for row in Integrator::ALL.into_iter().filter(|row| row.order() >= 2) {
    ///     let (q, qd) = row.step(&stone, &rest, &rest, &rest, 0.1)?;
    ///     assert!((q - vector![0.0, -0.5 * 9.81 * 0.01, 0.0]).norm() < 1e-14);
    ///     assert!((qd - vector![0.0, -0.981, 0.0]).norm() < 1e-14);
    /// }
    /// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
    /// ```
    ///
    /// # Errors
    /// [`IntegratorError::NotFinite`] or [`IntegratorError::SingularMass`] if the system has no acceleration;
    /// [`IntegratorError::NotConverged`] if the step of an implicit method is too long.
    ///
    /// # Panics
    /// If `h` is not positive and finite.
    #[track_caller]
    fn step<D: Dynamics<N> + ?Sized, const N: usize>(
        self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
        h: f64,
    ) -> Result<State<N>, IntegratorError>;
}

impl SystemStep for Integrator {
    #[track_caller]
    fn step<D: Dynamics<N> + ?Sized, const N: usize>(
        self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
        h: f64,
    ) -> Result<State<N>, IntegratorError> {
        match self.scheme() {
            StepScheme::Explicit(stages) => {
                Ok(explicit_step(stages, q, qd, h, |q, qd| system.try_forward(q, qd, u))?)
            }
            StepScheme::Variational(fractions) => compose(system, q, qd, u, h, fractions),
        }
    }
}

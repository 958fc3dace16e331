//! The table of integrators: method, order, properties.

use core::fmt;
use core::str::FromStr;

use nalgebra::SVector;

use super::{IntegratorError, State, explicit_euler_step, rk4_step, semi_implicit_euler_step};
use crate::Dynamics;

/// A method that advances (q, q̇) by one step of fixed length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// [`explicit_euler_step`].
    ExplicitEuler,
    /// [`semi_implicit_euler_step`].
    SemiImplicitEuler,
    /// [`rk4_step`].
    RungeKutta4,
}

impl Integrator {
    /// Every row of the table.
    pub const ALL: [Self; 3] = [Self::ExplicitEuler, Self::SemiImplicitEuler, Self::RungeKutta4];

    /// The name [`from_name`](Self::from_name) reads: lower case, words joined by `-`.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit-euler",
            Self::SemiImplicitEuler => "semi-implicit-euler",
            Self::RungeKutta4 => "rk4",
        }
    }

    /// The row with this name.
    ///
    /// # Errors
    /// [`IntegratorError::UnknownName`], whose message lists the names there are.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// assert_eq!(Integrator::from_name("rk4")?.order(), 4);
    /// # Ok::<(), dynamics::IntegratorError>(())
    /// ```
    pub fn from_name(name: &str) -> Result<Self, IntegratorError> {
        Self::ALL
            .into_iter()
            .find(|row| row.name() == name)
            .ok_or_else(|| IntegratorError::UnknownName { name: name.to_owned() })
    }

    /// The order p: the error at a fixed time is O(hᵖ).
    pub fn order(self) -> u32 {
        match self {
            Self::ExplicitEuler | Self::SemiImplicitEuler => 1,
            Self::RungeKutta4 => 4,
        }
    }

    /// Advances (q, q̇) by `h` \[s\] with u held.
    ///
    /// # Errors
    /// [`IntegratorError::Dynamics`] where the system has no acceleration.
    ///
    /// # Panics
    /// If `h` is not positive and finite.
    pub fn step<D: Dynamics<N> + ?Sized, const N: usize>(
        self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
        h: f64,
    ) -> Result<State<N>, IntegratorError> {
        match self {
            Self::ExplicitEuler => Ok(explicit_euler_step(system, q, qd, u, h)?),
            Self::SemiImplicitEuler => Ok(semi_implicit_euler_step(system, q, qd, u, h)?),
            Self::RungeKutta4 => Ok(rk4_step(system, q, qd, u, h)?),
        }
    }
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Integrator {
    type Err = IntegratorError;
    fn from_str(name: &str) -> Result<Self, IntegratorError> {
        Self::from_name(name)
    }
}

//! The table of integrators: method, order, properties.

use core::fmt;
use core::str::FromStr;

use nalgebra::SVector;

use super::{
    IntegratorError, State, explicit_euler_step, rk4_step, semi_implicit_euler_step,
    variational_midpoint_step, variational_yoshida4_step,
};
use crate::Dynamics;

/// A method that advances (q, q̇) by one step of fixed length: a row of the table of integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// [`explicit_euler_step`]: the bad example.
    ExplicitEuler,
    /// [`semi_implicit_euler_step`]: what many game engines use.
    SemiImplicitEuler,
    /// [`rk4_step`]: the all-rounder.
    RungeKutta4,
    /// [`variational_midpoint_step`]: keeps the structure, for long runs.
    VariationalMidpoint,
    /// [`variational_yoshida4_step`]: keeps the structure, at three times the cost and order 4.
    VariationalYoshida4,
}

/// For which systems without dissipation a method's map (q, p) → (q, p) is symplectic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symplectic {
    /// For none worth naming.
    Never,
    /// Where M does not depend on q.
    WhereMassIsConstant,
    /// For every M(q).
    Always,
}

impl Integrator {
    /// Every row of the table.
    pub const ALL: [Self; 5] = [
        Self::ExplicitEuler,
        Self::SemiImplicitEuler,
        Self::RungeKutta4,
        Self::VariationalMidpoint,
        Self::VariationalYoshida4,
    ];

    /// The name [`from_name`](Self::from_name) reads: lower case, words joined by `-`.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit-euler",
            Self::SemiImplicitEuler => "semi-implicit-euler",
            Self::RungeKutta4 => "rk4",
            Self::VariationalMidpoint => "variational-midpoint",
            Self::VariationalYoshida4 => "variational-yoshida4",
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
            Self::VariationalMidpoint => 2,
            Self::RungeKutta4 | Self::VariationalYoshida4 => 4,
        }
    }

    /// Whether the step's map in (q, p) preserves the symplectic form Σ dqᵢ∧dpᵢ, where b = 0. **(HLW §VI.2)**
    pub fn symplectic(self) -> Symplectic {
        match self {
            Self::ExplicitEuler | Self::RungeKutta4 => Symplectic::Never,
            Self::SemiImplicitEuler => Symplectic::WhereMassIsConstant,
            Self::VariationalMidpoint | Self::VariationalYoshida4 => Symplectic::Always,
        }
    }

    /// Whether a step, a flip of the velocity, a step and a flip lead back to the start, where b = 0.
    /// **(HLW §V.1)**
    pub fn reversible(self) -> bool {
        matches!(self, Self::VariationalMidpoint | Self::VariationalYoshida4)
    }

    /// Advances (q, q̇) by `h` \[s\] with u held.
    ///
    /// # Errors
    /// [`IntegratorError::Dynamics`] where the system has no acceleration;
    /// [`IntegratorError::NotConverged`] where an implicit method's step is too long.
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
            Self::VariationalMidpoint => variational_midpoint_step(system, q, qd, u, h),
            Self::VariationalYoshida4 => variational_yoshida4_step(system, q, qd, u, h),
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

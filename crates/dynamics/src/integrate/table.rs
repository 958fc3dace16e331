//! The table of integrators: method, order, properties.

use core::fmt;
use core::str::FromStr;

use nalgebra::SVector;

use super::explicit::explicit_step;
use super::variational::compose;
use super::{IntegratorError, Method, Stage, State};
use crate::Dynamics;

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

/// What the table says of a method.
struct Row {
    name: &'static str,
    order: u32,
    symplectic: Symplectic,
    method: Method,
}

/// The enum, its list and its look-up from the rows.
macro_rules! table {
    ($($(#[$doc:meta])* $variant:ident: $row:expr,)*) => {
        /// A method that advances (q, q̇) by one step of fixed length: a row of the table of integrators.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Integrator {
            $($(#[$doc])* $variant,)*
        }

        impl Integrator {
            /// Every row of the table.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            fn row(self) -> &'static Row {
                match self {
                    $(Self::$variant => const { &$row },)*
                }
            }
        }
    };
}

/// γ₁ of Yoshida's composition, 1/(2 − 2^{1/3}): γ₁ twice and γ₀ = 1 − 2γ₁ once cancel the error of third order.
/// **(HLW §II.4)**
const YOSHIDA_OUTER: f64 = 1.351_207_191_959_657_6;

// A row is all that a method needs: fixed-size systems, trees, batches, constrained steps and linearised steps read
// the same stages and fractions.
table! {
    /// [`explicit_euler_step`](crate::explicit_euler_step): the bad example.
    ExplicitEuler: Row {
        name: "explicit-euler",
        order: 1,
        symplectic: Symplectic::Never,
        method: Method::Explicit(&[Stage { q_row: &[], v_row: &[], q_weight: 1.0, v_weight: 1.0 }]),
    },
    /// [`semi_implicit_euler_step`](crate::semi_implicit_euler_step): what many game engines use.
    SemiImplicitEuler: Row {
        name: "semi-implicit-euler",
        order: 1,
        symplectic: Symplectic::WhereMassIsConstant,
        // q moves by the velocity after the step.
        method: Method::Explicit(&[
            Stage { q_row: &[], v_row: &[], q_weight: 0.0, v_weight: 1.0 },
            Stage { q_row: &[], v_row: &[1.0], q_weight: 1.0, v_weight: 0.0 },
        ]),
    },
    /// [`rk4_step`](crate::rk4_step): the all-rounder.
    RungeKutta4: Row {
        name: "rk4",
        order: 4,
        symplectic: Symplectic::Never,
        method: Method::Explicit(&[
            Stage { q_row: &[], v_row: &[], q_weight: 1.0 / 6.0, v_weight: 1.0 / 6.0 },
            Stage { q_row: &[0.5], v_row: &[0.5], q_weight: 1.0 / 3.0, v_weight: 1.0 / 3.0 },
            Stage { q_row: &[0.0, 0.5], v_row: &[0.0, 0.5], q_weight: 1.0 / 3.0, v_weight: 1.0 / 3.0 },
            Stage { q_row: &[0.0, 0.0, 1.0], v_row: &[0.0, 0.0, 1.0], q_weight: 1.0 / 6.0, v_weight: 1.0 / 6.0 },
        ]),
    },
    /// [`variational_midpoint_step`](crate::variational_midpoint_step): keeps the structure, for long runs.
    VariationalMidpoint: Row {
        name: "variational-midpoint",
        order: 2,
        symplectic: Symplectic::Always,
        method: Method::Variational(&[1.0]),
    },
    /// [`variational_yoshida4_step`](crate::variational_yoshida4_step): keeps the structure, at three times the cost
    /// and order 4.
    VariationalYoshida4: Row {
        name: "variational-yoshida4",
        order: 4,
        symplectic: Symplectic::Always,
        method: Method::Variational(&[YOSHIDA_OUTER, 1.0 - 2.0 * YOSHIDA_OUTER, YOSHIDA_OUTER]),
    },
}

impl Integrator {
    /// The name [`from_name`](Self::from_name) reads: lower case, words joined by `-`.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// assert!(Integrator::ALL.iter().all(|row| Integrator::from_name(row.name()) == Ok(*row)));
    /// ```
    pub fn name(self) -> &'static str {
        self.row().name
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
        let mut rows = Self::ALL.into_iter();
        rows.find(|row| row.name() == name)
            .ok_or_else(|| IntegratorError::UnknownName { name: name.to_owned() })
    }

    /// The order p: the error at a fixed time is O(hᵖ).
    ///
    /// ```
    /// use dynamics::Integrator;
    /// assert_eq!((Integrator::VariationalMidpoint.order(), Integrator::VariationalYoshida4.order()), (2, 4));
    /// ```
    pub fn order(self) -> u32 {
        self.row().order
    }

    /// Whether the step's map in (q, p) preserves the symplectic form Σ dqᵢ∧dpᵢ, where b = 0. **(HLW §VI.2)**
    ///
    /// ```
    /// use dynamics::{Integrator, Symplectic};
    /// assert_eq!(Integrator::VariationalMidpoint.symplectic(), Symplectic::Always);
    /// assert_eq!(Integrator::RungeKutta4.symplectic(), Symplectic::Never);
    /// ```
    pub fn symplectic(self) -> Symplectic {
        self.row().symplectic
    }

    /// Whether a step, a flip of the velocity, a step and a flip lead back to the start, where b = 0:
    /// symmetric compositions of the midpoint do, explicit stages do not. **(HLW §V.1)**
    ///
    /// ```
    /// use dynamics::Integrator;
    /// assert!(Integrator::VariationalMidpoint.reversible() && !Integrator::RungeKutta4.reversible());
    /// ```
    pub fn reversible(self) -> bool {
        matches!(self.method(), Method::Variational(_))
    }

    /// Whether a step is made of explicit stages: no equation is solved, nothing can fail to converge.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// assert!(Integrator::RungeKutta4.is_explicit() && !Integrator::VariationalMidpoint.is_explicit());
    /// ```
    pub fn is_explicit(self) -> bool {
        matches!(self.method(), Method::Explicit(_))
    }

    /// What a step is made of.
    ///
    /// ```
    /// use dynamics::{Integrator, Method};
    /// let Method::Explicit(stages) = Integrator::RungeKutta4.method() else { panic!() };
    /// assert_eq!(stages.len(), 4);
    /// ```
    pub fn method(self) -> Method {
        self.row().method
    }

    /// Advances (q, q̇) by `h` \[s\] with u held.
    ///
    /// ```
    /// use dynamics::{Integrator, PlanarBody};
    /// use nalgebra::{Vector3, vector};
    /// // A stone let go falls ½ g t², which every row of order 2 or more has exactly.
    /// let (stone, rest) = (PlanarBody { m: 2.0, i_zz: 0.1, a_g: 9.81 }, Vector3::zeros());
    /// for row in Integrator::ALL.into_iter().filter(|row| row.order() >= 2) {
    ///     let (q, qd) = row.step(&stone, &rest, &rest, &rest, 0.1)?;
    ///     assert!((q - vector![0.0, -0.5 * 9.81 * 0.01, 0.0]).norm() < 1e-14);
    ///     assert!((qd - vector![0.0, -0.981, 0.0]).norm() < 1e-14);
    /// }
    /// # Ok::<(), dynamics::IntegratorError>(())
    /// ```
    ///
    /// # Errors
    /// [`IntegratorError::Dynamics`] where the system has no acceleration;
    /// [`IntegratorError::NotConverged`] where an implicit method's step is too long.
    ///
    /// # Panics
    /// If `h` is not positive and finite.
    #[track_caller]
    pub fn step<D: Dynamics<N> + ?Sized, const N: usize>(
        self,
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
        u: &SVector<f64, N>,
        h: f64,
    ) -> Result<State<N>, IntegratorError> {
        match self.method() {
            Method::Explicit(stages) => {
                Ok(explicit_step(stages, q, qd, h, |q, qd| system.try_forward(q, qd, u))?)
            }
            Method::Variational(fractions) => compose(system, q, qd, u, h, fractions),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What every consumer of a row relies on: a stage leans on those before it, weights make one step.
    /// Sums of a few fractions: 4 ε.
    #[test]
    fn rows_are_consistent() {
        let is_one = |sum: f64| (sum - 1.0).abs() <= 4.0 * f64::EPSILON;
        for row in Integrator::ALL {
            match row.method() {
                Method::Explicit(stages) => {
                    assert!(stages.len() <= Stage::MOST, "{row} has {} stages", stages.len());
                    for (i, stage) in stages.iter().enumerate() {
                        assert!(stage.q_row.len() <= i && stage.v_row.len() <= i, "{row}: stage {i}");
                    }
                    assert!(is_one(stages.iter().map(|stage| stage.q_weight).sum()), "{row}");
                    assert!(is_one(stages.iter().map(|stage| stage.v_weight).sum()), "{row}");
                }
                Method::Variational(fractions) => {
                    assert!(is_one(fractions.iter().sum()), "{row}");
                    assert!(fractions.iter().eq(fractions.iter().rev()), "{row} is symmetric");
                }
            }
        }
        // As a test reads it: 2γ₁³ + γ₀³ = 0.
        let (outer, inner) = (YOSHIDA_OUTER, 1.0 - 2.0 * YOSHIDA_OUTER);
        assert!((2.0 * outer.powi(3) + inner.powi(3)).abs() < 1e-14);
        assert!((outer - 1.0 / (2.0 - 2f64.cbrt())).abs() <= 2.0 * f64::EPSILON);
    }
}

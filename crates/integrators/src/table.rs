//! The table of integrators: method, order, properties.

use crate::{Stage, StepScheme};

/// The systems without dissipation for which a method's map (q, p) → (q, p) is symplectic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symplectic {
    /// None of practical interest.
    Never,
    /// Systems with constant M.
    WhereMassIsConstant,
    /// Systems with any M(q).
    Always,
}

/// The properties of a method.
struct MethodRow {
    name: &'static str,
    order: u32,
    symplectic: Symplectic,
    scheme: StepScheme,
}

/// Generates the enum, its list and its look-up from the rows.
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

            fn row(self) -> &'static MethodRow {
                match self {
                    $(Self::$variant => const { &$row },)*
                }
            }
        }
    };
}

/// γ₁ of Yoshida's composition, 1/(2 − 2^{1/3}): γ₁ twice and γ₀ = 1 − 2γ₁ once cancel the error of third
/// order. **(HLW §II.4)**
const YOSHIDA_OUTER: f64 = 1.351_207_191_959_657_6;

// A row defines the method completely: fixed-size systems, trees, batches, constrained steps and linearized
// steps use the same stages and fractions.
table! {
    /// `explicit_euler_step`: for comparison only, because its energy grows.
    ExplicitEuler: MethodRow {
        name: "explicit-euler",
        order: 1,
        symplectic: Symplectic::Never,
        scheme: StepScheme::Explicit(&[Stage { q_row: &[], v_row: &[], q_weight: 1.0, v_weight: 1.0 }]),
    },
    /// `semi_implicit_euler_step`, as in many game engines.
    SemiImplicitEuler: MethodRow {
        name: "semi-implicit-euler",
        order: 1,
        symplectic: Symplectic::WhereMassIsConstant,
        // q moves with the velocity at the end of the step.
        scheme: StepScheme::Explicit(&[
            Stage { q_row: &[], v_row: &[], q_weight: 0.0, v_weight: 1.0 },
            Stage { q_row: &[], v_row: &[1.0], q_weight: 1.0, v_weight: 0.0 },
        ]),
    },
    /// `rk4_step`: the general-purpose method.
    RungeKutta4: MethodRow {
        name: "rk4",
        order: 4,
        symplectic: Symplectic::Never,
        scheme: StepScheme::Explicit(&[
            Stage { q_row: &[], v_row: &[], q_weight: 1.0 / 6.0, v_weight: 1.0 / 6.0 },
            Stage { q_row: &[0.5], v_row: &[0.5], q_weight: 1.0 / 3.0, v_weight: 1.0 / 3.0 },
            Stage { q_row: &[0.0, 0.5], v_row: &[0.0, 0.5], q_weight: 1.0 / 3.0, v_weight: 1.0 / 3.0 },
            Stage { q_row: &[0.0, 0.0, 1.0], v_row: &[0.0, 0.0, 1.0], q_weight: 1.0 / 6.0, v_weight: 1.0 / 6.0 },
        ]),
    },
    /// `variational_midpoint_step`: preserves the structure, for long runs.
    VariationalMidpoint: MethodRow {
        name: "variational-midpoint",
        order: 2,
        symplectic: Symplectic::Always,
        scheme: StepScheme::Variational(&[1.0]),
    },
    /// `variational_yoshida4_step`: preserves the structure with order 4, at three times the cost.
    VariationalYoshida4: MethodRow {
        name: "variational-yoshida4",
        order: 4,
        symplectic: Symplectic::Always,
        scheme: StepScheme::Variational(&[YOSHIDA_OUTER, 1.0 - 2.0 * YOSHIDA_OUTER, YOSHIDA_OUTER]),
    },
}

impl Integrator {
    /// The name that [`from_name`](Self::from_name) parses: lower case, words joined by `-`.
    ///
    /// ```
    /// use robot_dynamics_integrators::Integrator;
    /// assert!(Integrator::ALL.iter().all(|row| Integrator::from_name(row.name()) == Ok(*row)));
    /// ```
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The order p: the error at a fixed time is O(hᵖ).
    ///
    /// ```
    /// use robot_dynamics_integrators::Integrator;
    /// assert_eq!((Integrator::VariationalMidpoint.order(), Integrator::VariationalYoshida4.order()), (2, 4));
    /// ```
    pub fn order(self) -> u32 {
        self.row().order
    }

    /// Whether the step's map in (q, p) preserves the symplectic form Σ dqᵢ∧dpᵢ for b = 0. **(HLW §VI.2)**
    ///
    /// ```
    /// use robot_dynamics_integrators::{Integrator, Symplectic};
    /// assert_eq!(Integrator::VariationalMidpoint.symplectic(), Symplectic::Always);
    /// assert_eq!(Integrator::RungeKutta4.symplectic(), Symplectic::Never);
    /// ```
    pub fn symplectic(self) -> Symplectic {
        self.row().symplectic
    }

    /// Whether a step, a reversal of the velocity, another step and another reversal return to the start for
    /// b = 0. Symmetric compositions of the midpoint do; explicit stages do not. **(HLW §V.1)**
    ///
    /// ```
    /// use robot_dynamics_integrators::Integrator;
    /// assert!(Integrator::VariationalMidpoint.reversible() && !Integrator::RungeKutta4.reversible());
    /// ```
    pub fn reversible(self) -> bool {
        matches!(self.scheme(), StepScheme::Variational(_))
    }

    /// Whether a step consists of explicit stages: it solves no equation, so it always converges.
    ///
    /// ```
    /// use robot_dynamics_integrators::Integrator;
    /// assert!(Integrator::RungeKutta4.is_explicit() && !Integrator::VariationalMidpoint.is_explicit());
    /// ```
    pub fn is_explicit(self) -> bool {
        matches!(self.scheme(), StepScheme::Explicit(_))
    }

    /// The composition of a step.
    ///
    /// ```
    /// use robot_dynamics_integrators::{Integrator, StepScheme};
    /// let StepScheme::Explicit(stages) = Integrator::RungeKutta4.scheme() else { panic!() };
    /// assert_eq!(stages.len(), 4);
    /// ```
    pub fn scheme(self) -> StepScheme {
        self.row().scheme
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The properties that every row must have: a stage depends only on earlier ones, and the weights add up
    /// to one step. Sums of a few fractions have an error below 4 ε.
    #[test]
    fn rows_are_consistent() {
        let is_one = |sum: f64| (sum - 1.0).abs() <= 4.0 * f64::EPSILON;
        for row in Integrator::ALL {
            match row.scheme() {
                StepScheme::Explicit(stages) => {
                    assert!(stages.len() <= Stage::MOST, "{row} has {} stages", stages.len());
                    for (i, stage) in stages.iter().enumerate() {
                        assert!(stage.q_row.len() <= i && stage.v_row.len() <= i, "{row}: stage {i}");
                    }
                    assert!(is_one(stages.iter().map(|stage| stage.q_weight).sum()), "{row}");
                    assert!(is_one(stages.iter().map(|stage| stage.v_weight).sum()), "{row}");
                }
                StepScheme::Variational(fractions) => {
                    assert!(is_one(fractions.iter().sum()), "{row}");
                    assert!(fractions.iter().eq(fractions.iter().rev()), "{row} is symmetric");
                }
            }
        }
        // The order condition: 2γ₁³ + γ₀³ = 0.
        let (outer, inner) = (YOSHIDA_OUTER, 1.0 - 2.0 * YOSHIDA_OUTER);
        assert!((2.0 * outer.powi(3) + inner.powi(3)).abs() < 1e-14);
        assert!((outer - 1.0 / (2.0 - 2f64.cbrt())).abs() <= 2.0 * f64::EPSILON);
    }
}

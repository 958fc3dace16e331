//! Options of constrained motions.

use robot_dynamics_integrators::Integrator;
use robot_dynamics_number::{InvalidInput, check_number};

/// The treatment of rows that depend on other rows.
///
/// The acceleration is the same in every case; only λ is not determined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RedundantRows {
    /// Solve with the independent rows; λ of the dependent ones is 0. The result names them.
    #[default]
    Drop,
    /// Report an error that names them.
    Refuse,
    /// The λ of least Euclidean length among all solutions. Its proximal steps are (Λ + μ) (λ₊ − λ) = target
    /// − A a₀ − Λλ from λ = 0. Here Λ = A M⁻¹Aᵀ and μ = `damping` · tr Λ/K. Source: Carpentier, Budhiraja,
    /// Mansard, *Proximal and sparse resolution of constrained dynamic equations*, RSS (2021).
    Proximal {
        /// μ as a fraction of the mean diagonal entry of Λ; 1e-6 is a good choice.
        damping: f64,
    },
}

/// Stabilizing feedback: A a = −Ȧv − 2γ A v − γ² φ, so that φ decays like e^(−γt).
///
/// Source: Baumgarte, *Stabilization of constraints and integrals of motion in dynamical systems* (1972).
/// An explicit step of h needs γ below about 2/h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baumgarte {
    /// γ \[1/s\].
    pub rate: f64,
}

/// Options of constrained motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintOptions {
    /// The treatment of dependent rows.
    pub redundant: RedundantRows,
    /// Feedback on the drift; none by default.
    pub stabilization: Option<Baumgarte>,
    /// A row whose part independent of the earlier rows is below this fraction of its length (both in M⁻¹)
    /// counts as dependent. Must be above the drift of a redundant loop, which makes its rows differ.
    pub dependence: f64,
    /// The method of [`constrained_step`](super::constrained_step): `rk4`, `variational-midpoint` or
    /// `variational-yoshida4`.
    pub integrator: Integrator,
}

impl ConstraintOptions {
    /// Options for loops and couplings of robot files. Planar loops have redundant rows, which are left out;
    /// they agree to about the six digits that angles in files have.
    ///
    /// ```
    /// use robot_dynamics::constraints::{ConstraintOptions, RedundantRows};
    /// let options = ConstraintOptions::of_files();
    /// assert_eq!((options.redundant, options.dependence), (RedundantRows::Drop, 1e-5));
    /// ```
    pub fn of_files() -> Self {
        Self { redundant: RedundantRows::Drop, dependence: 1e-5, ..Self::default() }
    }

    /// Returns an error if an option is not finite.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        check_number("the dependence", self.dependence)?;
        if let Some(Baumgarte { rate }) = self.stabilization {
            check_number("Baumgarte's rate", rate)?;
        }
        match self.redundant {
            RedundantRows::Proximal { damping } => check_number("the proximal damping", damping),
            RedundantRows::Drop | RedundantRows::Refuse => Ok(()),
        }
    }
}

impl Default for ConstraintOptions {
    fn default() -> Self {
        Self {
            redundant: RedundantRows::default(),
            stabilization: None,
            dependence: 1e-9,
            integrator: Integrator::RungeKutta4,
        }
    }
}

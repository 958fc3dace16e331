//! How constrained motions are computed.

use dynamics::Integrator;

use super::ConstrainedMotionError;
use super::error::check_number;

/// What to do with rows that depend on other rows.
///
/// The acceleration is the same in every case; only λ is not determined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RedundantRows {
    /// Solve with the independent rows; λ of the dependent ones is 0. They are named in the result.
    #[default]
    Drop,
    /// Report an error that names them.
    Refuse,
    /// The λ of least Euclidean length among all solutions, by proximal steps
    /// (Λ + μ) (λ₊ − λ) = target − A a₀ − Λλ from λ = 0, Λ = A M⁻¹Aᵀ, μ = `damping` · tr Λ/K.
    /// Source: Carpentier, Budhiraja, Mansard, *Proximal and sparse resolution of constrained dynamic
    /// equations*, RSS (2021).
    Proximal {
        /// μ as a fraction of the mean diagonal entry of Λ; 1e-6 is a good choice.
        damping: f64,
    },
}

/// Feedback that pulls a motion back: A a = −Ȧv − 2γ A v − γ² φ, so that φ decays like e^(−γt).
///
/// Source: Baumgarte, *Stabilization of constraints and integrals of motion in dynamical systems* (1972).
/// An explicit step of h needs γ below about 2/h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baumgarte {
    /// γ \[1/s\].
    pub rate: f64,
}

/// How constrained motions are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintOptions {
    /// What to do with dependent rows.
    pub redundant: RedundantRows,
    /// Feedback on the drift; none by default.
    pub stabilization: Option<Baumgarte>,
    /// A row whose part independent of the earlier rows is below this fraction of its length (both in M⁻¹)
    /// counts as dependent. Must be above the drift of a redundant loop, which makes its rows differ.
    pub dependence: f64,
    /// Which step [`constrained_step`](super::constrained_step) takes: `rk4`, `variational-midpoint` or
    /// `variational-yoshida4`.
    pub integrator: Integrator,
}

impl ConstraintOptions {
    /// For loops and couplings of robots' files: planar loops have rows that say the same, which are left out, to the six digits or so
    /// that angles in files have.
    ///
    /// ```
    /// use multibody::{ConstraintOptions, RedundantRows};
    /// let options = ConstraintOptions::of_files();
    /// assert_eq!((options.redundant, options.dependence), (RedundantRows::Drop, 1e-5));
    /// ```
    pub fn of_files() -> Self {
        Self { redundant: RedundantRows::Drop, dependence: 1e-5, ..Self::default() }
    }

    /// Refuses an option that is not finite.
    pub(super) fn check(&self) -> Result<(), ConstrainedMotionError> {
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

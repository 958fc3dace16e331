//! The methods of adaptive steps, and the choice between them.

use differential_equations::methods::{DiagonallyImplicitRungeKutta, ExplicitRungeKutta};
use differential_equations::ode::OrdinaryNumericalMethod;
use differential_equations::prelude::{Interpolation, Status};
use robot_dynamics_core::{Model, Workspace, inverse_mass_matrix};

use super::motion::AdaptiveSystem;

/// Threshold of max D_kk (M⁻¹)_kk above which implicit steps are chosen \[1/s\]. Explicit steps of order 9
/// are stable up to about 4/rate. Below half a millisecond they cost more in total than implicit steps.
const STIFF: f64 = 1e4;

/// Newton's method stops at a change below this fraction of the tolerance, or below rounding.
const NEWTON: (f64, f64) = (1e-2, 1e-13);

/// The method of adaptive steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdaptiveMethod {
    /// Implicit if the damping D and M at the start give max D_kk (M⁻¹)_kk > 10⁴/s; otherwise explicit.
    #[default]
    Automatic,
    /// Verner's explicit Runge–Kutta pair of orders 9 and 8, with a polynomial of order 9 over each step. The
    /// longest stable step is about four times the time constant of the stiffest damping.
    ///
    /// Source: Verner, *Numerically optimal Runge–Kutta pairs with interpolants*, Numerical Algorithms 53
    /// (2010).
    Explicit,
    /// Kværnø's singly diagonally implicit Runge–Kutta pair of orders 5 and 4. It is L-stable: damping and
    /// springs, including a controller's, may be arbitrarily stiff. The interpolant over each step is the
    /// cubic Hermite polynomial. Each stage computes a Jacobian by finite differences, so a step costs more
    /// than an explicit one, and tight tolerances require more steps.
    ///
    /// Source: Kværnø, *Singly diagonally implicit Runge–Kutta methods with an explicit first stage*, BIT 44
    /// (2004).
    Implicit,
}

impl AdaptiveMethod {
    /// Resolves `Automatic` for a run that starts at q.
    pub(super) fn chosen(self, model: &Model, workspace: &mut Workspace, q: &[f64], damping: bool) -> Self {
        match self {
            Self::Automatic if damping && fastest_damping(model, workspace, q) > STIFF => Self::Implicit,
            Self::Automatic => Self::Explicit,
            chosen => chosen,
        }
    }

    /// Creates the method with this tolerance, |error| ≤ tolerance (1 + |y|), and its first step; 0 selects
    /// the first step automatically.
    pub(super) fn start(self, tolerance: f64, first_step: f64) -> Box<dyn Steps> {
        // The caller counts steps and rejections.
        if self == Self::Implicit {
            let pair =
                DiagonallyImplicitRungeKutta::kvaerno745().newton_tol((NEWTON.0 * tolerance).max(NEWTON.1));
            let pair = pair.rtol(tolerance).atol(tolerance).h0(first_step);
            return Box::new(pair.max_steps(usize::MAX).max_rejects(usize::MAX));
        }
        let pair = ExplicitRungeKutta::rkv989e().rtol(tolerance).atol(tolerance).h0(first_step);
        Box::new(pair.max_steps(usize::MAX).max_rejects(usize::MAX))
    }

    /// The order of the method.
    pub fn order(self) -> u32 {
        if self == Self::Implicit { 5 } else { 9 }
    }
}

/// max D_kk (M⁻¹)_kk: the fastest decay rate of a coordinate while all others are fixed \[1/s\].
fn fastest_damping(model: &Model, workspace: &mut Workspace, q: &[f64]) -> f64 {
    let n = model.nv;
    let mut damping = vec![0.0; n];
    for dof in &model.dofs {
        damping[dof.coordinate] += dof.ratio * dof.ratio * dof.passive.damping;
    }
    if damping.iter().all(|damping| *damping == 0.0) {
        return 0.0;
    }
    let mut inverse = vec![0.0; n * n];
    inverse_mass_matrix(model, workspace, q, &mut inverse);
    (0..n).map(|k| damping[k] * inverse[k * n + k]).fold(0.0, f64::max)
}

/// The interface of a method to the run.
#[allow(clippy::ptr_arg)] // the state type of the methods
pub(super) trait Steps {
    /// Starts at y(t); returns false if the rate is not finite.
    fn begin(&mut self, motion: &AdaptiveSystem<'_, '_>, t: f64, end: f64, y: &Vec<f64>) -> bool;
    /// Attempts a step of h; returns false if the method fails.
    fn step(&mut self, motion: &AdaptiveSystem<'_, '_>, h: f64) -> bool;
    /// Whether the last step was rejected.
    fn is_rejected(&self) -> bool;
    /// The proposed next step \[s\].
    fn h(&self) -> f64;
    /// The current time.
    fn t(&self) -> f64;
    fn y(&self) -> &Vec<f64>;
    /// The start of the last step.
    fn t_before(&self) -> f64;
    fn y_before(&self) -> &Vec<f64>;
    /// Interpolates y inside the last step.
    fn inside(&mut self, t: f64) -> Option<Vec<f64>>;
}

impl<M: OrdinaryNumericalMethod<f64, Vec<f64>> + Interpolation<f64, Vec<f64>>> Steps for M {
    fn begin(&mut self, motion: &AdaptiveSystem<'_, '_>, t: f64, end: f64, y: &Vec<f64>) -> bool {
        self.init(motion, t, end, y).is_ok()
    }

    fn step(&mut self, motion: &AdaptiveSystem<'_, '_>, h: f64) -> bool {
        self.set_h(h);
        OrdinaryNumericalMethod::step(self, motion).is_ok()
    }

    fn is_rejected(&self) -> bool {
        matches!(self.status(), Status::RejectedStep)
    }

    fn h(&self) -> f64 {
        OrdinaryNumericalMethod::h(self)
    }

    fn t(&self) -> f64 {
        OrdinaryNumericalMethod::t(self)
    }

    fn y(&self) -> &Vec<f64> {
        OrdinaryNumericalMethod::y(self)
    }

    fn t_before(&self) -> f64 {
        self.t_prev()
    }

    fn y_before(&self) -> &Vec<f64> {
        self.y_prev()
    }

    fn inside(&mut self, t: f64) -> Option<Vec<f64>> {
        self.interpolate(t).ok()
    }
}

//! The methods that adaptive steps are taken by, and which one a robot needs.

use differential_equations::methods::{DiagonallyImplicitRungeKutta, ExplicitRungeKutta};
use differential_equations::ode::OrdinaryNumericalMethod;
use differential_equations::prelude::{Interpolation, Status};

use super::motion::Motion;
use crate::{Model, Workspace, inverse_mass_matrix};

/// Damping that slows a joint faster than this asks for implicit steps \[1/s\]: explicit ones of order 9 stay stable up to some 4/rate,
/// and below half a millisecond they are as many as to cost more than implicit ones.
const STIFF: f64 = 1e4;

/// Newton's method ends where it moves by less than this part of the tolerance, or by rounding.
const NEWTON: (f64, f64) = (1e-2, 1e-13);

/// How an adaptive run takes its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdaptiveMethod {
    /// Implicit where the start's M and the joints' damping D ask for it, max D_kk (M⁻¹)_kk > 10⁴/s; else explicit.
    #[default]
    Automatic,
    /// Verner's explicit Runge–Kutta pair of orders 9 and 8, with a polynomial of order 9 over each step. Its steps are at most some
    /// four times as long as the time in which the stiffest damping acts.
    ///
    /// Source: Verner, *Numerically optimal Runge–Kutta pairs with interpolants*, Numerical Algorithms 53 (2010).
    Explicit,
    /// Kværnø's singly diagonally implicit Runge–Kutta pair of orders 5 and 4, L-stable: damping and springs, a controller's, too, may be as
    /// stiff as they like. Over each step there is Hermite's cubic. Each stage has a Jacobian by differences, so that a step costs more, and
    /// tight tolerances ask for more steps.
    ///
    /// Source: Kværnø, *Singly diagonally implicit Runge–Kutta methods with an explicit first stage*, BIT 44 (2004).
    Implicit,
}

impl AdaptiveMethod {
    /// Which of the two it is for a run from q.
    pub(super) fn chosen(self, model: &Model, workspace: &mut Workspace, q: &[f64], damping: bool) -> Self {
        match self {
            Self::Automatic if damping && fastest_damping(model, workspace, q) > STIFF => Self::Implicit,
            Self::Automatic => Self::Explicit,
            chosen => chosen,
        }
    }

    /// The method with this tolerance, |error| ≤ tolerance (1 + |y|), and its first step, or 0 to find one.
    pub(super) fn start(self, tolerance: f64, first_step: f64) -> Box<dyn Steps> {
        // Steps and rejections are counted where the steps are taken.
        if self == Self::Implicit {
            let pair =
                DiagonallyImplicitRungeKutta::kvaerno745().newton_tol((NEWTON.0 * tolerance).max(NEWTON.1));
            let pair = pair.rtol(tolerance).atol(tolerance).h0(first_step);
            return Box::new(pair.max_steps(usize::MAX).max_rejects(usize::MAX));
        }
        let pair = ExplicitRungeKutta::rkv989e().rtol(tolerance).atol(tolerance).h0(first_step);
        Box::new(pair.max_steps(usize::MAX).max_rejects(usize::MAX))
    }

    /// Its order.
    pub fn order(self) -> u32 {
        if self == Self::Implicit { 5 } else { 9 }
    }
}

/// max D_kk (M⁻¹)_kk: how fast damping slows a coordinate that nothing else moves \[1/s\].
fn fastest_damping(model: &Model, workspace: &mut Workspace, q: &[f64]) -> f64 {
    let n = model.nv;
    let mut damping = vec![0.0; n];
    for freedom in &model.dofs {
        damping[freedom.coordinate] += freedom.ratio * freedom.ratio * freedom.passive.damping;
    }
    if damping.iter().all(|damping| *damping == 0.0) {
        return 0.0;
    }
    let mut inverse = vec![0.0; n * n];
    inverse_mass_matrix(model, workspace, q, &mut inverse);
    (0..n).map(|k| damping[k] * inverse[k * n + k]).fold(0.0, f64::max)
}

/// What a run asks of its method.
#[allow(clippy::ptr_arg)] // the methods' type of state
pub(super) trait Steps {
    /// Begins at y(t); false where there is no rate.
    fn begin(&mut self, motion: &Motion<'_, '_>, t: f64, end: f64, y: &Vec<f64>) -> bool;
    /// Tries a step of h; false where the method gives up.
    fn step(&mut self, motion: &Motion<'_, '_>, h: f64) -> bool;
    /// Whether the step was taken back.
    fn is_rejected(&self) -> bool;
    /// The step that it would take next \[s\].
    fn h(&self) -> f64;
    /// Where it is.
    fn t(&self) -> f64;
    fn y(&self) -> &Vec<f64>;
    /// Where the last step began.
    fn t_before(&self) -> f64;
    fn y_before(&self) -> &Vec<f64>;
    /// y inside the last step.
    fn inside(&mut self, t: f64) -> Option<Vec<f64>>;
}

impl<M: OrdinaryNumericalMethod<f64, Vec<f64>> + Interpolation<f64, Vec<f64>>> Steps for M {
    fn begin(&mut self, motion: &Motion<'_, '_>, t: f64, end: f64, y: &Vec<f64>) -> bool {
        self.init(motion, t, end, y).is_ok()
    }

    fn step(&mut self, motion: &Motion<'_, '_>, h: f64) -> bool {
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

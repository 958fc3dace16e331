//! The tolerances and iteration limits of the contact solver.

/// Tolerances and iteration limits of [`ConeProblem`](super::ConeProblem).
///
/// Errors are relative, because the solver does not know the units of its rows. An error of a multiplier or
/// of a shift is a fraction of `ConeProblem::speed`, the largest speed in the problem. A decrease is a
/// fraction of the energy that `ConeProblem::find_slope` returns. It is of second order in the error of x, so
/// its tolerances are about the squares of those of the velocities.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolverTolerances {
    /// R of a block, as a fraction of the velocity that a unit impulse on its first row causes \[-\].
    ///
    /// A small R lets p̄ converge in few outer iterations. H has a condition number of about 1/R times that
    /// of M, so R stays well above the rounding error 1e-16.
    pub(super) relative_softness: f64,
    /// Most outer iterations (updates of p̄ and s) of one solution \[-\].
    ///
    /// The limit bounds the time of a step that does not converge.
    pub(super) outer_iterations: usize,
    /// Most Newton steps in one outer iteration \[-\].
    ///
    /// The limit bounds the time of a step that does not converge.
    pub(super) newton_steps: usize,
    /// Most outer iterations that update s \[-\]; if none of them converges, s is kept or set to 0.
    ///
    /// Half of `outer_iterations` is left for the multipliers.
    pub(super) shift_iterations: usize,
    /// Outer iterations whose Newton's method may stop before the last digit \[-\].
    ///
    /// p̄ and s still change much in the first iterations, so digits beyond that change are wasted.
    pub(super) inexact_iterations: usize,
    /// After every so many outer iterations, c and M x + f are recomputed from x \[-\].
    ///
    /// Rounding errors of their updates do not accumulate over more than four iterations.
    pub(super) recompute_period: usize,
    /// Largest error of p̄ in a solution, as a fraction of the speed \[-\].
    ///
    /// It is 1e5 times the rounding error, as H has a condition number of about 1e5 times that of M.
    pub(super) multiplier_error: f64,
    /// Largest error of p̄ in an outer iteration that reduces the error by less than half \[-\].
    ///
    /// This one and `slow_multiplier_error` are fractions of the speed at the beginning of the solution.
    /// Multipliers of redundant rows grow without bound, and must not increase the tolerance.
    pub(super) stalled_multiplier_error: f64,
    /// The same after `slow_iterations` of such iterations \[-\].
    pub(super) slow_multiplier_error: f64,
    /// Consecutive slow outer iterations after which `slow_multiplier_error` applies \[-\].
    pub(super) slow_iterations: usize,
    /// Largest error of s in a solution while Newton's method updates s, as a fraction of the speed \[-\].
    ///
    /// Newton's method converges quadratically, so a strict tolerance costs at most one iteration.
    pub(super) shift_error: f64,
    /// The same while the fixed-point iteration updates s \[-\].
    ///
    /// That iteration converges linearly, so the tolerance is ten times as large.
    pub(super) fixed_point_shift_error: f64,
    /// Largest error of s, after `shift_iterations`, with which s is kept, as a fraction of the speed \[-\].
    ///
    /// With a larger error, s = 0: the solution of the convex problem, without Coulomb's law.
    pub(super) accepted_shift_error: f64,
    /// Largest error of s, as a fraction of the speed, from which p̄ is predicted with the new s \[-\].
    ///
    /// The prediction is linear: farther away, contacts change between sticking and sliding.
    pub(super) prediction_range: f64,
    /// Fixed-point iterations after the first failure of Newton's method for s; the number doubles with each
    /// failure \[-\].
    ///
    /// Anderson's extrapolation needs three iterates.
    pub(super) fixed_point_iterations: usize,
    /// Smallest relative determinant of the least-squares problem of Anderson's extrapolation \[-\].
    ///
    /// Below it, the angle between the two differences is less than 1e-4, and only one of them is used.
    pub(super) extrapolation_determinant: f64,
    /// Relative decrease below which a Newton step changes no significant digit of the velocities \[-\].
    ///
    /// It is the square of a velocity error of 1e-11.
    pub(super) decrease: f64,
    /// Relative decrease that ends an inexact outer iteration, as a fraction of that of its first step \[-\].
    ///
    /// Such a run reduces the error of x by about 1e3, the square root.
    pub(super) inexact_decrease_ratio: f64,
    /// Largest relative decrease that ends an inexact outer iteration \[-\].
    ///
    /// It is the square of a velocity error of 1e-6.
    pub(super) inexact_decrease: f64,
    /// Part of the remaining decrease that one step with an older factor is sure to take \[-\].
    ///
    /// Such a step must gain less by this factor before its gain ends the iteration.
    pub(super) old_factor_decrease: f64,
    /// Ratio of two successive decreases below which the older factor is used again \[-\].
    ///
    /// The steps then converge without another factorization.
    pub(super) reuse_ratio: f64,
    /// Largest relative decrease of a step after which the factor counts as that of the present x \[-\].
    ///
    /// Newton's method for s uses derivatives from this factor, whose error is the square root: 1e-5.
    pub(super) fresh_factor_decrease: f64,
    /// Estimated ratio of the next decrease to this one, with the factor of the present x \[-\].
    pub(super) fresh_factor_ratio: f64,
    /// Largest estimate of that ratio on which the solver relies to skip the next step \[-\].
    pub(super) trusted_ratio: f64,
    /// Derivative at the full Newton step, as a fraction of that at its start, below which the step is taken
    /// \[-\].
    ///
    /// Newton's method needs no exact search: its next step corrects the rest.
    pub(super) step_slope: f64,
    /// The same at the end of the line search \[-\].
    pub(super) search_slope: f64,
    /// Most times that the line search doubles the step \[-\]: 2⁶⁰ reaches any minimum within the digits of a
    /// double.
    pub(super) step_doublings: usize,
    /// Most steps of regula falsi in the line search \[-\].
    ///
    /// The Illinois variant converges superlinearly; the limit bounds the time if rounding prevents that.
    pub(super) regula_falsi_steps: usize,
    /// Relative distance of a multiplier from a bound or a cone that counts as rounding \[-\].
    pub(super) bound_rounding: f64,
    /// Most Gauss-Seidel sweeps \[-\].
    ///
    /// A problem that needs more, such as a high stack, is left to Newton's method.
    pub(super) sweeps: usize,
    /// Change of a velocity that ends the sweeps, as a fraction of the largest velocity \[-\].
    ///
    /// Newton's method converges from there in a few steps.
    pub(super) sweep_change: f64,
    /// Largest change in the last sweep with which its result replaces the previous p̄ and s \[-\].
    pub(super) accepted_sweep_change: f64,
    /// Most iterations for the impulse of one sliding contact \[-\].
    pub(super) slip_iterations: usize,
    /// Change of that impulse that ends them, as a fraction of its normal component \[-\].
    ///
    /// It is 1e-3 of `sweep_change`, so that it does not limit the sweeps.
    pub(super) slip_change: f64,
}

/// The tolerances of every solution.
pub(super) const TOLERANCES: SolverTolerances = SolverTolerances {
    relative_softness: 1e-5,
    outer_iterations: 60,
    newton_steps: 60,
    shift_iterations: 30,
    inexact_iterations: 8,
    recompute_period: 4,
    multiplier_error: 1e-11,
    stalled_multiplier_error: 1e-7,
    slow_multiplier_error: 1e-6,
    slow_iterations: 4,
    shift_error: 1e-10,
    fixed_point_shift_error: 1e-9,
    accepted_shift_error: 1e-3,
    prediction_range: 1e-3,
    fixed_point_iterations: 3,
    extrapolation_determinant: 1e-8,
    decrease: 1e-22,
    inexact_decrease_ratio: 1e-6,
    inexact_decrease: 1e-12,
    old_factor_decrease: 1e-3,
    reuse_ratio: 1e-4,
    fresh_factor_decrease: 1e-10,
    fresh_factor_ratio: 1e-5,
    trusted_ratio: 1e-3,
    step_slope: 0.1,
    search_slope: 0.01,
    step_doublings: 60,
    regula_falsi_steps: 40,
    bound_rounding: 1e-9,
    sweeps: 100,
    sweep_change: 1e-6,
    accepted_sweep_change: 1e-4,
    slip_iterations: 20,
    slip_change: 1e-9,
};

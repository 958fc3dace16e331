//! Interpolation of the state inside a step from the states at its ends.

use robot_dynamics_core::configuration::displacement_rate::{bracket, displacement_rate, store};
use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges, vector_at};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, difference, integrate};
use robot_dynamics_number::algebra::V3;

/// q₀ ⊕ Θ(x), 0 ≤ x ≤ 1, where Θ is the cubic from 0 to q₁ ⊖ q₀ with the end velocities as its derivatives.
///
/// With s = t₁ − t₀ the error of q is at most |Θ⁗| s⁴/384, and that of v, which follows from Θ̇, is O(s³). In
/// rows of first and second order Θ̇ would overshoot end velocities that hardly differ; there v is linear
/// between them, with the error O(s²).
pub struct StepInterpolation<'a> {
    model: &'a Model,
    is_line: bool,
    displacement: Vec<f64>,
    /// s Θ̇ at the ends.
    derivatives: [Vec<f64>; 2],
    theta: Vec<f64>,
    rate: Vec<f64>,
}

/// The times and the states at the ends of a step.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    pub times: (f64, f64),
    pub from: (&'a [f64], &'a [f64]),
    pub to: (&'a [f64], &'a [f64]),
}

impl<'a> StepInterpolation<'a> {
    /// Creates the interpolation for a row of this order.
    pub fn new(model: &'a Model, order: u32) -> Self {
        let zero = || vec![0.0; model.nv()];
        Self {
            model,
            is_line: order <= 2,
            displacement: zero(),
            derivatives: [zero(), zero()],
            theta: zero(),
            rate: zero(),
        }
    }

    /// Sets the step to interpolate.
    pub(super) fn set_ends(&mut self, ends: &Ends<'_>) {
        let Self { model, displacement, derivatives: [first, last], .. } = self;
        let s = ends.times.1 - ends.times.0;
        difference(model, ends.from.0, ends.to.0, displacement);
        first.copy_from_slice(ends.from.1);
        displacement_rate(model, displacement, ends.to.1, last);
        for slope in first.iter_mut().chain(last) {
            *slope *= s;
        }
    }

    /// (q, v) at a time inside the step.
    pub(super) fn state(&mut self, ends: &Ends<'_>, time: f64, q: &mut [f64], v: &mut [f64]) {
        let Self { model, is_line, displacement, derivatives: [first, last], theta, rate } = self;
        let (t0, t1) = ends.times;
        if time >= t1 {
            q.copy_from_slice(ends.to.0);
            v.copy_from_slice(ends.to.1);
            return;
        }
        let s = t1 - t0;
        let x = ((time - t0) / s).max(0.0);
        let y = 1.0 - x;
        for k in 0..theta.len() {
            let (d, a, b) = (displacement[k], first[k], last[k]);
            theta[k] = x * x * (3.0 - 2.0 * x) * d + x * y * (y * a - x * b);
            rate[k] = (6.0 * x * y * d + y * (1.0 - 3.0 * x) * a - x * (2.0 - 3.0 * x) * b) / s;
        }
        integrate(model, ends.from.0, theta, q);
        if *is_line {
            for k in 0..v.len() {
                v[k] = y * ends.from.1[k] + x * ends.to.1[k];
            }
        } else {
            body_velocity(model, theta, rate, v);
        }
    }
}

/// v of Θ̇ at Θ, the inverse of [`displacement_rate`]: v = Θ̇ − ½\[Θ,Θ̇\] + ⅙\[Θ,\[Θ,Θ̇\]\] − O(|Θ|³).
fn body_velocity(model: &Model, theta: &[f64], rate: &[f64], v: &mut [f64]) {
    let series = |w: V3<f64>, a, b| w.add_scaled(-0.5, a).add_scaled(1.0 / 6.0, b);
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        match chart {
            Chart::Line => v[k] = rate[k],
            Chart::Rotation => {
                let (t, w) = (vector_at(theta, k), vector_at(rate, k));
                let once = t.cross(w);
                store(series(w, once, t.cross(once)), &mut v[k..]);
            }
            Chart::Placement => {
                let at = |x| (vector_at(x, k), vector_at(x, k + 3));
                let (t, w) = (at(theta), at(rate));
                let once = bracket(t, w);
                let twice = bracket(t, once);
                store(series(w.0, once.0, twice.0), &mut v[k..]);
                store(series(w.1, once.1, twice.1), &mut v[k + 3..]);
            }
        }
    }
}

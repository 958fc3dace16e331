//! Minimization of a smooth function with a barrier by the BFGS method.
//!
//! Source: Nocedal, Wright, *Numerical Optimization* (2006), ch. 6.1.

use core::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

/// The function decreases by at least this part of its slope.
const ARMIJO: f64 = 1e-4;

/// The most halvings of a step.
const HALVINGS: usize = 40;

/// Steps that decrease the function by less than this do not matter.
const LEAST_GAIN: f64 = 1e-7;

/// A function to minimize. Its value is infinite outside its domain.
pub(super) trait Objective {
    fn value(&mut self, x: &DVector<f64>) -> f64;
    fn gradient(&mut self, x: &DVector<f64>) -> DVector<f64>;
}

/// Minimizes from a point in the domain, in at most `steps` steps. `observe` gets the value after each step
/// and may stop.
pub(super) fn minimize(
    objective: &mut impl Objective,
    x: &mut DVector<f64>,
    steps: usize,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let n = x.len();
    let (mut value, mut gradient) = (objective.value(x), objective.gradient(x));
    // The inverse Hessian.
    let mut inverse = DMatrix::<f64>::identity(n, n) / gradient.norm().max(1e-12);
    let mut quiet = 0;
    for _step in 0..steps {
        let mut direction = -(&inverse * &gradient);
        let mut slope = direction.dot(&gradient);
        if slope >= 0.0 {
            inverse = DMatrix::identity(n, n) / gradient.norm().max(1e-12);
            direction = -(&inverse * &gradient);
            slope = direction.dot(&gradient);
        }
        let (mut fraction, mut next, mut after) = (1.0, x.clone(), f64::INFINITY);
        for _halving in 0..HALVINGS {
            next = &*x + &direction * fraction;
            after = objective.value(&next);
            if after <= value + ARMIJO * fraction * slope {
                break;
            }
            fraction *= 0.5;
        }
        if after.is_nan() || after >= value {
            break;
        }
        let new_gradient = objective.gradient(&next);
        update(&mut inverse, &(&next - &*x), &(&new_gradient - &gradient));
        quiet = if value - after < LEAST_GAIN { quiet + 1 } else { 0 };
        (*x, value, gradient) = (next, after, new_gradient);
        observe(value)?;
        if quiet >= 3 {
            break;
        }
    }
    ControlFlow::Continue(())
}

/// H ← (1 − ρ s yᵀ) H (1 − ρ y sᵀ) + ρ s sᵀ with ρ = 1/yᵀs, if the curvature yᵀs is positive.
fn update(inverse: &mut DMatrix<f64>, s: &DVector<f64>, y: &DVector<f64>) {
    let curvature = y.dot(s);
    if curvature <= 1e-10 * y.norm() * s.norm() {
        return;
    }
    let product = &*inverse * y;
    let factor = (1.0 + y.dot(&product) / curvature) / curvature;
    *inverse += s * s.transpose() * factor;
    *inverse -= (&product * s.transpose() + s * product.transpose()) / curvature;
}

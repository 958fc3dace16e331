//! Minimizes a quadratic function over a box: min ½ xᵀH x + gᵀx with l ≤ x ≤ u, by projected Newton steps.
//!
//! Coordinates at a bound with an outward gradient are fixed. The others take a Newton step, which is
//! projected onto the box and shortened until the value decreases enough. Near the solution the active set is
//! constant, and one step converges. **(Bertsekas, SIAM J. Control 20(2), 1982; Tassa, Mansard, Todorov, ICRA
//! 2014, §III.B)**

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// The solution, and the factor that a feedback law needs.
pub(crate) struct BoxMinimum {
    /// The minimizer.
    pub(crate) x: DVector<f64>,
    /// The coordinates that are not fixed at a bound.
    pub(crate) free: Vec<usize>,
    /// The Cholesky factor of H over the free coordinates; `None` if every coordinate is at a bound.
    pub(crate) factor: Option<Cholesky<f64, Dyn>>,
}

/// The reason for which there is no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoxError {
    /// H is not positive definite over the free coordinates.
    Indefinite,
    /// The iteration does not converge.
    NotConverged,
}

/// Solves from `start`, which is projected onto the box first.
pub(crate) fn box_minimum(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    (lower, upper): (&DVector<f64>, &DVector<f64>),
    start: &DVector<f64>,
) -> Result<BoxMinimum, BoxError> {
    let project = |x: &DVector<f64>| x.zip_zip_map(lower, upper, f64::clamp);
    // A step of this size is rounding relative to the size of the box.
    let negligible = 1e-14 * (upper - lower).amax();
    let mut x = project(start);
    // The free coordinates over which x is known to be the minimizer.
    let mut least_over: Option<Vec<usize>> = None;
    for _ in 0..100 {
        let slope = h * &x + g;
        let is_held = |i: usize| (x[i] <= lower[i] && slope[i] > 0.0) || (x[i] >= upper[i] && slope[i] < 0.0);
        let free: Vec<usize> = (0..x.len()).filter(|&i| !is_held(i)).collect();
        if free.is_empty() {
            return Ok(BoxMinimum { x, free, factor: None });
        }
        let factor = h.select_rows(&free).select_columns(&free).cholesky().ok_or(BoxError::Indefinite)?;
        if least_over.as_ref() == Some(&free) {
            return Ok(BoxMinimum { x, free, factor: Some(factor) });
        }
        let newton = factor.solve(&slope.select_rows(&free));
        let mut step = DVector::zeros(x.len());
        free.iter().zip(newton.iter()).for_each(|(&i, d)| step[i] = -d);
        // A tenth of the predicted decrease, sᵀd + ½dᵀHd ≤ 0.1 sᵀd (Armijo). The change is computed from d,
        // because the difference of two values would lose its digits.
        let mut length = 1.0;
        let next = loop {
            let next = project(&(&x + length * &step));
            let moved = &next - &x;
            let is_rounding = moved.amax() <= negligible || length < 1e-15;
            if is_rounding || 0.9 * slope.dot(&moved) + 0.5 * moved.dot(&(h * &moved)) <= 0.0 {
                break next;
            }
            length *= 0.6;
        };
        // The bounds cancel the step, or the step is zero.
        if next == x {
            return Ok(BoxMinimum { x, free, factor: Some(factor) });
        }
        // A full Newton step that meets no bound ends at the minimizer over these coordinates.
        least_over = (next == &x + &step).then_some(free);
        x = next;
    }
    Err(BoxError::NotConverged)
}

//! Least quadratic function over a box: min ½ xᵀH x + gᵀx with l ≤ x ≤ u, by projected Newton steps.
//!
//! Coordinates at a bound that the gradient pushes outwards are held; the others take a Newton step, projected
//! onto the box and shortened until it pays. Near the solution the held set no longer changes and one step ends
//! it. **(Bertsekas, SIAM J. Control 20(2), 1982; Tassa, Mansard, Todorov, ICRA 2014, §III.B)**

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// The solution, and what a feedback law needs beside it.
pub(crate) struct BoxMinimum {
    /// The least point.
    pub(crate) x: DVector<f64>,
    /// The coordinates that no bound holds.
    pub(crate) free: Vec<usize>,
    /// H over these; `None` if there are none.
    pub(crate) factor: Option<Cholesky<f64, Dyn>>,
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoxError {
    /// H is not positive definite over the free coordinates.
    Indefinite,
    /// The steps do not end.
    NotConverged,
}

/// Solves from `start`, which is moved into the box first.
pub(crate) fn box_minimum(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    (lower, upper): (&DVector<f64>, &DVector<f64>),
    start: &DVector<f64>,
) -> Result<BoxMinimum, BoxError> {
    let project = |x: &DVector<f64>| x.zip_zip_map(lower, upper, f64::clamp);
    // A step that is rounding beside the box's own size.
    let negligible = 1e-14 * (upper - lower).amax();
    let mut x = project(start);
    // The free coordinates over which x is the least point already.
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
        // A tenth of what the slope promises, sᵀd + ½dᵀHd ≤ 0.1 sᵀd (Armijo). The change is computed from d: a
        // difference of two values would be rounding long before.
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
        // The bounds take the whole step back, or it is none.
        if next == x {
            return Ok(BoxMinimum { x, free, factor: Some(factor) });
        }
        // A whole Newton step that met no bound ends at the least point over these coordinates.
        least_over = (next == &x + &step).then_some(free);
        x = next;
    }
    Err(BoxError::NotConverged)
}

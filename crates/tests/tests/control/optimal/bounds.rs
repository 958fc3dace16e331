//! Bounds on controls: the conditions of optimality of the condensed quadratic program, computed without the
//! recursion.

use nalgebra::{DMatrix, DVector, dmatrix};
use robot_dynamics::control::optimal::{ControlBounds, Fddp, FddpOptions};
use robot_dynamics::nalgebra;

use super::linear_problem;

const NODES: usize = 25;

/// The derivatives of all states by all controls, and the states without control: x = F + G u.
fn condensed(a: &DMatrix<f64>, b: &DMatrix<f64>, start: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
    let (n, m) = b.shape();
    let mut free = DVector::zeros((NODES + 1) * n);
    let mut by_control = DMatrix::zeros((NODES + 1) * n, NODES * m);
    free.rows_mut(0, n).copy_from_slice(start);
    for k in 0..NODES {
        let next = a * free.rows(k * n, n);
        free.rows_mut((k + 1) * n, n).copy_from(&next);
        let next = a * by_control.rows(k * n, n);
        by_control.rows_mut((k + 1) * n, n).copy_from(&next);
        by_control.view_mut(((k + 1) * n, k * m), (n, m)).copy_from(b);
    }
    (free, by_control)
}

/// The problem is convex, so the conditions of Karush, Kuhn and Tucker are sufficient: the gradient of each
/// control vanishes between its bounds, and points outwards at one. The gradient is as accurate as the
/// solver's tolerance.
#[test]
fn bounded_controls_satisfy_the_conditions_of_optimality() {
    let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005, 0.0; 0.1, 0.05]);
    let (q, r, last) = ([1.0, 0.1], [0.01, 0.02], [50.0, 5.0]);
    let start = [2.0, 0.5];
    let mut problem = linear_problem((&a, &b), (&q, &r, &last), &start, NODES);
    let (lower, upper) = ([-1.0, -2.0], [0.5, f64::INFINITY]);
    problem
        .set_control_bounds(0..NODES, ControlBounds::new(&lower, &upper).expect("bounds"))
        .expect("bounds");
    let mut solver = Fddp::new(problem, FddpOptions::default()).expect("options");
    let report = solver.solve().expect("a solution");
    assert!(report.is_solved(), "{report:?}");

    let (free, by_control) = condensed(&a, &b, &start);
    let u: Vec<f64> = (0..NODES).flat_map(|k| solver.control(k).to_vec()).collect();
    let x = &free + &by_control * DVector::from_column_slice(&u);
    let weight = |i: usize| if i < 2 * NODES { q[i % 2] } else { last[i % 2] };
    let weighed = DVector::from_fn(x.len(), |i, _| weight(i) * x[i]);
    let gradient = by_control.transpose() * &weighed;
    let (mut at_bounds, mut between) = (0, 0);
    for (i, u) in u.iter().enumerate() {
        let g = gradient[i] + r[i % 2] * u;
        let (is_low, is_high) = (*u == lower[i % 2], *u == upper[i % 2]);
        assert!(*u >= lower[i % 2] && *u <= upper[i % 2]);
        assert!(g > -1e-6 || is_high, "{i}: {u} {g}");
        assert!(g < 1e-6 || is_low, "{i}: {u} {g}");
        if is_low || is_high { at_bounds += 1 } else { between += 1 }
    }
    assert!(at_bounds >= 3 && between >= 3, "{at_bounds} {between}");
    let cost = 0.5 * (x.dot(&weighed) + u.iter().enumerate().map(|(i, u)| r[i % 2] * u * u).sum::<f64>());
    assert!((report.cost - cost).abs() < 1e-12 * cost);
}

#[test]
fn bounds_that_contradict_are_refused() {
    assert!(ControlBounds::new(&[1.0], &[0.0]).is_err());
    assert!(ControlBounds::new(&[f64::NAN], &[0.0]).is_err());
    assert!(ControlBounds::new(&[0.0, 0.0], &[1.0]).is_err());
}

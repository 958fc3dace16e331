//! Linear-quadratic problems: one iteration, the gain and the cost of the Riccati equation.

use nalgebra::{DMatrix, DVector, dmatrix};
use robot_dynamics::control::dlqr;
use robot_dynamics::control::optimal::{ControlBounds, Fddp, FddpOptions, LinearDynamics, Termination};
use robot_dynamics::nalgebra;

use super::{linear_problem, quadratic};

fn system() -> (DMatrix<f64>, DMatrix<f64>) {
    let a = dmatrix![1.0, 0.1, 0.0; 0.05, 1.02, 0.1; 0.0, -0.1, 0.95];
    (a, dmatrix![0.0, 0.01; 0.1, 0.0; 0.02, 0.1])
}

/// After 600 nodes the finite horizon is the infinite one: the closed loop's decay, below 0.95, gives
/// 0.95¹²⁰⁰ < 1e-26.
#[test]
fn a_long_horizon_gives_the_gain_and_cost_of_the_riccati_equation() {
    let (a, b) = system();
    let (q, r) = ([1.0, 0.5, 0.2], [0.1, 0.3]);
    let diagonal = |x: &[f64]| DMatrix::from_diagonal(&DVector::from_column_slice(x));
    let lqr = dlqr(&a, &b, &diagonal(&q), &diagonal(&r)).expect("a gain");
    assert!(lqr.spectral_radius < 0.95);
    let start = [1.0, -0.5, 0.3];
    let mut solver = Fddp::new(linear_problem((&a, &b), (&q, &r, &q), &start, 600), FddpOptions::default())
        .expect("options");
    // The default regularization of 1e-9 changes digits; this one is below rounding.
    let mut options = FddpOptions::default();
    (options.initial_regularization, options.min_regularization) = (1e-16, 1e-16);
    let mut exact = Fddp::new(solver.problem().clone(), options).expect("options");
    for (solver, tolerance) in [(&mut solver, 1e-7), (&mut exact, 1e-12)] {
        let report = solver.solve().expect("a solution");
        assert_eq!((report.termination, report.iterations), (Termination::Converged, 1));
        let gain = DMatrix::from_row_slice(2, 3, solver.gain(0));
        assert!((gain + &lqr.gain).amax() < tolerance);
        let x = DVector::from_column_slice(&start);
        let cost = 0.5 * (x.transpose() * &lqr.cost * &x)[(0, 0)];
        assert!((report.cost - cost).abs() < tolerance, "{} {cost}", report.cost);
        assert!(report.defect == 0.0);
    }
}

#[test]
fn threads_change_no_bit() {
    let (a, b) = system();
    let problem = linear_problem((&a, &b), (&[1.0; 3], &[0.1; 2], &[5.0; 3]), &[1.0, 2.0, 3.0], 37);
    let states = |threads: usize| {
        let mut options = FddpOptions::default();
        options.threads = threads;
        let mut solver = Fddp::new(problem.clone(), options).expect("options");
        solver.solve().expect("a solution");
        (0..=37).map(|node| solver.state(node).to_vec()).collect::<Vec<_>>()
    };
    assert_eq!(states(1), states(3));
}

/// A phase without the second control moves as one with the bounds 0 and 0 on it.
#[test]
fn phases_may_have_other_controls() {
    let (a, b) = system();
    let (q, r, last) = ([1.0; 3], [0.1; 2], [5.0; 3]);
    let bounded = {
        let mut problem = linear_problem((&a, &b), (&q, &r, &last), &[1.0, 2.0, 3.0], 20);
        let (low, high) = ([f64::NEG_INFINITY, 0.0], [f64::INFINITY, 0.0]);
        problem.set_control_bounds(8..15, ControlBounds::new(&low, &high).expect("bounds")).expect("bounds");
        problem
    };
    let mut phases = linear_problem((&a, &b), (&q, &r, &last), &[1.0, 2.0, 3.0], 20);
    let first = LinearDynamics::new(a, b.columns(0, 1).into_owned()).expect("matrices");
    phases.set_dynamics(8..15, first).expect("dynamics");
    let space = phases.state_space().clone();
    let cost = quadratic(&space, &[0.0; 3], q.to_vec(), Some(vec![0.1]));
    phases.set_running_cost(8..15, cost).expect("a cost");
    let solve = |problem| {
        let mut solver = Fddp::new(problem, FddpOptions::default()).expect("options");
        let report = solver.solve().expect("a solution");
        assert!(report.is_solved() && solver.control(10)[0].abs() > 1e-6);
        report.cost
    };
    assert_eq!((phases.controls(7), phases.controls(8)), (2, 1));
    let (one, two) = (solve(bounded), solve(phases));
    assert!((one - two).abs() < 1e-12 * one, "{one} {two}");
}

//! Constraints: an augmented Lagrangian against the linear equations of optimality, and limits of states.

use nalgebra::{DMatrix, DVector, dmatrix};
use robot_dynamics::control::optimal::{
    AugmentedLagrangian, AugmentedLagrangianOptions, Fddp, FddpOptions, LinearDynamics, Problem,
    StateResidual, Termination,
};
use robot_dynamics::nalgebra;

use super::{linear_problem, quadratic};

const NODES: usize = 20;

fn mass() -> (DMatrix<f64>, DMatrix<f64>) {
    (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1])
}

/// Least effort from rest to (1, 0): u = Gᵀ(G Gᵀ)⁻¹ x\*, with x_N = G u. The violation of 1e-6 bounds the
/// error of u by 1e-6 |G⁺|, and |G⁺| is about 30.
#[test]
fn the_least_effort_to_a_state_is_the_pseudo_inverse() {
    let (a, b) = mass();
    let mut by_control = DMatrix::zeros(2, NODES);
    for k in 0..NODES {
        let column = (0..NODES - 1 - k).fold(b.clone(), |column, _| &a * column);
        by_control.set_column(k, &column.column(0));
    }
    let target = DVector::from_column_slice(&[1.0, 0.0]);
    let gram = &by_control * by_control.transpose();
    let expected = by_control.transpose() * gram.lu().solve(&target).expect("a solution");

    let mut problem =
        Problem::new(LinearDynamics::new(a, b).expect("matrices"), &[0.0; 2], NODES).expect("nodes");
    let space = problem.state_space().clone();
    let effort = quadratic(&space, &[0.0; 2], vec![0.0; 2], Some(vec![1.0]));
    problem.set_running_cost(0..NODES, effort).expect("a cost");
    let arrive = StateResidual::new(&space, &[1.0, 0.0]).expect("a state");
    problem.add_terminal_constraint(arrive, &[0.0; 2], &[0.0; 2]).expect("a constraint");
    assert!(Fddp::new(problem.clone(), FddpOptions::default()).is_err(), "constraints must not be ignored");
    for threads in [1, 2] {
        let mut options = AugmentedLagrangianOptions::default();
        options.inner.threads = threads;
        let mut solver = AugmentedLagrangian::new(problem.clone(), options).expect("options");
        let report = solver.solve().expect("a solution");
        assert!(report.is_solved() && report.violation < 1e-6, "{report:?} {:#?}", solver.log());
        for k in 0..NODES {
            assert!((solver.fddp().control(k)[0] - expected[k]).abs() < 1e-4, "{k}");
        }
        assert!((report.cost - 0.5 * expected.norm_squared()).abs() < 1e-4);
    }
}

/// A speed limit of a mass: no state exceeds it, some are at it, and the cost is above that without a limit.
#[test]
fn limits_of_states_hold() {
    let (a, b) = mass();
    let (q, r, last) = ([0.0, 0.0], [1e-3], [100.0, 10.0]);
    let free = linear_problem((&a, &b), (&q, &r, &last), &[1.0, 0.0], NODES);
    let mut problem = free.clone();
    let speed = StateResidual::new(problem.state_space(), &[0.0; 2]).expect("a state");
    let (lower, upper) = ([f64::NEG_INFINITY, -0.65], [f64::INFINITY, 0.65]);
    problem.add_constraint(1..NODES, speed, &lower, &upper).expect("a constraint");
    let mut solver =
        AugmentedLagrangian::new(problem, AugmentedLagrangianOptions::default()).expect("options");
    let report = solver.solve().expect("a solution");
    assert!(report.is_solved(), "{report:?} {:#?}", solver.log());
    let speeds: Vec<f64> = (1..NODES).map(|k| solver.fddp().state(k)[1]).collect();
    assert!(speeds.iter().all(|v| v.abs() < 0.65 + 2e-6), "{speeds:?}");
    assert!(speeds.iter().filter(|v| v.abs() > 0.65 - 1e-5).count() > 3, "{speeds:?}");
    let mut unlimited = Fddp::new(free, FddpOptions::default()).expect("options");
    let unlimited = unlimited.solve().expect("a solution").cost;
    assert!(report.cost > unlimited, "{} {unlimited}", report.cost);
}

#[test]
fn constraints_that_contradict_end_at_the_largest_penalty() {
    let (a, b) = mass();
    let mut problem = linear_problem((&a, &b), (&[1.0; 2], &[1.0], &[1.0; 2]), &[1.0, 0.0], NODES);
    let space = problem.state_space().clone();
    for target in [1.0, 2.0] {
        let arrive = StateResidual::new(&space, &[target, 0.0]).expect("a state");
        problem.add_terminal_constraint(arrive, &[0.0; 2], &[0.0; 2]).expect("a constraint");
    }
    let mut solver =
        AugmentedLagrangian::new(problem, AugmentedLagrangianOptions::default()).expect("options");
    let report = solver.solve().expect("a report");
    assert_eq!(report.termination, Termination::PenaltyLimit);
    assert!((report.violation - 0.5).abs() < 1e-3, "{report:?}");
}

//! Model predictive control in a closed loop, from states that differ from the predicted ones.

use std::time::Duration;

use nalgebra::dmatrix;
use robot_dynamics::control::optimal::{ControlBounds, Mpc, MpcOptions};
use robot_dynamics::nalgebra;

use super::linear_problem;

/// An unstable system with bounded controls and disturbances stays near the origin.
#[test]
fn an_unstable_system_is_held_within_its_bounds() {
    let (a, b) = (dmatrix![1.0, 0.1; 0.2, 1.0], dmatrix![0.005; 0.1]);
    let mut problem = linear_problem((&a, &b), (&[1.0, 0.1], &[0.01], &[10.0, 1.0]), &[0.5, 0.0], 30);
    problem.set_control_bounds(0..30, ControlBounds::new(&[-2.0], &[2.0]).expect("bounds")).expect("bounds");
    let mut options = MpcOptions::default();
    options.time_budget = Some(Duration::from_secs(10));
    let mut mpc = Mpc::new(problem, options).expect("options");
    let mut x = dmatrix![0.5; 0.0];
    let mut largest = 0.0_f64;
    for period in 0..200 {
        let u = mpc.step(x.as_slice()).expect("controls")[0];
        largest = largest.max(u.abs());
        let disturbance = if period % 40 == 39 { 0.05 } else { 0.0 };
        x = &a * x + &b * u + dmatrix![0.0; disturbance];
    }
    assert!(largest == 2.0 && x.norm() < 0.1, "{largest} {x}");
    let times = mpc.times();
    assert_eq!((times.periods, times.over_budget), (199, 0));
    assert!(times.median <= times.percentile_99_9 && times.percentile_99_9 <= times.longest);
    assert!(mpc.step(&[f64::NAN, 0.0]).is_err());
}

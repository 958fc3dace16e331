//! Iterations of optimal control: the reach of the Panda of `bench/peers/crocoddyl_reach.py`, with and
//! without torque limits. Prints cost, iterations and the median time in milliseconds.
//!
//! `cargo run --release -p bench --bin measure_optimal -- [NODES…]`

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use robot_dynamics::control::optimal::{
    ControlBounds, ControlResidual, Cost, Fddp, FddpOptions, FrameTranslationResidual, Problem, SmoothStep,
    StateResidual,
};
use robot_dynamics::simulation::Integrator;

const PANDA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/panda.urdf");

/// The length of a step \[s\].
const STEP: f64 = 0.02;

/// The solutions of which the median is printed.
const REPETITIONS: usize = 20;

const TORQUE_LIMITS: [f64; 7] = [87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0];

/// The problem, and the torques that hold its start.
fn reach(nodes: usize, is_bounded: bool) -> Result<(Problem, Vec<f64>), Box<dyn Error>> {
    let model = Arc::new(robot_dynamics::load(PANDA)?.model);
    let start = [0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6];
    let x0: Vec<f64> = start.into_iter().chain([0.0; 7]).collect();
    let hold = model.gravity_forces(&start)?.as_slice().to_vec();
    let step = SmoothStep::new(model.clone(), Integrator::SemiImplicitEuler, STEP)?.with_dissipation(false);
    let mut problem = Problem::new(step, &x0, nodes)?;
    let space = problem.state_space().clone();
    let by_part = |q: f64, v: f64| [[q; 7], [v; 7]].concat();
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    running.add(StateResidual::new(&space, &x0)?, by_part(1e-2 * STEP, 1e-1 * STEP))?;
    running.add(ControlResidual::new(&hold)?, 1e-3 * STEP)?;
    terminal.add(StateResidual::new(&space, &x0)?, by_part(1e-2, 10.0))?;
    let hand = model.frame_named("panda_link8")?;
    terminal.add(FrameTranslationResidual::new(model, hand, [0.35, 0.45, 0.25])?, 1e4)?;
    problem.set_running_cost(0..nodes, running)?;
    problem.set_terminal_cost(terminal)?;
    if is_bounded {
        let bounds = ControlBounds::new(&TORQUE_LIMITS.map(|limit| -limit), &TORQUE_LIMITS)?;
        problem.set_control_bounds(0..nodes, bounds)?;
    }
    Ok((problem, hold))
}

fn measure(nodes: usize, is_bounded: bool, threads: usize) -> Result<(), Box<dyn Error>> {
    let (problem, hold) = reach(nodes, is_bounded)?;
    let mut options = FddpOptions::default();
    options.threads = threads;
    let mut solver = Fddp::new(problem, options)?;
    let mut times = Vec::new();
    let mut report = None;
    for _ in 0..REPETITIONS {
        solver.set_rollout(&vec![hold.clone(); nodes])?;
        let start = Instant::now();
        report = Some(solver.solve()?);
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let (report, spent) = (report.expect("a solution"), times[REPETITIONS / 2]);
    let kind = if is_bounded { "bounded" } else { "free" };
    println!(
        "ours, {nodes} nodes, {kind}, {threads} threads: cost {:.6}, {} iterations, {spent:.3} ms, {:.3} ms an iteration",
        report.cost,
        report.iterations,
        spent / report.iterations.max(1) as f64
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<usize> = std::env::args().skip(1).map(|word| word.parse()).collect::<Result<_, _>>()?;
    for nodes in if given.is_empty() { vec![20, 50] } else { given } {
        for threads in [1, 2] {
            measure(nodes, false, threads)?;
            measure(nodes, true, threads)?;
        }
    }
    Ok(())
}

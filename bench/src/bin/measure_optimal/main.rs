//! Iterations of optimal control: the reach of the Panda of `bench/peers/crocoddyl_reach.py`, with and
//! without torque limits, and the trot and the reach with held contacts of
//! `bench/peers/crocoddyl_contacts.py`. Also the landing of a quadruped with contacts that the simulator
//! finds, seven iterations. Prints cost, iterations and the median time in milliseconds.
//!
//! `cargo run --release -p bench --bin measure_optimal -- [reach|trot|humanoid|landing]…`

mod contacts;
mod landing;

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

/// The default limit of iterations.
const MOST: usize = 100;

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

fn measure_reach(nodes: usize, is_bounded: bool, threads: usize) -> Result<(), Box<dyn Error>> {
    let (problem, hold) = reach(nodes, is_bounded)?;
    let kind = if is_bounded { "bounded" } else { "free" };
    let start = |solver: &mut Fddp| Ok(solver.set_rollout(&vec![hold.clone(); nodes])?);
    measure(&format!("{nodes} nodes, {kind}"), problem, threads, (REPETITIONS, MOST), start)
}

/// Solves a problem from the same start again and again, and prints the median.
fn measure(
    name: &str,
    problem: Problem,
    threads: usize,
    (repetitions, most_iterations): (usize, usize),
    start: impl Fn(&mut Fddp) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let mut options = FddpOptions::default();
    (options.threads, options.max_iterations) = (threads, most_iterations);
    let mut solver = Fddp::new(problem, options)?;
    let mut times = Vec::new();
    let mut report = None;
    for _ in 0..repetitions {
        start(&mut solver)?;
        let begin = Instant::now();
        report = Some(solver.solve()?);
        times.push(1e3 * begin.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let (report, spent) = (report.expect("a solution"), times[repetitions / 2]);
    println!(
        "ours, {name}, {threads} threads: cost {:.6}, {} iterations, {spent:.3} ms, {:.3} ms an iteration",
        report.cost,
        report.iterations,
        spent / report.iterations.max(1) as f64
    );
    Ok(())
}

/// The same from the initial state in all nodes and without controls.
fn measure_from_rest(name: &str, problem: Problem, threads: usize) -> Result<(), Box<dyn Error>> {
    let states = vec![problem.initial_state().to_vec(); problem.nodes() + 1];
    let controls: Vec<_> = (0..problem.nodes()).map(|node| vec![0.0; problem.controls(node)]).collect();
    let limits = (REPETITIONS / 2, MOST);
    measure(name, problem, threads, limits, |solver| Ok(solver.set_trajectory(&states, &controls)?))
}

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let is_chosen = |name: &str| given.is_empty() || given.iter().any(|word| word == name);
    for threads in [1, 2] {
        for nodes in [20, 50] {
            for is_bounded in [false, true].into_iter().filter(|_| is_chosen("reach")) {
                measure_reach(nodes, is_bounded, threads)?;
            }
        }
        if is_chosen("trot") {
            measure_from_rest("trot", contacts::trot()?, threads)?;
        }
        if is_chosen("humanoid") {
            measure_from_rest("humanoid", contacts::humanoid()?, threads)?;
        }
        if is_chosen("landing") {
            let (problem, torques) = landing::landing(40)?;
            let start = |solver: &mut Fddp| Ok(solver.set_rollout(&torques)?);
            measure("landing, 40 nodes", problem, threads, (5, 7), start)?;
        }
    }
    Ok(())
}

//! The speed-up by two threads for robots that fall on the ground: `rollout_by_stepper` with one thread and
//! with two, in turns.
//!
//! `cargo run --release -p bench --bin contact_threads [ROUNDS]`
//!
//! Each robot has 64 copies, dropped from 0 to 32 cm with random joint positions, which move for 0.5 s with
//! rigid contact. The two calls must give the same bits. For comparison the program also times two calls with
//! one thread each in parallel, the most that this machine can gain.

use std::process::ExitCode;
use std::time::Instant;

use bench::robot_by_name;
use robot_dynamics::batch::{
    BatchWorkspace, RolloutStates, StepperRollout, Threads, Torques, rollout_by_stepper,
};
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::model::{Model, Workspace, neutral, random_state};
use robot_dynamics::simulation::{Method, SimulationBuilder};
use robot_dynamics_number::SplitMix64;

const ROBOTS: [&str; 2] = ["quadruped", "humanoid"];
const STATES: usize = 64;
const STEPS: usize = 500;

fn main() -> ExitCode {
    let rounds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(9);
    println!(
        "| {STATES} states, {STEPS} steps of 1 ms | two threads over one | two calls side by side over one |"
    );
    println!("| --- | ---: | ---: |");
    for name in ROBOTS {
        match robot_by_name(name) {
            Ok(model) => measure(name, &model, rounds),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn measure(name: &str, model: &Model, rounds: usize) {
    let contacts = ContactSet::new(model, &[Ground::level(0.0)]).expect("its shapes can touch the ground");
    let start = starts(model, &contacts);
    let simulation = SimulationBuilder::new(model).method(Method::Implicit).contacts(contacts);
    let implicit = simulation.build().expect("a simulation").stepper();
    let pools = [1, 2].map(|count| Threads::start(count).expect("two threads"));
    let drop = |threads: &Threads| {
        let workspace = BatchWorkspace::on_threads(model, threads);
        let (mut q, mut v) = (start.clone(), vec![0.0; STATES * model.nv()]);
        let how = StepperRollout::new(&implicit, 1e-3, STEPS);
        let begin = Instant::now();
        rollout_by_stepper(model, &workspace, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)
            .expect("all come to their end");
        (begin.elapsed().as_secs_f64(), q)
    };
    let (mut by_two, mut side_by_side) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        let (one, first) = drop(&pools[0]);
        let (two, second) = drop(&pools[1]);
        assert!(first == second, "{name}: other bits by two threads");
        let begin = Instant::now();
        std::thread::scope(|scope| {
            let other = Threads::start(1).expect("a thread");
            scope.spawn(move || drop(&other));
            drop(&pools[0]);
        });
        by_two.push(one / two);
        side_by_side.push(2.0 * one / begin.elapsed().as_secs_f64());
    }
    println!("| {name} | {} | {} |", spread(by_two), spread(side_by_side));
}

/// Copies of the robot above the ground, each half a centimetre higher than the one before.
fn starts(model: &Model, contacts: &ContactSet) -> Vec<f64> {
    let (mut random, mut workspace) = (SplitMix64::new(20_261), Workspace::new(model));
    let mut all = Vec::new();
    for k in 0..STATES {
        let mut q = random_state(model, &mut random).q;
        q[..7].copy_from_slice(&neutral(model)[..7]);
        q[2] += 0.005 * k as f64 - contacts.clearance(model, &mut workspace, &q).unwrap_or(0.0);
        all.extend(q);
    }
    all
}

/// The median, minimum and maximum.
fn spread(mut ratios: Vec<f64>) -> String {
    ratios.sort_by(f64::total_cmp);
    let last = ratios.len() - 1;
    format!("{:.2} ({:.2} to {:.2})", ratios[last / 2], ratios[0], ratios[last])
}

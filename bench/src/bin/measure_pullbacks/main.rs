//! The cost of a vector-Jacobian product relative to its primal call, and to the Jacobians that it replaces.
//!
//! `cargo run --release -p bench --bin measure_pullbacks -- docs/performance/pullbacks.jsonl [ROBOT …]`
//!
//! One JSON line for each robot and call. It has the nanoseconds per state of the call, the smallest of the
//! rounds' medians. As multiples of the call it has the pullback, the pullback with all parameters, and the
//! Jacobians. Each is the median over the rounds of the ratio within a round. Every round measures everything
//! once, so that slow drifts of the machine cancel.

mod batches;

use std::hint::black_box;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bench::{StateTable, robot_by_name};
use robot_dynamics::derivatives::{
    self, ForwardDynamicsDerivativesMut, ForwardPullbackInputs, ForwardPullbackMut,
    InverseDynamicsDerivativesMut, InversePullbackInputs, InversePullbackMut, LinearizeStepWorkspace,
    LinearizedStep, MotionCotangents, RobotState, StepPullbackWorkspace, parameter_count,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace};
use serde_json::{Value, json};

use self::batches::batches;

const STATES: usize = 1024;
const SEED: u64 = 20260;
const ROUNDS: usize = 25;
const SLICE: Duration = Duration::from_millis(20);
const BLOCK: usize = 32;
const ROBOTS: [&str; 5] = ["two_r", "ur5", "panda", "quadruped", "talos"];
const STEP: f64 = 1e-3;
const STEPS: usize = 64;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(path) = arguments.next() else {
        eprintln!("usage: measure_pullbacks FILE.jsonl [ROBOT …]");
        return ExitCode::FAILURE;
    };
    let named: Vec<String> = arguments.collect();
    let names = if named.is_empty() { ROBOTS.map(String::from).to_vec() } else { named };
    let mut text = String::new();
    for name in names {
        match robot_by_name(&name) {
            Ok(model) => {
                for line in measure(&model) {
                    eprintln!("{line}");
                    text += &line.to_string();
                    text.push('\n');
                }
            }
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    match std::fs::write(&path, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cannot write {path}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A call by the index of a state, the number of states it computes, and the medians of its rounds
/// [ns/state].
struct Item<'a> {
    call: Box<dyn FnMut(usize) + 'a>,
    states: usize,
    medians: Vec<f64>,
}

impl<'a> Item<'a> {
    fn one(call: impl FnMut(usize) + 'a) -> Self {
        Self { call: Box::new(call), states: 1, medians: Vec::new() }
    }

    fn many(states: usize, call: impl FnMut(usize) + 'a) -> Self {
        Self { call: Box::new(call), states, medians: Vec::new() }
    }

    fn round(&mut self) {
        let (mut times, mut i, begin) = (Vec::new(), 0, Instant::now());
        let block = (BLOCK / self.states).max(1);
        while begin.elapsed() < SLICE || times.is_empty() {
            let start = Instant::now();
            for _ in 0..block {
                (self.call)(i);
                i = (i + 1) % STATES;
            }
            times.push(start.elapsed().as_nanos() as f64 / (block * self.states) as f64);
        }
        self.medians.push(median(times));
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The primal call, its pullback, that with parameters, the Jacobians.
type Row<'a> = (&'static str, [Item<'a>; 3], Option<Item<'a>>);

fn measure(model: &Model) -> Vec<Value> {
    let table = StateTable::random(model, STATES, SEED);
    let rows = [single(model, &table), motion(model, &table), batches(model, &table)];
    let mut rows: Vec<Row<'_>> = rows.into_iter().flatten().collect();
    for _ in 0..ROUNDS {
        rows.iter_mut().flat_map(|(_, items, last)| items.iter_mut().chain(last)).for_each(Item::round);
    }
    let record = |(call, [primal, pullback, parameters], jacobians): Row<'_>| {
        let primal = primal.medians;
        let ratio = |item: Item<'_>| {
            let ratios = item.medians.iter().zip(&primal).map(|(x, y)| x / y);
            rounded(median(ratios.collect()), 1e2)
        };
        let least = primal.iter().fold(f64::INFINITY, |least, x| least.min(*x));
        let (pullback, parameters, jacobians) = (ratio(pullback), ratio(parameters), jacobians.map(ratio));
        json!({
            "robot": model.name(), "nv": model.nv(), "call": call, "ns": rounded(least, 10.0),
            "pullback": pullback, "parameters": parameters, "jacobians": jacobians,
        })
    };
    rows.into_iter().map(record).collect()
}

fn rounded(x: f64, scale: f64) -> f64 {
    (x * scale).round() / scale
}

fn single<'a>(model: &'a Model, table: &'a StateTable) -> Vec<Row<'a>> {
    let n = model.nv();
    let memory = || (Workspace::<f64>::new(model), [(); 4].map(|()| vec![0.0; n]));
    let (square, count) = (|| vec![0.0; n * n], parameter_count(model));
    let inverse = {
        let (mut w, [mut tau, ..]) = memory();
        Item::one(move |i| {
            let [q, v, a, _] = table.get(i);
            robot_dynamics::algorithms::inverse_dynamics(model, &mut w, q, v, a, &mut tau);
            black_box(&tau);
        })
    };
    let inverse_pullback = |count: usize| {
        let (mut w, [mut x, mut y, mut z, _]) = memory();
        let mut parameters = vec![0.0; count];
        Item::one(move |i| {
            let [q, v, a, lambda] = table.get(i);
            let p = &mut parameters;
            let out = InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: p,
            };
            derivatives::inverse_dynamics_pullback_with_parameters(
                model,
                &mut w,
                InversePullbackInputs { q, v, a, wrenches: &[], cotangent: lambda },
                out,
            );
            black_box((&x, &y, &z));
        })
    };
    let inverse_jacobians = {
        let (mut w, [mut x, mut y, mut z]) = (Workspace::new(model), [square(), square(), square()]);
        Item::one(move |i| {
            let [q, v, a, _] = table.get(i);
            let out = InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
            derivatives::inverse_dynamics_derivatives(model, &mut w, q, v, a, out);
            robot_dynamics::algorithms::mass_matrix(model, &mut w, q, &mut z);
            black_box((&x, &y, &z));
        })
    };
    let forward = {
        let (mut w, [mut a, ..]) = memory();
        Item::one(move |i| {
            let [q, v, _, tau] = table.get(i);
            robot_dynamics::algorithms::forward_dynamics(model, &mut w, q, v, tau, &mut a);
            black_box(&a);
        })
    };
    let forward_pullback = |count: usize| {
        let (mut w, [mut a, mut x, mut y, mut z]) = memory();
        let mut parameters = vec![0.0; count];
        Item::one(move |i| {
            let [q, v, lambda, tau] = table.get(i);
            let p = &mut parameters;
            let out = ForwardPullbackMut {
                acceleration: &mut a,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: p,
            };
            derivatives::forward_dynamics_pullback_with_parameters(
                model,
                &mut w,
                ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent: lambda },
                out,
            );
            black_box((&a, &x, &y, &z));
        })
    };
    let forward_jacobians = {
        let (mut w, [mut x, mut y, mut z]) = (Workspace::new(model), [square(), square(), square()]);
        Item::one(move |i| {
            let [q, v, _, tau] = table.get(i);
            let out =
                ForwardDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y, by_force: &mut z };
            derivatives::forward_dynamics_derivatives(model, &mut w, q, v, tau, out);
            black_box((&x, &y, &z));
        })
    };
    vec![
        (
            "inverse dynamics",
            [inverse, inverse_pullback(0), inverse_pullback(count)],
            Some(inverse_jacobians),
        ),
        (
            "forward dynamics",
            [forward, forward_pullback(0), forward_pullback(count)],
            Some(forward_jacobians),
        ),
    ]
}

/// A step of the classical Runge–Kutta method.
fn motion<'a>(model: &'a Model, table: &'a StateTable) -> Vec<Row<'a>> {
    let (n, row) = (model.nv(), Integrator::RungeKutta4);
    let primal = {
        let (mut w, mut q_end, mut v_end) = (StepWorkspace::new(model), vec![0.0; model.nq()], vec![0.0; n]);
        Item::one(move |i| {
            let [q, v, _, tau] = table.get(i);
            q_end.copy_from_slice(q);
            v_end.copy_from_slice(v);
            let forces = StepForces::new(tau, false);
            let done =
                robot_dynamics::simulation::step(model, row, &mut w, &forces, STEP, &mut q_end, &mut v_end);
            black_box((&q_end, &v_end, done.is_ok()));
        })
    };
    let pullback = |count: usize| {
        let mut w = StepPullbackWorkspace::new(model);
        let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n]);
        let mut parameters = vec![0.0; count];
        Item::one(move |i| {
            let [q, v, lambda, tau] = table.get(i);
            x.copy_from_slice(lambda);
            y.copy_from_slice(lambda);
            let (forces, p) = (StepForces::new(tau, false), &mut parameters);
            let cotangents = MotionCotangents {
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: p,
            };
            let done = derivatives::step_pullback(
                model,
                row,
                &mut w,
                &forces,
                STEP,
                RobotState { q, v },
                cotangents,
            );
            black_box((&x, &y, &z, done.is_ok()));
        })
    };
    let jacobians = {
        let mut w = LinearizeStepWorkspace::new(model);
        let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
        Item::one(move |i| {
            let [q, v, _, tau] = table.get(i);
            let forces = StepForces::new(tau, false);
            let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
            let done =
                derivatives::linearize_step(model, row, &mut w, &forces, STEP, RobotState { q, v }, out);
            black_box((&a, &b, done.is_ok()));
        })
    };
    vec![("rk4 step", [primal, pullback(0), pullback(parameter_count(model))], Some(jacobians))]
}

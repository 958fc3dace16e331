//! The derivatives A and B of steps with contact: analytic, and by central differences.
//!
//! `cargo run --release -p bench --bin linearized_steps`
//!
//! Ten robots move for 0.8 s by random torques, in implicit steps of 1 ms; those with a free base fall on the
//! ground. 100 steps of each are linearized by both methods, in turns. The table has the share of steps
//! without analytic derivatives, of steps at a transition, and of steps without differences, because they
//! jump on both sides. It also has the share of the columns of A in the other steps in which both methods
//! agree to 1e-4, and the median times. Within 10 µm of a transition, such as a contact that could open,
//! differences give the mean of both sides. In a step with an impact, the analytic derivative moves its time
//! and the differences do not.

use std::process::ExitCode;
use std::time::Instant;

use robot_dynamics::contact::Ground;
use robot_dynamics::derivatives::{
    LinearizationMethod, LinearizedStep, RobotState, linearize_by_differences,
};
use robot_dynamics::description::{Base, Limits};
use robot_dynamics::model::{Model, neutral};
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};
use robot_dynamics_number::SplitMix64;

/// File, height of a free base \[m\], the largest random torque \[N·m\].
const ROBOTS: [(&str, Option<f64>, f64); 10] = [
    ("two_r.urdf", None, 5.0),
    ("three_r.urdf", None, 5.0),
    ("ur5.urdf", None, 20.0),
    ("panda.urdf", None, 10.0),
    ("arm.xml", None, 5.0),
    ("gripper_and_box.xml", None, 2.0),
    ("hand.urdf", None, 0.05),
    ("quadruped.urdf", Some(0.4), 5.0),
    ("quadruped.xml", Some(0.4), 5.0),
    ("humanoid.urdf", Some(1.0), 10.0),
];
const H: f64 = 1e-3;
const STEPS: usize = 800;
const EVERY: usize = 8;

/// The results of one robot.
#[derive(Default)]
struct Results {
    steps: usize,
    not_analytic: usize,
    at_transition: usize,
    /// The columns of A in the other steps with differences, and those in which both agree.
    compared: usize,
    agree: usize,
    without_differences: usize,
    step: Vec<f64>,
    analytic: Vec<f64>,
    differences: Vec<f64>,
}

fn main() -> ExitCode {
    println!(
        "| robot | nv | not analytic | at a transition | no differences | columns that agree | step \\[µs\\] \
         | analytic \\[µs\\] | differences \\[µs\\] | ratio |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (file, height, torque) in ROBOTS {
        match model_of(file, height.is_some()) {
            Ok(model) => report(file, &model, measure(&model, height, torque)),
            Err(error) => {
                eprintln!("{file}: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn model_of(file: &str, floats: bool) -> Result<Model, Box<dyn std::error::Error>> {
    let path = format!("{}/../robots/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut robot = robot_dynamics::load(&path)?.model.description().clone();
    if floats && file.ends_with("urdf") {
        robot.base = Base::Floating;
    }
    // Random torques would hold the joints at their stops.
    robot.joints.iter_mut().for_each(|joint| joint.limits = Limits::default());
    Ok(Model::new(robot)?)
}

fn measure(model: &Model, height: Option<f64>, torque: f64) -> Results {
    let mut builder = SimulationBuilder::new(model).method(Method::Implicit);
    if height.is_some() {
        builder = builder.ground(Ground::level(0.0).with_friction(0.7));
    }
    let mut stepper = builder.build().expect("a simulation").stepper();
    let (mut random, mut q, mut v) = (SplitMix64::new(20_261), neutral(model), vec![0.0; model.nv()]);
    let first = if let Some(height) = height {
        q[2] = height;
        6
    } else {
        0
    };
    let (mut tau, w) = (vec![0.0; model.nv()], &mut StepWorkspace::new(model));
    let mut results = Results::default();
    for step in 0..STEPS {
        if step % 40 == 0 {
            tau.iter_mut().skip(first).for_each(|tau| *tau = random.uniform(-torque, torque));
        }
        let forces = StepForces::new(&tau, true);
        if step % EVERY == EVERY - 1 {
            compare(model, &mut stepper, w, &forces, RobotState { q: &q, v: &v }, &mut results);
        }
        let begin = Instant::now();
        if stepper.step(model, w, &forces, H, &mut q, &mut v).is_err() {
            break;
        }
        results.step.push(begin.elapsed().as_secs_f64());
    }
    results
}

fn compare(
    model: &Model,
    stepper: &mut SimulationStepper,
    w: &mut StepWorkspace,
    forces: &StepForces<'_>,
    state: RobotState<'_>,
    results: &mut Results,
) {
    let nv = model.nv();
    let [mut a, mut by_differences] = [vec![0.0; 4 * nv * nv], vec![0.0; 4 * nv * nv]];
    let mut b = vec![0.0; 2 * nv * nv];
    results.steps += 1;
    let begin = Instant::now();
    let out = LinearizedStep { by_state: &mut by_differences, by_force: &mut b };
    let found = linearize_by_differences(model, stepper, w, forces, H, state, out).is_ok();
    results.differences.push(begin.elapsed().as_secs_f64());
    let begin = Instant::now();
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let method = stepper.linearize(model, w, forces, H, state, out).expect("the step exists");
    match method {
        LinearizationMethod::Analytic { at_transition } => {
            results.analytic.push(begin.elapsed().as_secs_f64());
            results.at_transition += usize::from(at_transition);
            results.without_differences += usize::from(!found);
            if !at_transition && found {
                for column in 0..2 * nv {
                    let entries = (column..4 * nv * nv).step_by(2 * nv);
                    let size = entries.clone().fold(1.0_f64, |most, i| most.max(a[i].abs()));
                    let off = entries.fold(0.0_f64, |most, i| most.max((a[i] - by_differences[i]).abs()));
                    results.compared += 1;
                    results.agree += usize::from(off < 1e-4 * size);
                }
            }
        }
        _ => results.not_analytic += 1,
    }
}

fn report(file: &str, model: &Model, results: Results) {
    let share = |part: usize, whole: usize| {
        if whole == 0 { "–".to_owned() } else { format!("{:.0} %", 100.0 * part as f64 / whole as f64) }
    };
    let Results { steps, not_analytic, at_transition, compared, agree, without_differences, .. } = results;
    let [step, analytic, differences] =
        [results.step, results.analytic, results.differences].map(|times| 1e6 * median(times));
    println!(
        "| {file} | {} | {} | {} | {} | {} | {step:.1} | {analytic:.1} | {differences:.0} | {:.0} |",
        model.nv(),
        share(not_analytic, steps),
        share(at_transition, steps),
        share(without_differences, steps),
        share(agree, compared),
        differences / analytic,
    );
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

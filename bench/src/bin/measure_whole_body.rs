//! Whole-body control of a quadruped and a humanoid: the time of a solution, from the last active limits and
//! from none. Prints medians in microseconds, and writes the programs with one level for
//! `bench/peers/quadratic_programs`.
//!
//! `cargo run --release -p bench --bin measure_whole_body [-- FILE]`

use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

use robot_dynamics::LoadOptions;
use robot_dynamics::algorithms::{center_of_mass, frame_pose};
use robot_dynamics::control::whole_body::{
    ALL_AXES, ContactGeometry, HeldContact, Objective, PdGains, WholeBodyControl, WholeBodyProgram,
};
use robot_dynamics::control::{PoseReference, Reference, TaskReference};
use robot_dynamics::description::Base;
use robot_dynamics::model::{Model, Workspace, integrate, neutral};
use robot_dynamics::nalgebra::DMatrix;
use robot_dynamics::number::SplitMix64;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/");

/// The states of which the medians are printed.
const STATES: usize = 400;

struct Case {
    name: &'static str,
    model: Model,
    q: Vec<f64>,
    trunk: &'static str,
    contacts: Vec<(&'static str, ContactGeometry)>,
    /// The acceleration of the trunk that is asked for: a large one makes limits active.
    push: f64,
}

fn load(file: &str) -> Result<Model, Box<dyn Error>> {
    let mut robot =
        robot_dynamics::load_description(format!("{ROBOTS}{file}"), &LoadOptions::default())?.description;
    robot.base = Base::Floating;
    Ok(Model::new(robot)?)
}

fn quadruped(push: f64) -> Result<Case, Box<dyn Error>> {
    let model = load("quadruped.urdf")?;
    let mut q = neutral(&model);
    for leg in 0..4 {
        q[7 + 3 * leg..10 + 3 * leg].copy_from_slice(&[0.0, 0.7, -1.4]);
    }
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let contacts = feet.map(|foot| (foot, ContactGeometry::Ball(0.02))).to_vec();
    Ok(Case { name: "quadruped", model, q, trunk: "trunk", contacts, push })
}

fn humanoid(push: f64) -> Result<Case, Box<dyn Error>> {
    let model = load("humanoid.urdf")?;
    let mut q = neutral(&model);
    for (joint, angle) in [("hip_pitch", -0.3), ("knee", 0.6), ("ankle_pitch", -0.3)] {
        for side in ["left", "right"] {
            let joint = model.joint(&format!("{side}_{joint}")).ok_or("no such joint")?;
            q[joint.q_index] = angle;
        }
    }
    let corners =
        [[0.15, 0.045], [0.15, -0.045], [-0.06, 0.045], [-0.06, -0.045]].map(|[x, y]| [x, y, -0.06825]);
    let sole = |foot| (foot, ContactGeometry::Face(corners.to_vec()));
    let contacts = vec![sole("left_foot"), sole("right_foot")];
    Ok(Case { name: "humanoid", model, q, trunk: "pelvis", contacts, push })
}

fn control(case: &Case, are_levels: bool) -> Result<WholeBodyControl<&Model>, Box<dyn Error>> {
    let Case { model, q, trunk, contacts, push, .. } = case;
    let mut control = WholeBodyControl::new(model);
    for (frame, geometry) in contacts {
        control.add_contact(HeldContact::new(model.frame_named(frame)?, geometry.clone()))?;
    }
    let (w, frame) = (&mut Workspace::new(model), model.frame_named(trunk)?);
    let reference = PoseReference::at_rest(frame_pose(model, w, q, frame));
    let gains = PdGains::critical(100.0);
    let rest = vec![0.0; model.nv()];
    let position = center_of_mass(model, w, q);
    let point = TaskReference { position, velocity: [0.0; 3], acceleration: [0.0, *push, 0.0] };
    let posture = Reference { q: q.clone(), v: rest.clone(), a: rest };
    let turn = Objective::FramePose { frame, axes: ALL_AXES[3..].to_vec(), reference, gains };
    let level = |level: usize| if are_levels { level } else { 0 };
    control.add_task_at(level(0), Objective::CenterOfMass { reference: point, gains }, 10.0)?;
    control.add_task_at(level(0), turn, 5.0)?;
    control.add_task_at(level(1), Objective::Posture { reference: posture, gains }, 0.1)?;
    control.add_task_at(level(2), Objective::ContactForces, 1e-4)?;
    Ok(control)
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A line of JSON for other solvers; infinite bounds become null.
fn line(name: &str, program: &WholeBodyProgram, cost: f64) -> String {
    let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
    };
    serde_json::json!({
        "name": name,
        "tasks": rows(&program.tasks),
        "task_values": program.task_values.as_slice(),
        "equations": rows(&program.equations),
        "equation_values": program.equation_values.as_slice(),
        "limits": rows(&program.limits),
        "lower": program.lower.as_slice(),
        "upper": program.upper.as_slice(),
        "cost": cost,
    })
    .to_string()
}

fn measure(case: &Case, are_levels: bool, programs: &mut String) -> Result<(), Box<dyn Error>> {
    let mut warm = control(case, are_levels)?;
    let fresh = control(case, are_levels)?;
    let mut random = SplitMix64::new(7);
    let nv = case.model.nv();
    let (mut q, mut v) = (case.q.clone(), vec![0.0; nv]);
    let [mut warm_times, mut cold_times] = [Vec::new(), Vec::new()];
    let (mut active, mut steps) = (0, 0);
    for _ in 0..STATES {
        // Consecutive states of a motion at 1 kHz near the stance.
        let step: Vec<f64> = v.iter().map(|v| 1e-3 * v).collect();
        let before = q.clone();
        integrate(&case.model, &before, &step, &mut q);
        for v in &mut v {
            *v = 0.98 * *v + random.uniform(-0.02, 0.02);
        }
        let start = Instant::now();
        let solution = warm.solve(&q, &v)?;
        warm_times.push(1e6 * start.elapsed().as_secs_f64());
        active += solution.active_limits.len();
        steps += solution.steps;
        let cost: f64 = [10.0, 5.0, 0.1, 1e-4]
            .iter()
            .zip(&solution.task_errors)
            .map(|(weight, error)| 0.5 * weight * error * error)
            .sum();
        let mut cold = fresh.clone();
        let start = Instant::now();
        cold.solve(&q, &v)?;
        cold_times.push(1e6 * start.elapsed().as_secs_f64());
        if !are_levels {
            let name = format!("{}, {} m/s²", case.name, case.push);
            let _ = writeln!(programs, "{}", line(&name, &warm.program(), cost));
        }
    }
    let program = warm.program();
    println!(
        "{}, {} variables, {} equations, {} limits ({:.1} active, {:.1} steps), {}: warm {:.1} µs, cold {:.1} µs",
        case.name,
        program.tasks.ncols(),
        program.equations.nrows(),
        program.limits.nrows(),
        active as f64 / STATES as f64,
        steps as f64 / STATES as f64,
        if are_levels { "three levels" } else { "one level" },
        median(&mut warm_times),
        median(&mut cold_times),
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut programs = String::new();
    for push in [0.0, 6.0] {
        for case in [quadruped(push)?, humanoid(push)?] {
            println!("asked for {push} m/s² to the side:");
            measure(&case, false, &mut programs)?;
            measure(&case, true, &mut programs)?;
        }
    }
    if let Some(path) = std::env::args().nth(1) {
        std::fs::write(path, programs)?;
    }
    Ok(())
}

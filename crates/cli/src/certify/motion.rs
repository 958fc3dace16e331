//! `dynamics certify motion`.

use std::process::ExitCode;

use robot_dynamics::text::one_line;
use robot_dynamics_certified::{Interval, enclose_motion};
use serde_json::json;

use super::intervals::{down, up};
use crate::failure::{CommandResult, Context, Failure};
use crate::joint_values::{JointNumbers, JointValues, set};
use crate::output::{print, print_json};
use crate::robot_file::RobotFile;
use crate::table::{Table, short, short_or_exponent};

/// Enclose all free motions from states near a pose.
///
/// The motors are off, and damping, friction, limits and contact do not act. The table shows how the set of
/// states grows: a motion is predictable for as long as it stays narrow. Lohner's method with Taylor series
/// of order 6 computes it. It is made for robots of few joints: with many, the set soon grows too wide.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Initial configuration by joint name. Other joints are at their initial pose.
    #[arg(long, value_name = "JOINT=NUMBER,…", allow_hyphen_values = true)]
    pose: Vec<JointValues>,
    /// Initial velocity by joint name.
    #[arg(long, value_name = "JOINT=NUMBER,…", allow_hyphen_values = true)]
    velocity: Vec<JointValues>,
    /// Each coordinate and velocity may differ by this from the initial state [rad, m, 1/s].
    #[arg(long, value_name = "RADIUS", default_value_t = 1e-6)]
    radius: f64,
    /// Duration in seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.1)]
    duration: f64,
    /// Largest step in seconds. Steps are divided where necessary.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.005)]
    step: f64,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

/// The number of rows of the table.
const ROWS: usize = 10;

pub(super) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_to_compute()?.model;
    let positive = [("--duration", arguments.duration), ("--step", arguments.step)];
    for (option, x) in positive {
        if !(x > 0.0 && x.is_finite()) {
            return Err(Failure::new(format!("{option}: {x} is not a positive number")));
        }
    }
    let steps = (arguments.duration / arguments.step).ceil();
    if steps > 1e6 {
        return Err(Failure::new(format!("--step: {steps} steps are more than 1e6")));
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // from 1 to 1e6
    let count = steps as usize;
    if !(arguments.radius >= 0.0 && arguments.radius.is_finite()) {
        return Err(Failure::new(format!("--radius: {} is not zero or positive", arguments.radius)));
    }
    let (mut q, mut v) = (model.initial_configuration(), vec![0.0; model.nv()]);
    set(&model, "--pose", &arguments.pose, JointNumbers::Configuration, &mut q)?;
    set(&model, "--velocity", &arguments.velocity, JointNumbers::Velocity, &mut v)?;
    let near =
        |x: &[f64]| -> Vec<Interval> { x.iter().map(|x| Interval::around(*x, arguments.radius)).collect() };
    let torques = vec![0.0; model.nv()];
    let motion = enclose_motion(&model, &near(&q), &near(&v), &torques, arguments.step, count)
        .context(arguments.robot.shown())?;
    let mut table = Table::new(&[">time [s]", ">widest position", ">widest velocity"]);
    let mut rows = Vec::new();
    let widest = |x: &[Interval]| x.iter().fold(0.0, |most: f64, x| most.max(x.width()));
    let every = motion.states.len().div_ceil(ROWS).max(1);
    for (k, state) in motion.states.iter().enumerate() {
        if k % every == 0 || k + 1 == motion.states.len() {
            let (q, v) = (widest(&state.q), widest(&state.v));
            table.row([short(state.time), short_or_exponent(q), short_or_exponent(v)]);
            rows.push(json!({ "time": state.time, "widest_position": q, "widest_velocity": v }));
        }
    }
    let last = &motion.states[motion.states.len() - 1];
    let bounds = |x: &[Interval]| -> Vec<[f64; 2]> { x.iter().map(|x| [x.lower(), x.upper()]).collect() };
    if arguments.json {
        let (q, v) = (bounds(&last.q), bounds(&last.v));
        let json = json!({ "robot": model.name(), "complete": motion.is_complete, "growth": rows, "end": { "time": last.time, "q": q, "v": v } });
        print_json(&(json.to_string() + "\n"))?;
    } else {
        let mut end = Table::new(&["joint", ">least position", ">greatest", ">least velocity", ">greatest"]);
        for ((name, q), v) in model.coordinate_names().into_iter().zip(&last.q).zip(&last.v) {
            end.row([name, down(q.lower()), up(q.upper()), down(v.lower()), up(v.upper())]);
        }
        let ending = if motion.is_complete {
            String::new()
        } else {
            format!(
                "\nThe set grew too wide for a step after {} s; try a smaller --step or --radius.\n",
                short(last.time)
            )
        };
        print(&format!(
            "{}: all free motions from a box of states\n\n{}\nStates at {} s:\n\n{}{ending}",
            one_line(model.name()),
            table.text(),
            short(last.time),
            end.text()
        ))?;
    }
    Ok(if motion.is_complete { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

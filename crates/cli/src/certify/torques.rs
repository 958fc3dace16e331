//! `dynamics certify torques`.

use std::path::{Path, PathBuf};

use robot_dynamics::model::Model;
use robot_dynamics::text::one_line;
use robot_dynamics_certified::{
    Certificate, Interval, Payload, PolynomialMotion, SearchOptions, TorqueBounds, Uncertainty, torque_bounds,
};
use serde_json::json;

use super::intervals::{Range, down, numbers, up};
use super::results::Results;
use crate::failure::{CommandResult, Context, Failure};
use crate::interruption;
use crate::joint_values::{JointNumbers, JointValues, NameOrValues, set};
use crate::robot_file::RobotFile;
use crate::table::{Table, short};

/// Prove bounds of the torques along a motion, and that the motors suffice.
///
/// The motion goes from rest at --from to rest at --to, or through the points of --motion by a cubic spline.
/// The bounds hold for every factor of --masses on the mass of each link, every load of --payload, and every
/// factor of --friction. The verdict compares them with the effort limits of the file: proven, exceeded by
/// some robot of the set, or open.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Start of the motion: joint values or the name of a pose. Other joints are at their initial pose.
    #[arg(long, value_name = "JOINT=NUMBER,… or POSE", allow_hyphen_values = true)]
    from: Vec<NameOrValues>,
    /// End of the motion. Joints that are not named keep their position.
    #[arg(
        long,
        value_name = "JOINT=NUMBER,… or POSE",
        allow_hyphen_values = true,
        conflicts_with = "motion"
    )]
    to: Vec<NameOrValues>,
    /// Duration of the motion in seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    duration: f64,
    /// Points of the motion: lines of time and q, separated by commas. A first line of names is skipped.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "from")]
    motion: Option<PathBuf>,
    /// Factor on the mass and inertia of each link, as in 0.9,1.1.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, default_value = "1,1")]
    masses: Range,
    /// Factor on the damping and dry friction of the file; 0 for none.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, default_value = "0,0")]
    friction: Range,
    /// Mass of a load in kg, as in 0,3.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, requires = "payload_frame")]
    payload: Option<Range>,
    /// Frame or link that carries the load.
    #[arg(long, value_name = "NAME", requires = "payload")]
    payload_frame: Option<String>,
    /// Center of the load in that frame, in metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, default_value = "0,0,0", value_parser = numbers::<3>)]
    payload_center: [f64; 3],
    /// The load lies within this distance of the center, with any distribution of mass; in metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.05)]
    payload_radius: f64,
    /// Accuracy: dividing the time further changes no bound by more than this part of a joint's range.
    #[arg(long, value_name = "PART", default_value_t = 0.01)]
    tolerance: f64,
    #[command(flatten)]
    results: Results,
}

pub(super) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_with_warnings()?.model;
    if model.nv() == 0 || !model.is_vector_space() {
        return Err(Failure::new(format!(
            "{}: the task needs joints without quaternions, and one or more (--lock holds a joint)",
            arguments.robot.shown()
        )));
    }
    let motion = motion(arguments, &model)?;
    let robots = robots(arguments, &model)?;
    interruption::end_between_steps()?;
    let options = SearchOptions {
        tolerance: arguments.tolerance.max(1e-6),
        interrupt: Some(interruption::shared_flag()),
        ..Default::default()
    };
    let bounds = torque_bounds(&model, &motion, &robots, &options).context(arguments.robot.shown())?;
    if interruption::interrupted() {
        return Ok(interruption::code());
    }
    let verdicts = verdicts(&model, &bounds);
    let (mut table, mut rows) = (
        Table::new(&[
            "joint",
            ">least, proven",
            ">attained",
            ">attained",
            ">greatest, proven",
            ">effort",
            "verdict",
        ]),
        Vec::new(),
    );
    for (j, ((name, effort), verdict)) in
        model.coordinate_names().iter().zip(efforts(&model)).zip(&verdicts).enumerate()
    {
        let (proven, attained) = (bounds.proven[j], bounds.attained[j]);
        table.row([
            name.clone(),
            down(proven.lower()),
            up(attained.least),
            down(attained.greatest),
            up(proven.upper()),
            short(effort),
            (*verdict).to_owned(),
        ]);
        rows.push(json!({
            "joint": name,
            "least": proven.lower(),
            "greatest": proven.upper(),
            "least_attained": attained.least,
            "least_time": attained.least_time,
            "greatest_attained": attained.greatest,
            "greatest_time": attained.greatest_time,
            "effort": if effort.is_finite() { Some(effort) } else { None },
            "verdict": verdict,
        }));
    }
    let is_proven = verdicts.iter().all(|verdict| *verdict == "proven" || *verdict == "-");
    let conclusion = if verdicts.iter().all(|verdict| *verdict == "-") {
        "The file has no effort limits."
    } else if is_proven {
        "The motors suffice, proven."
    } else {
        "It is not proven that the motors suffice."
    };
    let text = format!(
        "{}: torques [N·m, N] of a motion of {} s, in {} intervals of time\n\n{}\n{conclusion}\n",
        one_line(model.name()),
        short(motion.pieces().iter().map(|piece| piece.duration).sum()),
        bounds.parts.len(),
        table.text()
    );
    let json = json!({
        "robot": model.name(),
        "proven": is_proven,
        "tight": bounds.is_tight,
        "intervals": bounds.parts.len(),
        "torques": rows,
    });
    arguments
        .results
        .finish(is_proven, &text, &json, || Some(Certificate::of_torques(&model, &motion, &robots, &bounds)))
}

fn motion(arguments: &Arguments, model: &Model) -> Result<PolynomialMotion, Failure> {
    if let Some(path) = &arguments.motion {
        return read_motion(path, model);
    }
    if arguments.to.is_empty() {
        return Err(Failure::new("give the motion by --from and --to, or by --motion"));
    }
    let is_valid = arguments.duration > 0.0 && arguments.duration.is_finite();
    if !is_valid {
        return Err(Failure::new(format!("--duration: {} is not a positive number", arguments.duration)));
    }
    let start = pose(model, "--from", &arguments.from, model.initial_configuration())?;
    let end = pose(model, "--to", &arguments.to, start.clone())?;
    PolynomialMotion::rest_to_rest(&start, &end, arguments.duration).context("--to")
}

fn pose(model: &Model, option: &str, given: &[NameOrValues], mut q: Vec<f64>) -> Result<Vec<f64>, Failure> {
    for pose in given {
        match pose {
            NameOrValues::Values(values) => {
                set(
                    model,
                    option,
                    std::slice::from_ref::<JointValues>(values),
                    JointNumbers::Configuration,
                    &mut q,
                )?;
            }
            NameOrValues::Name(name) => {
                let missing =
                    || Failure::new(format!("{option}: robot `{}` has no pose `{name}`", model.name()));
                q = model.named_pose(name).ok_or_else(missing)?.0;
            }
        }
    }
    Ok(q)
}

/// Reads time and q from each line.
fn read_motion(path: &Path, model: &Model) -> Result<PolynomialMotion, Failure> {
    let text = std::fs::read_to_string(path).context(path.display())?;
    let (mut times, mut points) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Result<Vec<f64>, _> = line.split(',').map(|cell| cell.trim().parse::<f64>()).collect();
        match cells {
            Ok(cells) if cells.len() == model.nq() + 1 => {
                times.push(cells[0]);
                points.push(cells[1..].to_vec());
            }
            Ok(cells) => {
                return Err(Failure::new(format!(
                    "{}: line {}: {} numbers, but time and q are {}",
                    path.display(),
                    number + 1,
                    cells.len(),
                    model.nq() + 1
                )));
            }
            Err(_) if number == 0 => {}
            Err(cause) => {
                return Err(Failure::new(format!("{}: line {}: {cause}", path.display(), number + 1)));
            }
        }
    }
    PolynomialMotion::spline(&times, &points).context(path.display())
}

fn robots(arguments: &Arguments, model: &Model) -> Result<Uncertainty, Failure> {
    let robots = Uncertainty::none(model)
        .with_mass_factor(arguments.masses.0)
        .context("--masses")?
        .with_friction_factor(arguments.friction.0)
        .context("--friction")?;
    let (Some(mass), Some(name)) = (arguments.payload, &arguments.payload_frame) else { return Ok(robots) };
    let frame = model.frame_named(name).context("--payload-frame")?;
    let radius = arguments.payload_radius;
    if !(radius >= 0.0 && radius.is_finite()) {
        return Err(Failure::new(format!("--payload-radius: {radius} is not zero or positive")));
    }
    let payload = Payload {
        frame,
        mass: mass.0,
        center_of_mass: arguments.payload_center.map(|x| Interval::around(x, radius)),
        radius_of_gyration: radius,
    };
    robots.with_payload(model, payload).context("--payload")
}

/// The effort limit of each coordinate; infinite without one.
fn efforts(model: &Model) -> Vec<f64> {
    model.coordinate_limits().iter().map(|limits| limits.effort).collect()
}

fn verdicts(model: &Model, bounds: &TorqueBounds) -> Vec<&'static str> {
    let of = |(j, effort): (usize, f64)| {
        let attained = bounds.attained[j];
        match () {
            () if effort.is_infinite() => "-",
            () if bounds.proven[j].magnitude() <= effort => "proven",
            () if attained.greatest > effort || attained.least < -effort => "exceeded",
            () => "open",
        }
    };
    efforts(model).into_iter().enumerate().map(of).collect()
}

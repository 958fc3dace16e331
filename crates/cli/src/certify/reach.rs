//! `dynamics certify reach`.

use std::fmt::Write;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use robot_dynamics::text::one_line;
use robot_dynamics_certified::{Certificate, Farthest, Interval, ReachableSet, SearchOptions};
use serde_json::json;

use super::intervals::{down, numbers, position_box, up};
use super::results::Results;
use crate::failure::{CommandResult, Context, Failure};
use crate::joint_values::JointValues;
use crate::robot_file::RobotFile;
use crate::table::Table;

/// Prove where a frame can be over the position limits.
///
/// Prints a box that contains every position of the frame's origin in the world, and how near positions come
/// to its faces. With --keep it proves instead that the frame keeps out of half-spaces. Contacts and
/// collisions are not considered, and mimic joints count as joints of their own.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// The frame or link.
    #[arg(long, value_name = "NAME")]
    frame: String,
    /// Prove that X x + Y y + Z z is at most D for every position (x, y, z) in metres. May be repeated.
    #[arg(long, value_name = "X,Y,Z,D", allow_hyphen_values = true, value_parser = numbers::<4>)]
    keep: Vec<[f64; 4]>,
    /// Use this interval for a joint instead of its limits, as in elbow=-1,1 [rad, m].
    #[arg(long, value_name = "JOINT=LOW,HIGH,…", allow_hyphen_values = true)]
    range: Vec<JointValues>,
    /// Steps of the grid of directions: 16, 32, 64 or 128. The overestimate falls with their square.
    #[arg(long, default_value = "32", value_parser = cells())]
    cells: usize,
    #[command(flatten)]
    results: Results,
}

fn cells() -> impl TypedValueParser<Value = usize> {
    PossibleValuesParser::new(["16", "32", "64", "128"]).map(|text| text.parse().unwrap_or(32))
}

pub(super) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_with_warnings()?.model;
    let frame = model.frame_named(&arguments.frame).map_err(Failure::new)?;
    let q = position_box(&model, &arguments.range)?;
    let set = ReachableSet::new(&model, &q, frame, arguments.cells, &SearchOptions::default())
        .context(arguments.robot.shown())?;
    let mut text = format!(
        "{}, frame {}: positions over the position limits\n\n",
        one_line(model.name()),
        one_line(&arguments.frame)
    );
    let mut claims: Vec<([f64; 3], f64, Farthest)> = Vec::new();
    let mut rows = Vec::new();
    if arguments.keep.is_empty() {
        let mut table = Table::new(&["", ">least, proven", ">attained", ">attained", ">greatest, proven"]);
        for (k, name) in ["x [m]", "y [m]", "z [m]"].into_iter().enumerate() {
            let [mut forward, mut backward] = [[0.0; 3]; 2];
            (forward[k], backward[k]) = (1.0, -1.0);
            let [most, least] = [forward, backward].map(|direction| set.farthest(direction));
            table.row([
                name.to_owned(),
                down(-least.proven),
                up(-least.attained),
                down(most.attained),
                up(most.proven),
            ]);
            rows.push(json!({
                "coordinate": name.trim_end_matches(" [m]"),
                "least": -least.proven,
                "least_attained": -least.attained,
                "greatest": most.proven,
                "greatest_attained": most.attained,
            }));
            claims.push((forward, most.proven, most));
            claims.push((backward, least.proven, least));
        }
        text += &table.text();
        // The checker's grid is coarser.
        let size = set.bounding_box().iter().map(|x: &Interval| x.width()).fold(0.0, f64::max);
        for (_, most, _) in &mut claims {
            *most += 0.02 * size;
        }
    } else {
        let mut table = Table::new(&["half-space", ">greatest, proven", ">attained", "verdict"]);
        for [x, y, z, most] in &arguments.keep {
            let found = set.farthest([*x, *y, *z]);
            let verdict = verdict(&found, *most);
            table.row([
                format!("({x}, {y}, {z}) · p ≤ {most}"),
                up(found.proven),
                down(found.attained),
                verdict.to_owned(),
            ]);
            rows.push(json!({
                "direction": [x, y, z],
                "at_most": most,
                "greatest": found.proven,
                "greatest_attained": found.attained,
                "at": found.q,
                "verdict": verdict,
            }));
            claims.push(([*x, *y, *z], *most, found));
        }
        text += &table.text();
        for (_, most, found) in claims.iter().filter(|(_, most, found)| found.attained > *most) {
            let _ = writeln!(text, "\nA position beyond {most} is attained at q = {:?}.", found.q);
        }
    }
    let is_proven = claims.iter().all(|(_, most, found)| found.proven <= *most);
    let json =
        json!({ "robot": model.name(), "frame": arguments.frame, "proven": is_proven, "bounds": rows });
    arguments.results.finish(is_proven, &text, &json, || {
        is_proven.then(|| Certificate::of_reach(&model, &q, frame, &claims))
    })
}

fn verdict(found: &Farthest, most: f64) -> &'static str {
    match () {
        () if found.proven <= most => "proven",
        () if found.attained > most => "false",
        () => "open; try more --cells",
    }
}

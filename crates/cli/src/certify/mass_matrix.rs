//! `dynamics certify mass-matrix`.

use robot_dynamics_certified::{Certificate, Definiteness, SearchOptions, mass_matrix_definiteness};
use serde_json::json;

use super::intervals::position_box;
use super::results::Results;
use crate::failure::{CommandResult, Context};
use crate::interruption;
use crate::joint_values::JointValues;
use crate::robot_file::RobotFile;
use crate::table::count;

/// Prove that the mass matrix is positive definite over the position limits.
///
/// If every body has inertia of its own, or a rotor, M is positive definite in every configuration. Otherwise
/// the box of the limits is divided until M = L D Lᵀ has positive pivots in intervals.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Use this interval for a joint instead of its limits, as in elbow=-1,1 [rad, m].
    #[arg(long, value_name = "JOINT=LOW,HIGH,…", allow_hyphen_values = true)]
    range: Vec<JointValues>,
    /// Largest number of boxes.
    #[arg(long, default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1..))]
    boxes: u32,
    #[command(flatten)]
    results: Results,
}

pub(super) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_with_warnings()?.model;
    let q = position_box(&model, &arguments.range)?;
    interruption::end_between_steps()?;
    let options = SearchOptions {
        boxes: arguments.boxes as usize,
        interrupt: Some(interruption::shared_flag()),
        ..Default::default()
    };
    let found = mass_matrix_definiteness(&model, &q, &options).context(arguments.robot.shown())?;
    let text = match &found {
        Definiteness::ByOwnInertias => {
            "M(q) is positive definite in every configuration, proven: each body has inertia of its own.\n"
                .to_owned()
        }
        Definiteness::ByDivision { boxes, .. } => format!(
            "M(q) is positive definite over the position limits, proven in {}.\n",
            if *boxes == 1 { "one box".into() } else { format!("{boxes} boxes") }
        ),
        Definiteness::Disproven { q } => {
            format!("M(q) is not positive definite, or singular to rounding, at q = {q:?}.\n")
        }
        Definiteness::Open { region } => {
            let region: Vec<String> = region.iter().map(ToString::to_string).collect();
            format!(
                "Not proven after {}; M(q) is open in the box {}.\n",
                count(arguments.boxes as usize, "box"),
                region.join(" × ")
            )
        }
        _ => "Not proven.\n".to_owned(),
    };
    let is_proven = found.is_proven();
    let json = json!({ "robot": model.name(), "proven": is_proven, "result": text.trim_end() });
    arguments.results.finish(is_proven, &text, &json, || {
        is_proven.then(|| Certificate::of_definiteness(&model, &q, &found))
    })
}

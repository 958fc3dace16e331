//! `dynamics inspect`: the contents of a robot file.

mod features;
mod machine_code;
mod simulation;

use std::collections::HashMap;
use std::fmt::Write;
use std::process::ExitCode;

use robot_dynamics::description::{Disposition, JointDescription, LinkDescription, LoadReport};
use robot_dynamics::model::Model;
use robot_dynamics::text::one_line;

use crate::failure::{CommandResult, Failure};
use crate::inspection::Inspection;
use crate::output::{print, print_json};
use crate::robot_file::{LoadedRobot, RobotFile};
use crate::singular_poses::SingularPoses;
use crate::table::{Table, count, short};

pub(crate) use self::machine_code::MachineCode;
pub(crate) use self::simulation::DefaultSimulation;

/// Show a robot's tree, joints, limits, masses and sensors, and which parts of its file the reader or the
/// default simulation leaves out.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// List every line of the load report, including values that were read as written.
    #[arg(long)]
    all: bool,
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let LoadedRobot { model, report, .. } = arguments.robot.load()?;
    let singular = SingularPoses::sample(&model);
    let simulation = DefaultSimulation::of(&model);
    if arguments.json {
        let inspection = serde_json::to_string(&Inspection::of(&model, &report, &singular, &simulation));
        print_json(&(inspection.map_err(Failure::new)? + "\n"))?;
    } else {
        // Each part is printed when it is complete, to save memory for robots with many links.
        print(&head(&model))?;
        print("\n")?;
        print(&tree(&model))?;
        print("\n")?;
        print(&coordinates(&model))?;
        for part in features::parts(&model) {
            print(&format!("\n{part}"))?;
        }
        if let Some(text) = singular.text() {
            print(&format!("\nMass matrix: {}\n", one_line(&text)))?;
        }
        print(&format!("\n{}\n{}", simulation.text(), MachineCode::of(&model).text()))?;
        print_load_report(&report, arguments.all)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn head(model: &Model) -> String {
    let description = model.description();
    let freedom = if model.nv() == 1 { "degree of freedom" } else { "degrees of freedom" };
    let mut text = format!(
        "{}: {}, {}, {} {freedom}",
        one_line(model.name()),
        count(description.links.len(), "link"),
        count(description.joints.len(), "joint"),
        model.nv(),
    );
    if model.nq() != model.nv() {
        let _ = write!(text, " (nq {}, nv {})", model.nq(), model.nv());
    }
    let _ = writeln!(text, ", {} kg", short(model.total_mass()));
    text
}

/// Largest indentation of the tree in levels; without it the text of a chain would grow as the square of its
/// length.
const MAX_INDENT: usize = 200;

/// The links as a tree, each with its mass and its parent joint.
fn tree(model: &Model) -> String {
    let description = model.description();
    let index: HashMap<&str, usize> =
        description.links.iter().enumerate().map(|(k, link)| (link.name.as_str(), k)).collect();
    let mut joints_below: Vec<Vec<&JointDescription>> = vec![Vec::new(); description.links.len()];
    let mut is_child = vec![false; description.links.len()];
    for joint in &description.joints {
        if let (Some(&parent), Some(&child)) =
            (index.get(joint.parent.as_str()), index.get(joint.child.as_str()))
        {
            joints_below[parent].push(joint);
            is_child[child] = true;
        }
    }
    let mut text = String::new();
    // Link, depth and parent joint. Children are pushed in reverse, so that they are popped in order.
    let root = is_child.iter().position(|is_child| !is_child);
    let mut pending: Vec<(usize, usize, Option<&JointDescription>)> =
        root.map(|root| (root, 0, None)).into_iter().collect();
    while let Some((link, depth, joint)) = pending.pop() {
        let LinkDescription { name, mass_properties, .. } = &description.links[link];
        let mass = match mass_properties {
            Some(properties) => format!("{} kg", short(properties.mass())),
            None => "no mass".into(),
        };
        let how =
            joint.map_or_else(String::new, |joint| format!("  <- {} ({})", joint.name, joint.kind.name()));
        let line = format!("{}{name}  {mass}{how}", "  ".repeat(depth.min(MAX_INDENT)));
        let _ = writeln!(text, "  {}", one_line(&line));
        pending.extend(
            joints_below[link]
                .iter()
                .rev()
                .map(|joint| (index[joint.child.as_str()], depth + 1, Some(*joint))),
        );
    }
    text
}

fn coordinates(model: &Model) -> String {
    let mut table = Table::new(&[
        ">v",
        "joint",
        "kind",
        ">lower",
        ">upper",
        ">velocity",
        ">effort",
        ">damping",
        ">friction",
        "mimics",
    ]);
    for joint in model.joints().iter().filter(|joint| joint.nv > 0 || joint.mimic.is_some()) {
        let index = match joint.nv {
            0 => "-".into(),
            1 => joint.v_index.to_string(),
            several => format!("{}-{}", joint.v_index, joint.v_index + several - 1),
        };
        let follows = joint.mimic.as_ref().map_or_else(String::new, |mimic| {
            let sign = if mimic.offset < 0.0 { '-' } else { '+' };
            let offset = match mimic.offset {
                0.0 => String::new(),
                offset => format!(" {sign} {}", short(offset.abs())),
            };
            format!("{} · {}{offset}", short(mimic.ratio), mimic.joint)
        });
        let limits = joint.limits;
        table.row(
            [index, joint.name.clone(), joint.kind.to_string()]
                .into_iter()
                .chain([limits.lower, limits.upper, limits.velocity, limits.effort].map(short))
                .chain([joint.passive.damping, joint.passive.friction].map(short))
                .chain([follows]),
        );
    }
    if model.nv() == 0 {
        return "The robot has no degree of freedom.\n".into();
    }
    let head = "Joints in the order of q and v (rad or m, s, N·m or N; - for unlimited):";
    format!("{head}\n{}", table.text())
}

/// Size of the report's text that is collected before it is printed \[bytes\].
const BUFFER_SIZE: usize = 1 << 16;

fn print_load_report(report: &LoadReport, all: bool) -> Result<(), Failure> {
    let counts = &report.counts;
    let mut text = format!(
        "\nLoad report: {}; {} without effect on dynamics\n",
        counts.sums(),
        count(counts.not_dynamics, "element")
    );
    let listed = report.findings.iter().filter(|finding| all || finding.disposition() != Disposition::Read);
    for finding in listed {
        let (line, place, disposition) = (finding.line(), finding.place(), finding.disposition());
        let (place, message) = (one_line(place), one_line(finding.message()));
        let line = if line == 0 { String::new() } else { format!("line {line}: ") };
        let _ = writeln!(text, "  {}: {line}{place}: {disposition}: {message}", finding.severity());
        if text.len() > BUFFER_SIZE {
            print(&text)?;
            text.clear();
        }
    }
    if counts.unlisted > 0 {
        let _ = writeln!(text, "  and {} more", counts.unlisted);
    }
    print(&text)
}

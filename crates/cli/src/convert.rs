//! `dynamics convert`: writes a robot or a scene in a file format, and lists the features that this format
//! lacks.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use robot_dynamics::description::{RobotDescription, UnsupportedFeature, WrittenFile};
use robot_dynamics::model::{Model, neutral, random_state};
use robot_dynamics::text::one_line;
use robot_dynamics::{Format, LoadOptions, load_description_from_text};
use robot_dynamics_number::SplitMix64;

use crate::destination::refuse_clashes;
use crate::failure::{CommandResult, Context, Failure};
use crate::interruption;
use crate::output::{print, print_line};
use crate::output_file::{OutputFile, finish_all};
use crate::robot_file::{LoadedRobot, RobotFile};

/// Number of poses at which the mass matrices of both files are compared.
const POSES: usize = 3;
/// Largest allowed difference of M, relative to its largest entry: rounding over a chain of frames.
const MASS_TOLERANCE: f64 = 1e-9;
/// Number of messages of one kind that are printed one by one.
const MAX_MESSAGES: usize = 20;
/// Number of names in one message.
const MAX_NAMES: usize = 8;

/// Convert a robot or a scene to URDF or MJCF.
///
/// Features that the output format lacks are listed by name: physics as warnings, appearance and metadata as
/// notes. The command reads its output back and compares the mass matrices before it writes the file.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Output file: NAME.urdf, or NAME.xml or NAME.mjcf for MJCF; - for standard output. With --strict
    /// nothing is written if the format lacks physics of the robot.
    output: PathBuf,
    /// Output format, if the file's name does not tell it.
    #[arg(long, value_name = "FORMAT")]
    to: Option<OutputFormat>,
}

/// A format of the option `--to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutputFormat {
    Urdf,
    Mjcf,
}

impl OutputFormat {
    fn word(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let Arguments { robot, output, .. } = arguments;
    let shown = output.display();
    let to = match (arguments.to, Format::of(output)) {
        (Some(to), _) => to,
        (None, Some(Format::Urdf)) => OutputFormat::Urdf,
        (None, Some(_)) => OutputFormat::Mjcf,
        (None, None) => {
            let message = format!(
                "{shown}: unknown output format; name the file .urdf or .xml, or give --to urdf or --to mjcf"
            );
            return Err(Failure::new(message));
        }
    };
    let LoadedRobot { model, report, .. } = robot.load()?;
    refuse_clashes(robot.path(), &report.files, &[("the output", output)])?;
    robot.print_warnings(&report);
    let written = write(model.description(), to, output).context(robot.shown())?;
    tell_left_out(&written, output);
    let lost = written.lost_physics().count();
    if lost > 0 && robot.is_strict() {
        let message = format!(
            "{shown} is not written: {} cannot represent the physics listed above ({lost})",
            to.word()
        );
        return Err(Failure::new(message));
    }
    let off = difference(model.description(), &written.text)
        .context(format!("{shown}: reading the output back"))?;
    let is_standard_output = interruption::while_writing(|| {
        let mut file = OutputFile::create(output)?;
        let done = file.write_all(written.text.as_bytes()).and_then(|()| finish_all(&mut [&mut file]));
        done.context(format!("cannot write {shown}"))?;
        Ok(file.is_standard_output())
    })?;
    if !is_standard_output {
        let mass = if model.nv() == 0 {
            "the robot has no degree of freedom".into()
        } else {
            format!("M agrees to {off:.0e} of its largest entry at {POSES} poses")
        };
        let lost = if lost == 0 { "no physics lost".into() } else { format!("physics lost: {lost}") };
        let told = format!("wrote {shown}: {}, {lost}; {mass}", to.word());
        print(&format!("{}\n", one_line(&told)))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn write(robot: &RobotDescription, to: OutputFormat, output: &Path) -> Result<WrittenFile, Failure> {
    let format = match to {
        OutputFormat::Urdf => Format::Urdf,
        OutputFormat::Mjcf => Format::Mjcf,
    };
    // Paths in a file on standard output are relative to this folder.
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    robot_dynamics::write(robot, format, Some(folder)).map_err(Failure::new)
}

/// Lists the features that the format lacks, physics first. A message about several joints or links is one
/// line.
fn tell_left_out(written: &WrittenFile, output: &Path) {
    for (word, physics) in [("warning", true), ("note", false)] {
        let mut messages: Vec<(&str, Vec<&str>)> = Vec::new();
        let mut index = HashMap::new();
        for UnsupportedFeature { place, message, .. } in
            written.left_out.iter().filter(|one| one.physics == physics)
        {
            let at = *index.entry(message.as_str()).or_insert(messages.len());
            if at == messages.len() {
                messages.push((message, Vec::new()));
            }
            messages[at].1.push(place);
        }
        for (message, places) in messages.iter().take(MAX_MESSAGES) {
            let named: Vec<&str> = places.iter().take(MAX_NAMES).copied().collect();
            let more = if places.len() > MAX_NAMES {
                format!(" and {} more", places.len() - MAX_NAMES)
            } else {
                String::new()
            };
            print_line(format_args!("{word}: {}: {}{more}: {message}", output.display(), named.join(", ")));
        }
        if messages.len() > MAX_MESSAGES {
            print_line(format_args!(
                "{word}: {}: and {} more messages",
                output.display(),
                messages.len() - MAX_MESSAGES
            ));
        }
    }
}

/// The largest difference of M, relative to its largest entry, between a robot and its written text. Joint
/// couplings become mimic joints in both.
fn difference(robot: &RobotDescription, text: &str) -> Result<f64, Failure> {
    let back = load_description_from_text(text, &LoadOptions::default())
        .map_err(|error| Failure::new(error.messages().join("; ")))?;
    let [ours, theirs] = [robot.clone(), back.description].map(|mut robot| {
        robot.couplings_to_followers();
        Model::new(robot)
    });
    let (ours, theirs) = (ours.map_err(Failure::new)?, theirs.map_err(Failure::new)?);
    if (ours.nq(), ours.nv()) != (theirs.nq(), theirs.nv()) {
        let message = format!(
            "the output has {} degrees of freedom instead of {}; please report this",
            theirs.nv(),
            ours.nv()
        );
        return Err(Failure::new(message));
    }
    let mut random = SplitMix64::new(1);
    let mut worst = 0.0_f64;
    for pose in 0..POSES {
        let q = if pose == 0 { neutral(&ours) } else { random_state(&ours, &mut random).q };
        let mass = ours.mass_matrix(&q).map_err(Failure::new)?;
        let off = (theirs.mass_matrix(&q).map_err(Failure::new)? - &mass).amax();
        worst = worst.max(if off == 0.0 { 0.0 } else { off / mass.amax() });
    }
    // This also rejects NaN.
    if worst <= MASS_TOLERANCE {
        return Ok(worst);
    }
    Err(Failure::new(format!(
        "the mass matrix differs by {worst:e} of its largest entry; please report this"
    )))
}

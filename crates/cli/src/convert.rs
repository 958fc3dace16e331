//! `dynamics convert`: a robot from one file format to the other, with what the other cannot say.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use dynamics::SplitMix64;
use multibody::text::one_line;
use multibody::{LeftOut, Model, RobotDescription, WrittenFile, neutral, random_state};
use robot_dynamics::{Format, Options, describe_text};

use crate::destination::refuse_clashes;
use crate::failure::{Context, Failure, Outcome};
use crate::interruption;
use crate::output::{print, tell};
use crate::output_file::{OutputFile, finish_all};
use crate::robot_file::{Loaded, RobotFile};

/// Poses at which the mass matrices of both files are compared.
const POSES: usize = 3;
/// What M may be off, relative to its largest entry: rounding over a chain of frames.
const ALLOWED: f64 = 1e-9;
/// Things of a kind that are told one by one.
const SHOWN: usize = 20;
/// Names that one such line holds.
const NAMED: usize = 8;

/// Write a robot in the other format: URDF from MJCF, MJCF from URDF.
///
/// What the format cannot say is told by name: physics as a warning, looks and bookkeeping as a note. The file is read
/// back before it is written, and its mass matrix compared.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// The file to write: NAME.urdf, or NAME.xml or NAME.mjcf for MJCF; - for standard output. With --strict nothing is
    /// written where the format lacks words for physics.
    output: PathBuf,
    /// The format, where the file's name does not tell it.
    #[arg(long, value_name = "FORMAT")]
    to: Option<To>,
}

/// A format, as the command line names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum To {
    Urdf,
    Mjcf,
}

impl To {
    fn word(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let Arguments { robot, output, .. } = arguments;
    let shown = output.display();
    let to = match (arguments.to, Format::of(output)) {
        (Some(to), _) => to,
        (None, Some(Format::Urdf)) => To::Urdf,
        (None, Some(_)) => To::Mjcf,
        (None, None) => {
            let message = format!(
                "{shown} does not tell the format: name it .urdf or .xml, or say --to urdf or --to mjcf"
            );
            return Err(Failure::new(message));
        }
    };
    let Loaded { model, report, .. } = robot.load()?;
    refuse_clashes(robot.path(), &report.files, &[("the output", output)])?;
    robot.print_warnings(&report);
    let written = write(model.description(), to, output).context(robot.shown())?;
    tell_left_out(&written, output);
    let lost = written.lost_physics().count();
    if lost > 0 && robot.is_strict() {
        let message = format!(
            "{shown} is not written: {} has no words for the physics named above ({lost})",
            to.word()
        );
        return Err(Failure::new(message));
    }
    let off =
        difference(model.description(), &written.text).context(format!("{shown}: the file read back"))?;
    let is_standard_output = interruption::while_writing(|| {
        let mut file = OutputFile::create(output)?;
        let done = file.write_all(written.text.as_bytes()).and_then(|()| finish_all(&mut [&mut file]));
        done.context(format!("cannot write {shown}"))?;
        Ok(file.is_standard_output())
    })?;
    if !is_standard_output {
        let mass = if model.nv() == 0 {
            "no joint moves".into()
        } else {
            format!("M the same to {off:.0e} of its largest entry at {POSES} poses")
        };
        let lost =
            if lost == 0 { "no physics left out".into() } else { format!("left out of physics: {lost}") };
        let told = format!("wrote {shown}: {}, {lost}; read back, {mass}", to.word());
        print(&format!("{}\n", one_line(&told)))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn write(robot: &RobotDescription, to: To, output: &Path) -> Result<WrittenFile, Failure> {
    let format = match to {
        To::Urdf => Format::Urdf,
        To::Mjcf => Format::Mjcf,
    };
    // A file on standard output lies wherever the reader puts it: here, as far as is known.
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    robot_dynamics::write(robot, format, Some(folder)).map_err(Failure::new)
}

/// What the format cannot say, physics first; what is said of several joints or links in one line.
fn tell_left_out(written: &WrittenFile, output: &Path) {
    for (word, physics) in [("warning", true), ("note", false)] {
        let mut messages: Vec<(&str, Vec<&str>)> = Vec::new();
        let mut index = HashMap::new();
        for LeftOut { place, message, .. } in written.left_out.iter().filter(|one| one.physics == physics) {
            let at = *index.entry(message.as_str()).or_insert(messages.len());
            if at == messages.len() {
                messages.push((message, Vec::new()));
            }
            messages[at].1.push(place);
        }
        for (message, places) in messages.iter().take(SHOWN) {
            let named: Vec<&str> = places.iter().take(NAMED).copied().collect();
            let more = if places.len() > NAMED {
                format!(" and {} more", places.len() - NAMED)
            } else {
                String::new()
            };
            tell(format_args!("{word}: {}: {}{more}: {message}", output.display(), named.join(", ")));
        }
        if messages.len() > SHOWN {
            tell(format_args!("{word}: {}: {} more of these", output.display(), messages.len() - SHOWN));
        }
    }
}

/// The largest difference of M, relative to its largest entry, between a robot and the text written of it, couplings
/// followed in both.
fn difference(robot: &RobotDescription, text: &str) -> Result<f64, Failure> {
    let back = describe_text(text, &Options::default())
        .map_err(|error| Failure::new(error.messages().join("; ")))?;
    let [ours, theirs] = [robot.clone(), back.description].map(|mut robot| {
        robot.couplings_to_followers();
        Model::new(robot)
    });
    let (ours, theirs) = (ours.map_err(Failure::new)?, theirs.map_err(Failure::new)?);
    if (ours.nq(), ours.nv()) != (theirs.nq(), theirs.nv()) {
        let message = format!("{} degrees of freedom became {}; please report this", ours.nv(), theirs.nv());
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
    // NaN is not within what is allowed either.
    if worst <= ALLOWED {
        return Ok(worst);
    }
    Err(Failure::new(format!("its mass matrix is off by {worst:e} of its largest entry; please report this")))
}

//! `dynamics generate`: code for one robot, with a test that holds it to the library's values.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use ::generate::{
    Arithmetic, Function, Generated, GeneratedFile, Precision, Request, Sine, Target, generate,
};
use multibody::Model;
use multibody::text::one_line;

use crate::destination::refuse_clashes;
use crate::failure::{Failure, Outcome};
use crate::inspect::count;
use crate::interruption;
use crate::output::{print, tell};
use crate::robot_file::{Loaded, RobotFile};

/// Write a program for one robot: straight-line code in Rust, C, WGSL or CUDA, from the library's own recursions.
///
/// The folder gets the code, a test that holds it to this library's values, what builds it, and a report of its operations.
/// The same command gives the same bytes. Where nothing is fused, which is the default, the code gives the library's bits, with
/// the library's own sine in place of the system's.
#[derive(clap::Args)]
#[allow(clippy::struct_excessive_bools)] // one for each option without a value
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Language and caller.
    #[arg(long, value_parser = target_parser())]
    target: String,
    /// The functions to generate; of frames and links frame_pose:NAME, frame_jacobian_world_aligned:NAME, frame_jacobian_in_frame:NAME,
    /// frame_jacobian_in_world:NAME; of each of these its slopes, NAME_derivatives and NAME_pullback.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = parse_function)]
    #[arg(default_values = ["inverse_dynamics", "forward_dynamics", "mass_matrix"])]
    functions: Vec<Function>,
    /// The folder that gets the files. Files that were generated are replaced, no others.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// What files and functions are called; the robot's name by default.
    #[arg(long)]
    name: Option<String>,
    /// Compute in single precision (f32, float): for small processors.
    #[arg(long)]
    single: bool,
    /// Round a multiply-add once. For machines that have the instruction; in Rust the code needs the standard library.
    #[arg(long)]
    fused: bool,
    /// Take sine and cosine from the platform's library instead of the code's own.
    #[arg(long)]
    platform_sine: bool,
    /// In Rust, add each function for many states at once, over the machine's vector registers: in a module `lanes` that needs the
    /// crate robot-dynamics-number.
    #[arg(long)]
    lanes: bool,
    /// Write no loops where bodies are alike, but each operation where it is done. C, CasADi and Rust have loops where these make the code shorter by a third.
    #[arg(long)]
    straight: bool,
    /// Compile and time the functions here, in C by `cc` or in Rust by `rustc`, and write MEASURED.md: bytes of code and stack, and the time
    /// of a call beside the library's. Another machine gives other numbers.
    #[arg(long)]
    measure: bool,
    /// Random states, always the same, that the test compares.
    #[arg(long, value_name = "COUNT", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    states: u16,
}

fn target_parser() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(Target::ALL.map(Target::name))
}

fn parse_function(text: &str) -> Result<Function, String> {
    text.parse().map_err(|error: ::generate::FunctionError| error.to_string())
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let target = Target::ALL.into_iter().find(|target| target.name() == arguments.target);
    let target = target.ok_or_else(|| Failure::new("no such target"))?;
    let Loaded { model, report, .. } = arguments.robot.load_to_compute()?;
    let precision = if arguments.single { Precision::Single } else { Precision::Double };
    let mut arithmetic = Arithmetic::new(precision);
    if arguments.fused {
        arithmetic = arithmetic.with_fused();
    }
    if arguments.platform_sine {
        arithmetic = arithmetic.with_sine(Sine::Platform);
    }
    let mut request = Request::new(target, arguments.functions.clone()).with_arithmetic(arithmetic);
    request.name.clone_from(&arguments.name);
    request.states = arguments.states.into();
    request.lanes = arguments.lanes;
    request.straight = arguments.straight;
    request.command = Some(command(arguments));
    let mut generated = generate(&model, &request).map_err(Failure::new)?;
    let refuse_clashes = |generated: &Generated| {
        let paths = generated.paths(&arguments.output);
        // In a folder to come there is nothing yet.
        let in_its_folder = paths.iter().filter(|path| path.parent().is_some_and(Path::is_dir));
        let outputs: Vec<_> = in_its_folder.map(|path| ("the output", path.as_path())).collect();
        refuse_clashes(arguments.robot.path(), &report.files, &outputs)
    };
    refuse_clashes(&generated)?;
    if arguments.measure {
        generated.files.push(measured(&model, &request)?);
        refuse_clashes(&generated)?;
    }
    if let Some(renamed) = &generated.renamed {
        tell(format_args!("note: {renamed}"));
    }
    interruption::while_writing(|| generated.write(&arguments.output).map_err(Failure::new))?;
    let bytes: usize = generated.files.iter().map(|file| file.text.len()).sum();
    print(&format!(
        "{}: {} of {} in {}, {} of {} bytes\n",
        one_line(&arguments.output.display().to_string()),
        count(request.functions.len(), "function"),
        one_line(model.name()),
        target.name(),
        count(generated.files.len(), "file"),
        bytes,
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// What the functions cost here.
fn measured(model: &Model, request: &Request) -> Result<GeneratedFile, Failure> {
    let folder = std::env::temp_dir().join(format!("dynamics-measure-{}", std::process::id()));
    interruption::remove_when_ended(&folder)?;
    let file = ::generate::measure(model, request, &folder).map_err(Failure::new);
    if file.is_err() {
        interruption::wait_for_end();
    }
    // It was made for this alone.
    let _ = std::fs::remove_dir_all(&folder);
    file
}

/// What the files say that they come from: the command without the folder it writes to.
fn command(arguments: &Arguments) -> String {
    let functions: Vec<String> = arguments.functions.iter().map(ToString::to_string).collect();
    let mut text = format!(
        "dynamics generate {}{} --target {} --functions {}",
        arguments.robot.shown(),
        arguments.robot.changes(),
        arguments.target,
        functions.join(",")
    );
    let flags = [
        (arguments.single, " --single"),
        (arguments.fused, " --fused"),
        (arguments.platform_sine, " --platform-sine"),
        (arguments.lanes, " --lanes"),
        (arguments.straight, " --straight"),
    ];
    flags.iter().filter(|(is_given, _)| *is_given).for_each(|(_, flag)| text += flag);
    if let Some(name) = &arguments.name {
        text.extend([" --name ", name]);
    }
    if arguments.states != 5 {
        text.extend([" --states ", &arguments.states.to_string()]);
    }
    text
}

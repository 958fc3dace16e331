//! `dynamics generate`: code for one robot, with a test that compares it with the library.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use robot_dynamics::model::Model;
use robot_dynamics::text::one_line;
use robot_dynamics_generate::{
    Arithmetic, Function, GeneratedFile, GeneratedFiles, Precision, Request, Sine, Target, generate,
};

use crate::destination::refuse_clashes;
use crate::failure::{CommandResult, Failure};
use crate::interruption;
use crate::output::{print, print_line};
use crate::robot_file::{LoadedRobot, RobotFile};
use crate::table::count;

/// Generate code for one robot in Rust, C, WGSL or CUDA from the library's recursions.
///
/// The folder receives the code, a test that compares it with values of this library, build files, and a
/// report of operation counts. The same command gives the same bytes. Without --fused, the code gives the
/// same bits as the library with the library's own sine.
#[derive(clap::Args)]
#[allow(clippy::struct_excessive_bools)] // one for each option without a value
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Target language and interface.
    #[arg(long, value_parser = target_parser())]
    target: String,
    /// Functions to generate. Functions of a frame or link: frame_pose:NAME,
    /// frame_jacobian_local_world_aligned:NAME, frame_jacobian_local:NAME, frame_jacobian_world:NAME.
    /// Derivatives of any of these: NAME_derivatives and NAME_pullback.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = parse_function)]
    #[arg(default_values_t = Request::DEFAULT_FUNCTIONS)]
    functions: Vec<Function>,
    /// Output folder. Existing files are replaced only if they were generated.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Base name of files and functions [default: the robot's name].
    #[arg(long)]
    name: Option<String>,
    /// Use single precision (f32, float), for small processors.
    #[arg(long)]
    single: bool,
    /// Use fused multiply-add, for machines that have the instruction. In Rust the code then needs the
    /// standard library.
    #[arg(long)]
    fused: bool,
    /// Use the platform's sine and cosine instead of the generated ones.
    #[arg(long)]
    platform_sine: bool,
    /// In Rust, add a module `lanes` with each function for several states at once in vector registers. It
    /// needs the crate robot-dynamics-number.
    #[arg(long)]
    lanes: bool,
    /// Write straight-line code. Without this option, C, CasADi and Rust use loops over similar bodies if
    /// they shorten the code by a third.
    #[arg(long)]
    straight: bool,
    /// Compile the functions on this machine (C with `cc`, Rust with `rustc`) and time them beside the
    /// library's. MEASURED.md gets code size, stack size, and time of a call.
    #[arg(long)]
    measure: bool,
    /// Number of random states that the test compares.
    #[arg(long, value_name = "COUNT", default_value_t = Request::DEFAULT_STATES)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    states: u16,
}

fn target_parser() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(Target::ALL.map(Target::name))
}

fn parse_function(text: &str) -> Result<Function, String> {
    text.parse().map_err(|error: robot_dynamics_generate::FunctionError| error.to_string())
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let target = Target::ALL.into_iter().find(|target| target.name() == arguments.target);
    let target = target.ok_or_else(|| Failure::new("unknown target"))?;
    let LoadedRobot { model, report, .. } = arguments.robot.load_to_compute()?;
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
    let refuse_clashes = |generated: &GeneratedFiles| {
        let paths = generated.paths(&arguments.output);
        // A new folder contains nothing to replace.
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
        print_line(format_args!("note: {renamed}"));
    }
    interruption::while_writing(|| generated.write(&arguments.output).map_err(Failure::new))?;
    let bytes: usize = generated.files.iter().map(|file| file.text.len()).sum();
    print(&format!(
        "{}: {} of {} in {}, {}, {} bytes\n",
        one_line(&arguments.output.display().to_string()),
        count(request.functions.len(), "function"),
        one_line(model.name()),
        target.name(),
        count(generated.files.len(), "file"),
        bytes,
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Measures the cost of the functions on this machine.
fn measured(model: &Model, request: &Request) -> Result<GeneratedFile, Failure> {
    let folder = std::env::temp_dir().join(format!("dynamics-measure-{}", std::process::id()));
    interruption::remove_when_ended(&folder)?;
    let file = robot_dynamics_generate::measure(model, request, &folder).map_err(Failure::new);
    if file.is_err() {
        interruption::wait_for_end();
    }
    // The folder has only the measurement's files.
    let _ = std::fs::remove_dir_all(&folder);
    file
}

/// The command that the files name as their origin, without the output folder.
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
    if arguments.states != Request::DEFAULT_STATES {
        text.extend([" --states ", &arguments.states.to_string()]);
    }
    text
}

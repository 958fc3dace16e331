//! The arguments that all commands with a robot share, and reading of that robot.

use std::path::{Display, Path, PathBuf};

use robot_dynamics::description::{Finding, LoadReport};
use robot_dynamics::model::{Model, lock_massless};
use robot_dynamics::plausibility::WrittenAngles;
use robot_dynamics::{FileError, LoadOptions, LoadedDescription, with_native_code};

use crate::failure::{Context, Failure};
use crate::locks::{self, Locks};
use crate::output::print_line;
use crate::singular_poses::SingularPoses;
use crate::size::refuse_beyond_memory;

/// Number of kinds of warnings that a command prints.
const WARNINGS_SHOWN: usize = 10;

/// The robot's file, and options for reading it.
#[derive(clap::Args)]
#[allow(clippy::struct_excessive_bools)] // one for each option without a value
pub(crate) struct RobotFile {
    /// The robot's file: URDF, MJCF, SDF, USD or a scene. Mesh files are read only if the inertia of a body
    /// needs them.
    robot: PathBuf,
    /// Add a floating joint between the world and the root link: six degrees of freedom, before all others.
    #[arg(long)]
    floating_base: bool,
    /// Reject a file with a warning: suspicious values, or physics that this program does not read.
    #[arg(long)]
    strict: bool,
    /// Replace impossible moments of inertia by the nearest possible ones, with a note of old and new values.
    /// Drop inertia without mass. All other values stay as written.
    #[arg(long, conflicts_with = "strict")]
    repair_inertia: bool,
    /// Search this folder for the packages of `package://NAME/…`, before those of ROS_PACKAGE_PATH and
    /// AMENT_PREFIX_PATH. It is a package or contains packages. May be repeated.
    #[arg(long, value_name = "FOLDER")]
    package_path: Vec<PathBuf>,
    /// Refuse files outside the robot's folder that the file names, for files that are not trusted.
    #[arg(long)]
    confined: bool,
    /// Add this SRDF file of the robot: groups, poses, passive joints, the joint to the world, and pairs of
    /// links that never touch. Without it no SRDF file is read.
    #[arg(long, value_name = "FILE.srdf")]
    srdf: Option<PathBuf>,
    /// Lock joints: at JOINT=NUMBER, or at the position nearest to zero within the limits. A joint of several
    /// numbers takes them in a row. Locked joints become fixed joints.
    #[arg(long, value_name = "JOINT,…", allow_hyphen_values = true)]
    lock: Vec<Locks>,
    /// Lock all joints that move no inertia in any pose, so that forces determine the accelerations.
    #[arg(long)]
    lock_massless: bool,
}

/// A robot, read and compiled.
pub(crate) struct LoadedRobot {
    pub model: Model,
    pub report: LoadReport,
    /// The angles as written in the file, for the check of units.
    pub angles: Vec<WrittenAngles>,
}

impl RobotFile {
    /// The file's name, for messages.
    pub(crate) fn shown(&self) -> Display<'_> {
        self.robot.display()
    }

    /// The options that change the robot, as they were given.
    pub(crate) fn changes(&self) -> String {
        let flags = [
            (self.floating_base, " --floating-base"),
            (self.repair_inertia, " --repair-inertia"),
            (self.lock_massless, " --lock-massless"),
        ];
        let mut text: String =
            flags.iter().filter(|(is_given, _)| *is_given).map(|(_, flag)| *flag).collect();
        if let Some(srdf) = &self.srdf {
            text.extend([" --srdf ", &srdf.to_string_lossy()]);
        }
        for locks in &self.lock {
            text.extend([" --lock ", &locks.to_string()]);
        }
        text
    }

    /// Whether warnings are errors.
    pub(crate) fn is_strict(&self) -> bool {
        self.strict
    }

    /// The robot's file, which no output may replace, like the report's `files`.
    pub(crate) fn path(&self) -> &Path {
        &self.robot
    }

    pub(crate) fn load(&self) -> Result<LoadedRobot, Failure> {
        let shown = self.shown();
        let mut options = LoadOptions::default();
        if self.floating_base {
            options = options.with_floating_base();
        }
        if self.strict {
            options = options.with_strict();
        }
        if self.repair_inertia {
            options = options.with_repaired_inertia();
        }
        if self.confined {
            options = options.with_confined();
        }
        if let Some(srdf) = &self.srdf {
            options = options.with_srdf(srdf);
        }
        for folder in &self.package_path {
            if !folder.is_dir() {
                return Err(Failure::new(format!("--package-path {}: folder not found", folder.display())));
            }
            options = options.with_package_path(folder);
        }
        let LoadedDescription { mut description, report, angles, .. } =
            robot_dynamics::load_description(&self.robot, &options).map_err(|error| self.refused(&error))?;
        // A scene of MJCF may have a fixed base and a body that the option frees.
        let is_omitted = |finding: &Finding| finding.message().ends_with("the floating base is omitted");
        if self.floating_base && report.findings.iter().any(is_omitted) {
            print_line(format_args!(
                "note: {shown}: the root link already floats; --floating-base has no effect"
            ));
        }
        locks::apply(&mut description, &self.lock)?;
        if self.lock_massless {
            let locked = lock_massless(&mut description).context(&shown)?;
            print_line(format_args!("note: --lock-massless: {}", locks::message(&locked)));
        }
        let model = with_native_code(Model::new(description).context(shown)?);
        Ok(LoadedRobot { model, report, angles })
    }

    /// Loads the robot and prints the warnings of its file.
    pub(crate) fn load_with_warnings(&self) -> Result<LoadedRobot, Failure> {
        let loaded = self.load()?;
        self.print_warnings(&loaded.report);
        Ok(loaded)
    }

    /// Loads the robot for a command that computes with it. Warns on standard error about a singular M and
    /// about suspicious values in the file. Fails if the matrices of the robot do not fit in memory.
    pub(crate) fn load_to_compute(&self) -> Result<LoadedRobot, Failure> {
        let loaded = self.load()?;
        if let Some(text) = SingularPoses::sample(&loaded.model).text() {
            print_line(format_args!("warning: {text}"));
        }
        self.print_warnings(&loaded.report);
        refuse_beyond_memory(&loaded.model)?;
        Ok(loaded)
    }

    /// All errors of the file.
    fn refused(&self, error: &FileError) -> Failure {
        let shown = self.shown();
        if error.is_unreadable() {
            // This message names the file.
            return Failure::new(error);
        }
        let (messages, unlisted) = (error.messages(), error.unlisted());
        match (&messages[..], unlisted) {
            ([message], 0) => Failure::new(format!("{shown}: {message}")),
            (_, unlisted) => {
                let count = messages.len() + unlisted;
                let more = (unlisted > 0).then(|| format!("and {unlisted} more"));
                Failure::several(&format!("{shown}: {count} errors"), messages.into_iter().chain(more))
            }
        }
    }

    /// Prints the file's warnings on standard error, one line for each kind.
    pub(crate) fn print_warnings(&self, report: &LoadReport) {
        let (shown, groups) = (self.shown(), report.grouped_warnings());
        for warning in groups.iter().take(WARNINGS_SHOWN) {
            print_line(format_args!("warning: {shown}: {warning}"));
        }
        let more: usize = groups.iter().skip(WARNINGS_SHOWN).map(|group| group.findings().len()).sum();
        if more > 0 {
            print_line(format_args!("warning: {shown}: and {more} more; `dynamics inspect` lists all"));
        }
    }
}

//! The arguments every command with a robot shares, and reading that robot.

use std::path::{Display, Path, PathBuf};

use multibody::plausibility::WrittenAngles;
use multibody::{Base, LoadReport, Model};
use robot_dynamics::{Described, FileError, Options, with_native_code};

use crate::failure::{Context, Failure};
use crate::locks::{self, Locks};
use crate::output::tell;
use crate::singular_poses::SingularPoses;
use crate::size::refuse_beyond_memory;

/// Kinds of warnings shown by the commands that compute.
const WARNINGS_SHOWN: usize = 10;

/// Which robot, and how to read its file.
#[derive(clap::Args)]
#[allow(clippy::struct_excessive_bools)] // one for each option without a value
pub(crate) struct RobotFile {
    /// The robot's file, URDF or MJCF. Meshes are needed only where an MJCF file leaves a body's inertia to them.
    robot: PathBuf,
    /// Free the root link: six more degrees of freedom, before all others.
    #[arg(long)]
    floating_base: bool,
    /// Refuse a file with a warning: suspicious values, and physics that this program does not read.
    #[arg(long)]
    strict: bool,
    /// Move moments that no rigid body has to the nearest it can have, showing old and new values; drop
    /// inertia without mass. All other values stay as written.
    #[arg(long, conflicts_with = "strict")]
    repair_inertia: bool,
    /// Look in this folder for the packages of `package://NAME/…`: a package, or a folder that holds packages; before
    /// those of ROS_PACKAGE_PATH. Repeat it for several.
    #[arg(long, value_name = "FOLDER")]
    package_path: Vec<PathBuf>,
    /// Hold joints still: at zero, or at the limit nearest to it, or where JOINT=NUMBER says (a joint of several
    /// numbers takes them in a row). They become fixed joints.
    #[arg(long, value_name = "JOINT,…", allow_hyphen_values = true)]
    lock: Vec<Locks>,
    /// Hold all joints still that move no inertia in any pose: without them, forces determine the accelerations.
    #[arg(long)]
    lock_massless: bool,
}

/// A robot, read and compiled.
pub(crate) struct Loaded {
    pub model: Model,
    pub report: LoadReport,
    /// The angles as the file writes them, for judging its units.
    pub angles: Vec<WrittenAngles>,
}

impl RobotFile {
    /// The file's name, for a message.
    pub(crate) fn shown(&self) -> Display<'_> {
        self.robot.display()
    }

    /// The options that make another robot of the file's, as they were given.
    pub(crate) fn changes(&self) -> String {
        let flags = [
            (self.floating_base, " --floating-base"),
            (self.repair_inertia, " --repair-inertia"),
            (self.lock_massless, " --lock-massless"),
        ];
        let mut text: String =
            flags.iter().filter(|(is_given, _)| *is_given).map(|(_, flag)| *flag).collect();
        for locks in &self.lock {
            text.extend([" --lock ", &locks.to_string()]);
        }
        text
    }

    /// Whether what is only reported otherwise is to be a failure.
    pub(crate) fn is_strict(&self) -> bool {
        self.strict
    }

    /// The file, which no output may replace, nor any other of the report's `files`.
    pub(crate) fn path(&self) -> &Path {
        &self.robot
    }

    pub(crate) fn load(&self) -> Result<Loaded, Failure> {
        let shown = self.shown();
        let mut options = Options::default();
        if self.floating_base {
            options = options.with_floating_base();
        }
        if self.strict {
            options = options.with_strict();
        }
        if self.repair_inertia {
            options = options.with_repaired_inertia();
        }
        for folder in &self.package_path {
            if !folder.is_dir() {
                return Err(Failure::new(format!(
                    "--package-path {}: there is no such folder",
                    folder.display()
                )));
            }
            options = options.with_package_path(folder);
        }
        let Described { mut description, report, angles, .. } =
            robot_dynamics::describe(&self.robot, &options).map_err(|error| self.refused(&error))?;
        if self.floating_base && description.base == Base::Fixed {
            tell(format_args!(
                "note: {shown}: the robot's root floats already; --floating-base changes nothing"
            ));
        }
        locks::apply(&mut description, &self.lock)?;
        if self.lock_massless {
            let locked = description.lock_massless().context(&shown)?;
            tell(format_args!("note: --lock-massless: {}", locks::told(&locked)));
        }
        let model = with_native_code(Model::new(description).context(shown)?);
        Ok(Loaded { model, report, angles })
    }

    /// The robot for a command that computes with it: says on standard error where its M is singular and what its file
    /// left to doubt, so that no number comes from suspicious values in silence; refuses what memory does not hold.
    pub(crate) fn load_to_compute(&self) -> Result<Loaded, Failure> {
        let loaded = self.load()?;
        if let Some(text) = SingularPoses::look(&loaded.model).text() {
            tell(format_args!("warning: {text}"));
        }
        self.print_warnings(&loaded.report);
        refuse_beyond_memory(&loaded.model)?;
        Ok(loaded)
    }

    /// All that is wrong with the file, at once.
    fn refused(&self, error: &FileError) -> Failure {
        let shown = self.shown();
        if error.is_unreadable() {
            // This message names the file itself.
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

    /// The file's warnings on standard error, those of one kind in one line.
    pub(crate) fn print_warnings(&self, report: &LoadReport) {
        let (shown, groups) = (self.shown(), report.grouped_warnings());
        for warning in groups.iter().take(WARNINGS_SHOWN) {
            tell(format_args!("warning: {shown}: {warning}"));
        }
        let more: usize = groups.iter().skip(WARNINGS_SHOWN).map(|group| group.findings().len()).sum();
        if more > 0 {
            tell(format_args!("warning: {shown}: {more} more; `dynamics inspect` lists all"));
        }
    }
}

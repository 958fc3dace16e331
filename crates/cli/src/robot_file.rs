//! The arguments every command with a robot shares, and reading that robot.

use std::path::{Display, PathBuf};

use multibody::Model;
use urdf::{LoadReport, Options, Robot, UrdfError};

use crate::failure::{Context, Failure};

/// Which robot, and how to read its file.
#[derive(clap::Args)]
pub(crate) struct RobotFile {
    /// The robot's URDF file. Meshes are not needed.
    robot: PathBuf,
    /// Free the root link: six more degrees of freedom, before all others.
    #[arg(long)]
    floating_base: bool,
    /// Refuse a file that holds physics this program does not read, instead of reporting it.
    #[arg(long)]
    strict: bool,
    /// Replace an inertia that no rigid body has by the nearest one, and report it.
    #[arg(long, conflicts_with = "strict")]
    repair_inertia: bool,
}

/// A robot, read and compiled.
pub(crate) struct Loaded {
    pub model: Model,
    pub report: LoadReport,
}

impl RobotFile {
    /// The file's name, for a message.
    pub(crate) fn shown(&self) -> Display<'_> {
        self.robot.display()
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
        let read = urdf::load(&self.robot, &options).map_err(|error| match error {
            // This one names the file itself.
            UrdfError::Unreadable { .. } => Failure::new(error),
            error => Failure::new(format!("{shown}: {error}")),
        });
        let Robot { description, report, .. } = read?;
        let model = Model::new(description).context(shown)?;
        Ok(Loaded { model, report })
    }
}

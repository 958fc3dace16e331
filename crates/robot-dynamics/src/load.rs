//! One door for robot files, of whichever format.

use std::path::Path;

use mjcf::FileSet;
use multibody::plausibility::WrittenAngles;
use multibody::simulator::SimulationBuilder;
use multibody::{LoadReport, Model, ModelError, RobotDescription};
use thiserror::Error;
use urdf::Options;

use crate::{height_field, mesh_corners};

/// A robot, read and compiled.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Robot {
    /// What every algorithm takes.
    pub model: Model,
    /// What was read, defaulted, suspicious and ignored, by line.
    pub report: LoadReport,
}

impl Robot {
    /// A simulation with everything that the file states, to be changed and built; meshes and height fields are read from their files.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    /// let robot = robot_dynamics::load(file)?;
    /// let mut simulation = robot.simulation().conservative().build()?;
    /// simulation.run_for(0.1)?;
    /// assert!(simulation.ledger().drift() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn simulation(&self) -> SimulationBuilder<'static> {
        simulation(&self.model)
    }
}

/// [`Robot::simulation`] of a model.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// let robot = robot_dynamics::load(file)?;
/// let simulation = robot_dynamics::simulation(&robot.model).step(0.01).build()?;
/// assert_eq!(simulation.step_size(), 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn simulation(model: &Model) -> SimulationBuilder<'static> {
    SimulationBuilder::new(model).meshes(mesh_corners).height_fields(height_field)
}

/// A robot as its file describes it, before it is compiled: to lock joints, add a payload, or judge its units.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Described {
    /// Links and joints, as the file states them.
    pub description: RobotDescription,
    /// What was read, defaulted, suspicious and ignored, by line.
    pub report: LoadReport,
    /// The angles of all frames as the file writes them, before they become rotations.
    pub angles: Vec<WrittenAngles>,
}

impl Described {
    /// Compiles it. With the feature `native` its functions have machine code, as by [`with_native_code`](crate::with_native_code).
    ///
    /// # Errors
    /// [`ModelError`] if the robot cannot move as described.
    pub fn compile(self) -> Result<Robot, ModelError> {
        let model = Model::new(self.description)?;
        #[cfg(feature = "native")]
        let model = functions::with_native_code(model);
        Ok(Robot { model, report: self.report })
    }
}

/// Why a robot was not loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file has no meaning; all that is wrong with it, by line.
    #[error(transparent)]
    File(#[from] FileError),
    /// The robot that it describes has none.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Why a robot's file was refused, by its format.
///
/// ```
/// use robot_dynamics::{FileError, Options, describe_text};
/// let refused = describe_text("<mujoco><worldbody><joint/></worldbody></mujoco>", &Options::default());
/// let refused = refused.expect_err("a joint of the world");
/// assert!(matches!(refused, FileError::Mjcf(_)) && refused.messages().len() == 1);
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file with the outermost element `<robot>`, or one of no known format.
    #[error(transparent)]
    Urdf(#[from] urdf::LoadError),
    /// A file with the outermost element `<mujoco>`.
    #[error(transparent)]
    Mjcf(#[from] mjcf::LoadError),
}

impl FileError {
    /// What is wrong, each with line and place; see [`unlisted`](Self::unlisted).
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Urdf(error) => error.errors().iter().map(ToString::to_string).collect(),
            Self::Mjcf(error) => error.errors().iter().map(ToString::to_string).collect(),
        }
    }

    /// Errors beyond those listed.
    pub fn unlisted(&self) -> usize {
        match self {
            Self::Urdf(error) => error.unlisted(),
            Self::Mjcf(error) => error.unlisted(),
        }
    }

    /// Whether the file could not be read at all; the message names it then.
    pub fn is_unreadable(&self) -> bool {
        match self {
            Self::Urdf(error) => matches!(error.errors(), [urdf::UrdfError::Unreadable { .. }]),
            Self::Mjcf(error) => matches!(
                error.errors(),
                [mjcf::MjcfError::Xml { file, source: robot_xml::XmlError::Unreadable { .. } }] if file.is_empty()
            ),
        }
    }

    /// What else was found in the file: its warnings and notes, as far as it could be read.
    pub fn report(&self) -> &LoadReport {
        match self {
            Self::Urdf(error) => error.report(),
            Self::Mjcf(error) => error.report(),
        }
    }
}

/// Reads a robot's file and compiles it: base fixed to the world, suspicious values taken as written and told in the
/// report. Meshes are not opened.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
/// let robot = robot_dynamics::load(file)?; // two rods of 1 m, 2 kg and 1 kg
/// let hold = robot.model.gravity_forces(&[FRAC_PI_4, FRAC_PI_2])?;
/// assert!((hold[0] - 10.4051).abs() < 1e-4 && (hold[1] + 3.4684).abs() < 1e-4); // as printed, to four places
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all that is wrong, each with its line and what to do.
pub fn load(path: impl AsRef<Path>) -> Result<Robot, LoadError> {
    load_with(path, &Options::default())
}

/// [`load`] by choice: a floating base, a strict reading, inertias repaired.
///
/// ```
/// use robot_dynamics::{Options, load_with};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/humanoid.urdf");
/// let robot = load_with(file, &Options::default().with_floating_base())?;
/// assert_eq!(robot.model.joints()[0].nv, 6);
/// # Ok::<(), robot_dynamics::LoadError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn load_with(path: impl AsRef<Path>, options: &Options) -> Result<Robot, LoadError> {
    Ok(describe(path, options)?.compile()?)
}

/// Reads a robot's file, without compiling it.
///
/// ```
/// use robot_dynamics::{Options, describe};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// let mut described = describe(file, &Options::default())?;
/// described.description.gravity = [0.0, 0.0, -1.62]; // to the moon with it
/// let on_earth = robot_dynamics::load(file)?.model.gravity_forces(&[0.3, 1.2])?;
/// let on_moon = described.compile()?.model.gravity_forces(&[0.3, 1.2])?;
/// assert!((on_moon - on_earth * (1.62 / 9.81)).amax() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FileError`] lists all that is wrong, each with its line and what to do.
pub fn describe(path: impl AsRef<Path>, options: &Options) -> Result<Described, FileError> {
    let path = path.as_ref();
    // Read once: it may be a pipe. What cannot be read at all is told by URDF's reader.
    let text =
        robot_xml::read_file(path).map_err(|error| urdf::LoadError::from(urdf::UrdfError::from(error)))?;
    if is_mjcf(&text) {
        Ok(mjcf::parse_as(&text, path, options)?.into())
    } else {
        Ok(urdf::parse_as(&text, path, options)?.into())
    }
}

/// [`describe`] of a file's text: from a database, an archive, another program.
///
/// ```
/// use robot_dynamics::{Options, describe_text};
/// let text = r#"<robot name="point"><link name="world"/></robot>"#;
/// let described = describe_text(text, &Options::default())?;
/// assert_eq!(described.description.links[0].name, "world");
/// let text = r#"<mujoco><worldbody><body name="stone"/></worldbody></mujoco>"#;
/// let described = describe_text(text, &Options::default())?;
/// assert_eq!(described.description.links[1].name, "stone");
/// # Ok::<(), robot_dynamics::FileError>(())
/// ```
///
/// # Errors
/// As [`describe`].
pub fn describe_text(text: &str, options: &Options) -> Result<Described, FileError> {
    if is_mjcf(text) {
        Ok(mjcf::parse(text, options)?.into())
    } else {
        Ok(urdf::parse(text, options)?.into())
    }
}

/// [`describe`] of a file among others in memory: what a browser or an archive hands over. An MJCF file's includes and the meshes that inertia comes from are
/// looked for there.
///
/// ```
/// use robot_dynamics::{FileSet, Options, describe_among};
/// let files = FileSet::new([
///     ("scene.xml", "<mujoco><include file='stone.xml'/></mujoco>"),
///     ("stone.xml", "<mujoco><worldbody><body name='stone'/></worldbody></mujoco>"),
/// ]);
/// let described = describe_among(&files, "scene.xml", &Options::default())?;
/// assert_eq!(described.description.links[1].name, "stone");
/// # Ok::<(), robot_dynamics::FileError>(())
/// ```
///
/// # Errors
/// As [`describe`].
pub fn describe_among(
    files: &FileSet,
    path: impl AsRef<Path>,
    options: &Options,
) -> Result<Described, FileError> {
    let path = path.as_ref();
    match files.get(path).map(robot_xml::text_of) {
        Some(Ok(text)) if !is_mjcf(&text) => Ok(urdf::parse(&text, options)?.into()),
        // What cannot be read is told as of a file that cannot.
        _ => Ok(mjcf::load_among(files, path, options)?.into()),
    }
}

impl From<urdf::Robot> for Described {
    fn from(urdf::Robot { description, report, angles, .. }: urdf::Robot) -> Self {
        Self { description, report, angles }
    }
}

impl From<mjcf::Robot> for Described {
    fn from(mjcf::Robot { description, report, angles, .. }: mjcf::Robot) -> Self {
        Self { description, report, angles }
    }
}

/// Whether the outermost element is MJCF's; any other is left to URDF's reader, which says what is wrong with it.
fn is_mjcf(text: &str) -> bool {
    let first = robot_xml::outermost(text);
    matches!(first, Some("mujoco" | "mujocoinclude"))
}

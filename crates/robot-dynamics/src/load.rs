//! Loads robot files of all formats.

mod content;
mod file_error;

pub(crate) use self::content::Content;
pub use self::file_error::FileError;

use std::path::Path;

use robot_dynamics_mjcf::FileSet;
use robot_dynamics_urdf::{LoadOptions, Srdf};

use crate::description::{Base, Finding, JointDescription, LoadReport, ModelError, RobotDescription};
use crate::model::Model;
use crate::plausibility::WrittenAngles;
use crate::scene_file::{self, ReadFile, Shared, Source, is_scene};
use crate::simulation::SimulationBuilder;
use crate::{height_field, mesh_corners};

/// A loaded robot: its model and the load report.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Robot {
    /// The compiled model, which is the argument of every algorithm.
    pub model: Model,
    /// Everything that was read, defaulted, suspicious or ignored, by line.
    pub report: LoadReport,
}

impl Robot {
    /// A builder of a simulation with everything in the robot's file. Mesh and height field files are opened
    /// for contact.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    /// let robot = robot_dynamics::load(file)?;
    /// let mut simulation = robot.simulation().conservative().build()?;
    /// simulation.run_for(0.1)?;
    /// assert!(simulation.energy_account().drift() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn simulation(&self) -> SimulationBuilder<'static> {
        simulation(&self.model)
    }
}

/// A builder of a simulation of a model: see [`Robot::simulation`].
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// let robot = robot_dynamics::load(file)?;
/// let simulation = robot_dynamics::simulation(&robot.model).dt(0.01).build()?;
/// assert_eq!(simulation.dt(), 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn simulation(model: &Model) -> SimulationBuilder<'static> {
    SimulationBuilder::new(model).meshes(mesh_corners).height_fields(height_field)
}

/// A robot before it is compiled: to lock joints, add a payload, or check its units.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[doc(alias = "Described")]
pub struct LoadedDescription {
    /// Links and joints, as written in the file.
    pub description: RobotDescription,
    /// Everything that was read, defaulted, suspicious or ignored, by line.
    pub report: LoadReport,
    /// The angles of all frames as written, before conversion to rotations.
    pub angles: Vec<WrittenAngles>,
}

impl LoadedDescription {
    /// Compiles the description to a model. With the feature `native` its functions are compiled to machine
    /// code, as by [`with_native_code`](crate::with_native_code).
    ///
    /// # Errors
    /// [`ModelError`] if the description is invalid.
    pub fn compile(self) -> Result<Robot, ModelError> {
        Ok(Robot { model: compile(self.description)?, report: self.report })
    }

    /// [`compile`](Self::compile) with the report in the error.
    fn compile_with_report(self) -> Result<Robot, FileError> {
        let Self { description, report, .. } = self;
        match compile(description) {
            Ok(model) => Ok(Robot { model, report }),
            Err(source) => Err(FileError::Model { source: Box::new(source), report: Box::new(report) }),
        }
    }
}

fn compile(description: RobotDescription) -> Result<Model, ModelError> {
    let model = Model::new(description)?;
    #[cfg(feature = "native")]
    let model = robot_dynamics_functions::with_native_code(model);
    Ok(model)
}

/// Reads and compiles a robot file, with the base fixed to the world. Suspicious values are taken as written
/// and reported.
///
/// URDF opens no other file. SDF opens the models that it includes, and USD, with the feature `usd`, the
/// layers that it references. A scene opens the files of its robots and
/// meshes. MJCF opens included and attached files, and the mesh files from which the inertia of a body comes.
/// These files may be anywhere on the disk, unless the options confine them to the folder of the robot's file
/// ([`LoadOptions::with_confined`]). The mesh files of shapes are located, and opened for contact by
/// [`Robot::simulation`]. An SRDF file is read only if the options name it ([`LoadOptions::with_srdf`]).
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
/// let robot = robot_dynamics::load(file)?; // two rods of 1 m, 2 kg and 1 kg
/// let hold = robot.model.gravity_forces(&[FRAC_PI_4, FRAC_PI_2])?;
/// // N·m, as printed in the chapter
/// assert!((hold[0] - 10.4051).abs() < 1e-4 && (hold[1] + 3.4684).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FileError`] lists all errors, each with its line and advice.
pub fn load(path: impl AsRef<Path>) -> Result<Robot, FileError> {
    load_with(path, &LoadOptions::default())
}

/// Reads and compiles a robot file with options: a floating base, a strict reading, repair of inertias.
///
/// ```
/// use robot_dynamics::{LoadOptions, load_with};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/humanoid.urdf");
/// let robot = load_with(file, &LoadOptions::default().with_floating_base())?;
/// assert_eq!(robot.model.joints()[0].nv, 6);
/// # Ok::<(), robot_dynamics::FileError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, FileError> {
    load_description(path, options)?.compile_with_report()
}

/// Reads a robot file without compiling it. [`load`] lists the other files that are opened.
///
/// ```
/// use robot_dynamics::{LoadOptions, load_description};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// let mut described = load_description(file, &LoadOptions::default())?;
/// described.description.gravity = [0.0, 0.0, -1.62]; // on the moon
/// let on_earth = robot_dynamics::load(file)?.model.gravity_forces(&[0.3, 1.2])?;
/// let on_moon = described.compile()?.model.gravity_forces(&[0.3, 1.2])?;
/// assert!((on_moon - on_earth * (1.62 / 9.81)).amax() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FileError`] lists all errors, each with its line and advice.
#[doc(alias = "describe")]
pub fn load_description(
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<LoadedDescription, FileError> {
    let path = path.as_ref();
    // A failure is reported as an error of the URDF reader.
    let content = Content::read(path)
        .map_err(|error| robot_dynamics_urdf::LoadError::from(robot_dynamics_urdf::UrdfError::from(error)))?;
    let mut loaded = match content {
        #[cfg(feature = "usd")]
        Content::Usd(content) => robot_dynamics_usd::parse_as(&content, path, options)?.into(),
        Content::Text(text) if is_scene(&text) => {
            let source = Source::disk(path, options.confined);
            scene_file::read(&text, &source, &mut Shared::new(options, robot_of_scene))?.into()
        }
        Content::Text(text) => robot_from_text(&text, Some(path), options)?,
    };
    add_srdf(&mut loaded, options, None)?;
    Ok(loaded)
}

/// Reads a robot, not a scene, from the text of the file at a path, or of no file.
fn robot_from_text(
    text: &str,
    path: Option<&Path>,
    options: &LoadOptions,
) -> Result<LoadedDescription, FileError> {
    #[cfg(feature = "usd")]
    if robot_dynamics_usd::is_usd(text.as_bytes()) {
        return Ok(match path {
            Some(path) => robot_dynamics_usd::parse_as(text.as_bytes(), path, options)?.into(),
            None => robot_dynamics_usd::parse_with_files(text.as_bytes(), "robot.usda", [], options)?.into(),
        });
    }
    Ok(match (is_mjcf(text), path) {
        (true, Some(path)) => robot_dynamics_mjcf::parse_as(text, path, options)?.into(),
        (true, None) => robot_dynamics_mjcf::parse(text, options)?.into(),
        (false, Some(path)) => robot_dynamics_urdf::parse_as(text, path, options)?.into(),
        (false, None) => robot_dynamics_urdf::parse(text, options)?.into(),
    })
}

/// Reads a robot of a scene.
fn robot_of_scene(
    content: &Content,
    source: &Source<'_>,
    options: &LoadOptions,
) -> Result<ReadFile, Vec<String>> {
    let read = |path: Option<&Path>| {
        let mut loaded = match content {
            Content::Text(text) => robot_from_text(text, path, options)?,
            #[cfg(feature = "usd")]
            Content::Usd(content) => {
                robot_dynamics_usd::parse_as(content, path.unwrap_or(Path::new("robot.usd")), options)?.into()
            }
        };
        add_srdf(&mut loaded, options, None)?;
        Ok(loaded)
    };
    let loaded = match source {
        Source::Disk { path, .. } => read(Some(path)),
        Source::Memory { files, path } => load_description_from_files(files, path, options),
        Source::Text => read(None),
    };
    let loaded = loaded.map_err(|error: FileError| error.messages())?;
    let LoadedDescription { description, report, angles } = loaded;
    Ok(ReadFile { description, report, angles })
}

/// Reads a robot from the text of a file, for example from a database or another program.
///
/// ```
/// use robot_dynamics::{LoadOptions, load_description_from_text};
/// let text = r#"<robot name="point"><link name="world"/></robot>"#;
/// let described = load_description_from_text(text, &LoadOptions::default())?;
/// assert_eq!(described.description.links[0].name, "world");
/// let text = r#"<mujoco><worldbody><body name="stone"/></worldbody></mujoco>"#;
/// let described = load_description_from_text(text, &LoadOptions::default())?;
/// assert_eq!(described.description.links[1].name, "stone");
/// # Ok::<(), robot_dynamics::FileError>(())
/// ```
///
/// # Errors
/// As [`load_description`].
#[doc(alias = "describe_text")]
pub fn load_description_from_text(text: &str, options: &LoadOptions) -> Result<LoadedDescription, FileError> {
    let mut loaded = if is_scene(text) {
        scene_file::read(text, &Source::Text, &mut Shared::new(options, robot_of_scene))?.into()
    } else {
        robot_from_text(text, None, options)?
    };
    add_srdf(&mut loaded, options, None)?;
    Ok(loaded)
}

/// Reads a robot file from files in memory, for example from a browser or an archive. They also provide the
/// files that an MJCF file includes, and the meshes from which inertia comes.
///
/// ```
/// use robot_dynamics::{FileSet, LoadOptions, load_description_from_files};
/// let files = FileSet::new([
///     ("scene.xml", "<mujoco><include file='stone.xml'/></mujoco>"),
///     ("stone.xml", "<mujoco><worldbody><body name='stone'/></worldbody></mujoco>"),
/// ]);
/// let described = load_description_from_files(&files, "scene.xml", &LoadOptions::default())?;
/// assert_eq!(described.description.links[1].name, "stone");
/// # Ok::<(), robot_dynamics::FileError>(())
/// ```
///
/// # Errors
/// As [`load_description`].
#[doc(alias = "describe_among")]
pub fn load_description_from_files(
    files: &FileSet,
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<LoadedDescription, FileError> {
    let path = path.as_ref();
    let mut loaded = match files.get(path).map(Content::of) {
        #[cfg(feature = "usd")]
        Some(Ok(Content::Usd(content))) => {
            robot_dynamics_usd::parse_with_files(&content, path, files.iter(), options)?.into()
        }
        Some(Ok(Content::Text(text))) if is_scene(&text) => {
            let source = Source::Memory { files, path: path.to_owned() };
            scene_file::read(&text, &source, &mut Shared::new(options, robot_of_scene))?.into()
        }
        Some(Ok(Content::Text(text))) if !is_mjcf(&text) => {
            let content = |path: &Path| files.get(path).map(<[u8]>::to_vec);
            robot_dynamics_urdf::parse_with_files(&text, path, &content, options)?.into()
        }
        // The MJCF reader reports files that are missing or not text.
        _ => robot_dynamics_mjcf::load_from_files(files, path, options)?.into(),
    };
    add_srdf(&mut loaded, options, Some(files))?;
    Ok(loaded)
}

/// Adds the SRDF file in the options, from files in memory or from the disk. Its findings follow those of the
/// robot's file, with its name before their places.
fn add_srdf(
    loaded: &mut LoadedDescription,
    options: &LoadOptions,
    files: Option<&FileSet>,
) -> Result<(), FileError> {
    let Some(srdf) = &options.srdf else { return Ok(()) };
    let (file, text) = match srdf {
        Srdf::Text(text) => (String::from("SRDF"), Ok(text.clone())),
        Srdf::File(path) => {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            let text = match files {
                Some(files) => files.text(path),
                None => robot_dynamics_xml::read_file(path),
            };
            (name, text)
        }
    };
    let refused = |source| FileError::Srdf { file: file.clone(), source };
    let text = text.map_err(|error| refused(robot_dynamics_urdf::UrdfError::from(error).into()))?;
    let LoadedDescription { description, report, .. } = loaded;
    let added = robot_dynamics_urdf::add_srdf(description, &text, options).map_err(refused)?;
    for finding in &added.findings {
        let place = format!("{file}: {}", finding.place());
        report.add(Finding::new(finding.line(), place, finding.disposition(), finding.message()));
    }
    if let (Srdf::File(path), None) = (srdf, files) {
        report.add_files([path.as_path()]);
    }
    let moves = |joint: &&JointDescription| joint.mimic.is_none();
    let joints: usize = description.joints.iter().filter(moves).map(|joint| joint.kind.nv()).sum();
    report.counts.links = description.links.len();
    report.counts.joints = description.joints.len();
    report.counts.degrees_of_freedom = joints + if description.base == Base::Floating { 6 } else { 0 };
    Ok(())
}

impl From<ReadFile> for LoadedDescription {
    fn from(ReadFile { description, report, angles }: ReadFile) -> Self {
        Self { description, report, angles }
    }
}

impl From<robot_dynamics_urdf::Robot> for LoadedDescription {
    fn from(
        robot_dynamics_urdf::Robot { description, report, angles, .. }: robot_dynamics_urdf::Robot,
    ) -> Self {
        Self { description, report, angles }
    }
}

#[cfg(feature = "usd")]
impl From<robot_dynamics_usd::Robot> for LoadedDescription {
    fn from(
        robot_dynamics_usd::Robot { description, report, angles, .. }: robot_dynamics_usd::Robot,
    ) -> Self {
        Self { description, report, angles }
    }
}

impl From<robot_dynamics_mjcf::Robot> for LoadedDescription {
    fn from(
        robot_dynamics_mjcf::Robot { description, report, angles, .. }: robot_dynamics_mjcf::Robot,
    ) -> Self {
        Self { description, report, angles }
    }
}

/// Whether the outermost element is that of MJCF. The URDF reader reads all others, and reports unknown
/// formats.
fn is_mjcf(text: &str) -> bool {
    let first = robot_dynamics_xml::outermost(text);
    matches!(first, Some("mujoco" | "mujocoinclude"))
}

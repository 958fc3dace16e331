//! From a file to a robot.

use std::path::{Path, PathBuf};

use multibody::plausibility::WrittenAngles;
use multibody::{Base, LoadReport, RobotDescription, Treatment};

use crate::floating_base::free_base;
use crate::folder::{FileSet, Folder};
use crate::reader::Reader;
use crate::source::{Source, in_file_place};
use crate::tendon::armature_to_joints;
use crate::tree::Tree;
use crate::{LoadError, MjcfError, Options};

/// A robot and the account of how it was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Robot {
    /// Links and joints, as the file states them: one tree under the world, a link without mass named `world`.
    pub description: RobotDescription,
    /// What was read, defaulted, suspicious and ignored.
    pub report: LoadReport,
    /// The Euler angles of all frames as the file means them \[rad\], before they become rotations.
    pub angles: Vec<WrittenAngles>,
}

/// Reads an MJCF file and the files that it includes. Mesh files are opened only where a body's inertia is to be inferred
/// from them.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/arm.xml");
/// let robot = mjcf::load(file, &mjcf::Options::default())?;
/// assert_eq!(robot.report.counts.ignored_physics, 0); // all that moves the robot was read
/// let model = multibody::Model::new(robot.description)?;
/// assert_eq!((model.nq(), model.nv()), (6, 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all that is wrong, each with its line and what to do.
pub fn load(path: impl AsRef<Path>, options: &Options) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let text = robot_xml::read_file(path).map_err(|source| MjcfError::Xml { file: String::new(), source })?;
    parse_as(&text, path, options)
}

/// Reads the text of the file at that path, which is opened no more: what it includes and the meshes it names are looked for
/// from there.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/arm.xml");
/// let text = std::fs::read_to_string(file)?;
/// let robot = mjcf::parse_as(&text, file, &mjcf::Options::default())?;
/// assert_eq!(robot, mjcf::load(file, &mjcf::Options::default())?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_as(text: &str, path: impl AsRef<Path>, options: &Options) -> Result<Robot, LoadError> {
    read(text, Some(path.as_ref()), None, options.clone())
}

/// Reads the file of that path among files in memory: what it includes and the meshes that inertia comes from are looked for
/// there. Shapes keep their meshes' names alone.
///
/// ```
/// use mjcf::{FileSet, Options, load_among};
/// let scene = "<mujoco><include file='ball.xml'/></mujoco>";
/// let ball = "<mujoco><worldbody><body name='ball'><geom size='0.1'/></body></worldbody></mujoco>";
/// let files = FileSet::new([("scene.xml", scene), ("ball.xml", ball)]);
/// assert_eq!(load_among(&files, "scene.xml", &Options::default())?.description.links[1].name, "ball");
/// # Ok::<(), mjcf::LoadError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn load_among(files: &FileSet, path: impl AsRef<Path>, options: &Options) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let text = files.text(path).map_err(|source| MjcfError::Xml { file: String::new(), source })?;
    read(&text, Some(path), Some(files), options.clone())
}

/// Reads the text of an MJCF file, which can include no others and name no mesh files that inertia comes from.
///
/// ```
/// let text = r#"<mujoco><worldbody><body name="ball">
///   <freejoint name="float"/> <geom size="0.1"/>
/// </body></worldbody></mujoco>"#;
/// let robot = mjcf::parse(text, &mjcf::Options::default())?;
/// assert_eq!(robot.description.joints[0].name, "float");
/// let ball = robot.description.links[1].mass_properties.expect("a ball of water");
/// assert!((ball.mass() - 4.18879).abs() < 1e-5); // 4/3 π r³ · 1000 kg/m³
/// # Ok::<(), mjcf::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all that is wrong, each with its line and what to do.
pub fn parse(text: &str, options: &Options) -> Result<Robot, LoadError> {
    read(text, None, None, options.clone())
}

fn read(
    text: &str,
    path: Option<&Path>,
    given: Option<&FileSet>,
    options: Options,
) -> Result<Robot, LoadError> {
    let Source { tree, faults, errors, folder, .. } = Source::read(text, path, given)?;
    let mut reader = Reader::new(&tree, options);
    reader.errors = errors;
    let main = folder.as_ref().filter(|folder| folder.is_on_disk()).and(path);
    reader.main = main;
    reader.meshes.folder = folder;
    for (file, line, message) in faults {
        let place = in_file_place(&tree.files[file], "mujoco");
        reader.push(line, place, Treatment::AsWritten, message);
    }
    let stem = path.and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
    robot(reader, stem)
}

fn robot(mut reader: Reader<'_>, file: Option<String>) -> Result<Robot, LoadError> {
    let name = reader.tree.nodes[Tree::ROOT].attribute("model").filter(|name| !name.trim().is_empty());
    let name = name.map(str::to_owned).or(file).unwrap_or_else(|| "MuJoCo Model".into());
    let mut robot = RobotDescription::new(name);
    reader.read_compilers();
    let disabled = reader.read_option(&mut robot);
    reader.other_options();
    reader.read_classes();
    reader.read_meshes();
    reader.read_materials();
    let mut bodies = reader.bodies();
    if reader.has_too_many_copies() {
        // Of a robot cut short the rest would say what is not so.
        return Err(LoadError::new(reader.errors, MjcfError::line, reader.report));
    }
    let mut masses = reader.masses(&bodies);
    reader.align_free_bodies(&mut bodies, &mut masses);
    let places = reader.assemble(&mut robot, &bodies, &masses, disabled);
    let pairs = reader.pairs(&bodies);
    reader.shapes(&bodies, &places.links, &pairs, &mut robot);
    reader.keep_pairs(pairs, &mut robot);
    reader.exclusions(&bodies, &places, &mut robot);
    reader.tendons(&places, disabled, &mut robot);
    reader.equalities(&bodies, &places, &mut robot);
    let actuators = reader.actuators(&places, disabled, &mut robot);
    armature_to_joints(&mut robot);
    reader.poses(&places, &actuators, &mut robot);
    reader.sensors(&bodies, &places, &mut robot);
    reader.derived(&bodies, &places, &actuators, &mut robot);
    drop((bodies, masses, places, actuators));
    reader.list_unread();
    free_base(&mut reader, &mut robot);

    let mut report = core::mem::take(&mut reader.report);
    let opened = reader.meshes.folder.as_ref().map(Folder::opened).unwrap_or_default();
    let named = robot.shapes.iter().filter_map(|shape| shape.shape.file()?.1);
    report.add_files(reader.main.into_iter().chain(opened.iter().map(PathBuf::as_path)).chain(named));
    robot.name.clone_into(&mut report.robot);
    report.counts.links = robot.links.len();
    report.counts.joints = robot.joints.len();
    let free: usize = robot.joints.iter().map(|joint| joint.kind.nv()).sum();
    report.counts.degrees_of_freedom = free + if robot.base == Base::Floating { 6 } else { 0 };
    report.sort();
    reader.errors.append(&mut reader.refused_warnings);
    if reader.errors.is_empty() {
        Ok(Robot { description: robot, report, angles: reader.angles })
    } else {
        Err(LoadError::new(reader.errors, MjcfError::line, report))
    }
}

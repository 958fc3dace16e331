//! Loads a robot from an MJCF file.

use std::path::{Path, PathBuf};

use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{Base, Disposition, LoadReport, RobotDescription};

use crate::floating_base::add_floating_base;
use crate::folder::{FileSet, Folder};
use crate::reader::Reader;
use crate::source::Source;
use crate::tendon::armature_to_joints;
use crate::tree::Tree;
use crate::tree::in_file_place;
use crate::{LoadError, LoadOptions, MjcfError};

/// A robot and the report of how it was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Robot {
    /// Links and joints, as written in the file: one tree, whose root is a link without mass named `world`.
    pub description: RobotDescription,
    /// Everything that was read, defaulted, suspicious or ignored.
    pub report: LoadReport,
    /// The Euler angles of all frames \[rad\], before conversion to rotations.
    pub angles: Vec<WrittenAngles>,
}

/// Reads an MJCF file and the files that it includes or attaches. A mesh file is opened only if the inertia
/// of a body comes from it. As in MuJoCo, these files may be anywhere on the disk. They are searched in the
/// folder of the main file or of the attached model, and then beside the file that names them.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/arm.xml");
/// let robot = robot_dynamics_mjcf::load(file, &robot_dynamics_mjcf::LoadOptions::default())?;
/// assert_eq!(robot.report.counts.ignored_physics, 0); // no physics was ignored
/// let model = robot_dynamics::model::Model::new(robot.description)?;
/// assert_eq!((model.nq(), model.nv()), (6, 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all that is wrong, each with its line and what to do.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let text = robot_dynamics_xml::read_file(path)
        .map_err(|source| MjcfError::Xml { file: String::new(), source })?;
    parse_as(&text, path, options)
}

/// Reads a text as the content of the file at `path`, which is not opened. Included files and meshes are
/// located from the folder of `path`.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/arm.xml");
/// let text = std::fs::read_to_string(file)?;
/// let robot = robot_dynamics_mjcf::parse_as(&text, file, &robot_dynamics_mjcf::LoadOptions::default())?;
/// assert_eq!(robot, robot_dynamics_mjcf::load(file, &robot_dynamics_mjcf::LoadOptions::default())?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_as(text: &str, path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    read(text, Some(path.as_ref()), None, options.clone())
}

/// Reads the file at `path` from files in memory, which also provide included files and the meshes that
/// inertia comes from. Shapes keep the names of their mesh files, without paths.
///
/// ```
/// use robot_dynamics_mjcf::{FileSet, LoadOptions, load_from_files};
/// let scene = "<mujoco><include file='ball.xml'/></mujoco>";
/// let ball = "<mujoco><worldbody><body name='ball'><geom size='0.1'/></body></worldbody></mujoco>";
/// let files = FileSet::new([("scene.xml", scene), ("ball.xml", ball)]);
/// assert_eq!(load_from_files(&files, "scene.xml", &LoadOptions::default())?.description.links[1].name, "ball");
/// # Ok::<(), robot_dynamics_mjcf::LoadError>(())
/// ```
///
/// # Errors
/// As [`load`].
#[doc(alias = "load_among")]
pub fn load_from_files(
    files: &FileSet,
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let text = files.text(path).map_err(|source| MjcfError::Xml { file: String::new(), source })?;
    read(&text, Some(path), Some(files), options.clone())
}

/// Reads the text of an MJCF file. Includes, and mesh files that inertia comes from, are errors, because a
/// text has no folder.
///
/// ```
/// let text = r#"<mujoco><worldbody><body name="ball">
///   <freejoint name="float"/> <geom size="0.1"/>
/// </body></worldbody></mujoco>"#;
/// let robot = robot_dynamics_mjcf::parse(text, &robot_dynamics_mjcf::LoadOptions::default())?;
/// assert_eq!(robot.description.joints[0].name, "float");
/// let ball = robot.description.links[1].mass_properties.expect("a ball of water");
/// assert!((ball.mass() - 4.18879).abs() < 1e-5); // 4/3 π r³ · 1000 kg/m³
/// # Ok::<(), robot_dynamics_mjcf::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all that is wrong, each with its line and what to do.
pub fn parse(text: &str, options: &LoadOptions) -> Result<Robot, LoadError> {
    read(text, None, None, options.clone())
}

fn read(
    text: &str,
    path: Option<&Path>,
    given: Option<&FileSet>,
    options: LoadOptions,
) -> Result<Robot, LoadError> {
    let Source { tree, faults, errors, folder, budget, .. } =
        Source::read(text, path, given, options.confined)?;
    let mut reader = Reader::new(&tree, options);
    reader.errors = errors;
    reader.budget = budget;
    let main = folder.as_ref().filter(|folder| folder.is_on_disk()).and(path);
    reader.main = main;
    reader.meshes.folder = folder;
    for (file, line, message) in faults {
        let place = in_file_place(&tree.files[file], "mujoco");
        reader.push(line, place, Disposition::AsWritten, message);
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
    reader.read_height_fields();
    let mut bodies = reader.bodies();
    if reader.budget.is_exceeded() {
        // The other findings would describe an incomplete robot.
        return Err(LoadError::new(reader.errors, MjcfError::sorted_at, reader.report));
    }
    let mut masses = reader.masses(&bodies);
    reader.align_free_bodies(&mut bodies, &mut masses);
    let table = reader.assemble(&mut robot, &bodies, &masses, disabled);
    let pairs = reader.pairs(&bodies);
    reader.shapes(&bodies, &table.links, &pairs, &mut robot);
    reader.keep_pairs(pairs, &mut robot);
    reader.fluid(&bodies, &masses, &table.links, disabled, &mut robot);
    reader.exclusions(&bodies, &table, &mut robot);
    let at_rest = reader.tendons(&bodies, &table, disabled, &mut robot);
    reader.equalities(&bodies, &table, &mut robot);
    let actuators = reader.actuators((&bodies, &table), disabled, &mut robot);
    armature_to_joints(&mut robot);
    reader.poses(&table, &actuators, &mut robot);
    reader.sensors(&bodies, &table, &mut robot);
    reader.resolve_rest_lengths(&table, &at_rest, &mut robot);
    reader.resolve_damping_ratios(&bodies, &table, &actuators, &mut robot);
    disabled.remove_from(&mut robot);
    drop((bodies, masses, table, actuators));
    reader.list_unread();
    add_floating_base(&mut reader, &mut robot);

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
        Err(LoadError::new(reader.errors, MjcfError::sorted_at, report))
    }
}

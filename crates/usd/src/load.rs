//! Loads a robot from a USD file.

use std::path::{Path, PathBuf};

use robot_dynamics_xml::SIZE_LIMIT;

use crate::read::{Robot, robot};
use crate::resolver::plain;
use crate::stage::{self, Source};
use crate::{LoadError, LoadOptions, UsdError};

/// Reads a USD file and the files that it references.
///
/// ```
/// let options = robot_dynamics_usd::LoadOptions::default();
/// let refused = robot_dynamics_usd::load("nowhere.usda", &options).unwrap_err();
/// assert!(matches!(refused.errors(), [robot_dynamics_usd::UsdError::Unreadable { .. }]));
/// ```
///
/// # Errors
/// [`LoadError`] lists all errors, each with the path of its prim and advice.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let unreadable = |source| UsdError::Unreadable { path: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut content = Vec::new();
    std::io::Read::read_to_end(&mut std::io::Read::take(file, SIZE_LIMIT as u64 + 1), &mut content)
        .map_err(unreadable)?;
    parse_as(&content, path, options)
}

/// Reads the content of the file at `path`, which is not opened. Files that it references are read from the
/// disk.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/usd/panda_urdf.usdc");
/// let content = std::fs::read(file)?;
/// let robot = robot_dynamics_usd::parse_as(&content, file, &robot_dynamics_usd::LoadOptions::default())?;
/// assert_eq!(robot.description.joints[0].name, "panda_joint1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_as(content: &[u8], path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let whole =
        path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned());
    let main = with_extension(&plain(&whole), content);
    let root = main.parent().filter(|_| options.confined).map(Path::to_owned);
    parse(Source { main, content: content.to_vec(), root, in_memory: None }, path, options)
}

/// Reads a file of a set of files in memory. No file on the disk is read.
///
/// ```
/// use std::path::Path;
/// let main = b"#usda 1.0\n( subLayers = [@./ball.usda@] )\n";
/// let ball: &[u8] = b"#usda 1.0\ndef Sphere \"ball\" (apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsCollisionAPI\"]) {}";
/// let files = [(Path::new("ball.usda"), ball)];
/// let options = robot_dynamics_usd::LoadOptions::default();
/// let robot = robot_dynamics_usd::parse_with_files(main, "main.usda", files, &options)?;
/// assert_eq!(robot.description.links[1].name, "ball");
/// # Ok::<(), robot_dynamics_usd::LoadError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_with_files<'f>(
    content: &[u8],
    path: impl AsRef<Path>,
    files: impl IntoIterator<Item = (&'f Path, &'f [u8])>,
    options: &LoadOptions,
) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    let main = with_extension(&plain(path), content);
    let files = files.into_iter().map(|(path, content)| (plain(path), content.to_vec())).collect();
    parse(Source { main, content: content.to_vec(), root: None, in_memory: Some(files) }, path, options)
}

/// The path with an extension that fits the content, by which the parser chooses the format.
fn with_extension(path: &Path, content: &[u8]) -> PathBuf {
    let known = path.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase);
    if matches!(known.as_deref(), Some("usd" | "usda" | "usdc" | "usdz")) {
        return path.to_owned();
    }
    let end = if content.starts_with(b"PK") { "usdz" } else { "usd" };
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(end);
    name.into()
}

fn parse(source: Source, path: &Path, options: &LoadOptions) -> Result<Robot, LoadError> {
    if source.content.len() > SIZE_LIMIT {
        return Err(UsdError::TooLarge { limit: SIZE_LIMIT }.into());
    }
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("robot").to_owned();
    let scene = stage::read(source)?;
    robot(&scene, &stem, options)
}

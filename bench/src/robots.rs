//! The measured robots, by name.

use std::fmt;
use std::path::{Path, PathBuf};

use robot_dynamics::description::RobotDescription;
use robot_dynamics::model::Model;
use robot_dynamics::urdf::LoadOptions;
use serde_json::Value;

use crate::chain;

/// Robots of `robots/`: file, and whether the root link floats.
const URDF: &[(&str, bool)] =
    &[("two_r", false), ("ur5", false), ("panda", false), ("quadruped", true), ("humanoid", true)];
/// Robots of `testdata/golden/`.
const DESCRIBED: &[&str] = &["talos"];
/// Lengths of the chains. Rows of a matrix with 256 columns map to the same cache sets, those with 250
/// columns do not.
const CHAINS: &[usize] = &[4, 8, 16, 32, 64, 128, 250, 256];

/// The robot that cannot be measured, and its reader's error.
#[derive(Debug)]
pub struct RobotError {
    what: String,
    cause: String,
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.cause)
    }
}

impl std::error::Error for RobotError {}

fn error(what: impl fmt::Display, cause: impl fmt::Display) -> RobotError {
    RobotError { what: what.to_string(), cause: cause.to_string() }
}

/// All robots of the benchmarks, in the order of measurement.
///
/// # Errors
/// [`RobotError`] if a file of the repository is missing or invalid.
pub fn all_robots() -> Result<Vec<Model>, RobotError> {
    let named = URDF.iter().map(|(name, _)| *name).chain(DESCRIBED.iter().copied());
    named.map(robot_by_name).chain(CHAINS.iter().map(|&links| compiled(chain(links)))).collect()
}

/// A robot of `robots/` or `testdata/golden/`, or `chain_N` with N links.
///
/// # Errors
/// [`RobotError`] if the robot does not exist, or its file is invalid.
pub fn robot_by_name(name: &str) -> Result<Model, RobotError> {
    if let Some(links) = name.strip_prefix("chain_") {
        return compiled(chain(links.parse().map_err(|cause| error(name, cause))?));
    }
    if DESCRIBED.contains(&name) {
        return described_robot(repository().join(format!("testdata/golden/{name}.json")));
    }
    let floating = URDF.iter().any(|&(known, floating)| known == name && floating);
    let options = LoadOptions { floating_base: floating, ..LoadOptions::default() };
    let robot = robot_dynamics::urdf::load(repository().join(format!("robots/{name}.urdf")), &options);
    compiled(robot.map_err(|cause| error(name, cause))?.description)
}

/// The robot in the field `description` of a JSON file.
///
/// # Errors
/// [`RobotError`] if the file cannot be read or is invalid.
pub fn described_robot(path: impl AsRef<Path>) -> Result<Model, RobotError> {
    let path = path.as_ref();
    let refused = |cause: &dyn fmt::Display| error(path.display(), cause);
    let text = std::fs::read_to_string(path).map_err(|cause| refused(&cause))?;
    let mut record: Value = serde_json::from_str(&text).map_err(|cause| refused(&cause))?;
    let description = record.get_mut("description").map_or(Value::Null, Value::take);
    compiled(serde_json::from_value(description).map_err(|cause| refused(&cause))?)
}

/// The robot of a URDF file, with its root link free or not.
///
/// # Errors
/// [`RobotError`] if the file cannot be read or is invalid.
pub fn robot_of_file(path: impl AsRef<Path>, floating_base: bool) -> Result<Model, RobotError> {
    let path = path.as_ref();
    let robot = robot_dynamics::urdf::load(path, &LoadOptions { floating_base, ..LoadOptions::default() });
    compiled(robot.map_err(|cause| error(path.display(), cause))?.description)
}

fn compiled(description: RobotDescription) -> Result<Model, RobotError> {
    let name = description.name.clone();
    Model::new(description).map_err(|cause| error(name, cause))
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("this package lies in the root").into()
}

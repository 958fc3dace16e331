//! Loading robots.

use std::ffi::c_char;

use robot_dynamics::{FileError, FileSet, LoadOptions, LoadedDescription};
use robot_dynamics::{load_description, load_description_from_files, load_description_from_text};

use crate::Status;
use crate::arrays::{Arrays, optional_text, options, result, text};
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::{insert, remove};
use crate::model::{ModelHandle, RobotModel};

/// Options of loading a robot. A structure filled with zeros selects the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct LoadOptionsC {
    /// Not 0: the base floats, which adds six degrees of freedom.
    pub floating_base: i32,
    /// Not 0: warnings are errors.
    pub strict: i32,
    /// Not 0: inertias that no rigid body has are repaired, and both values are reported.
    pub repair_inertia: i32,
    /// Not 0: other files must be in the folder of the robot's file.
    pub confined: i32,
    /// A folder that is searched for `package://NAME/…` before those of `ROS_PACKAGE_PATH`; or null.
    pub package_path: *const c_char,
    /// The path of the robot's SRDF file; or null.
    pub srdf: *const c_char,
}

impl Default for LoadOptionsC {
    fn default() -> Self {
        let none = std::ptr::null();
        Self { floating_base: 0, strict: 0, repair_inertia: 0, confined: 0, package_path: none, srdf: none }
    }
}

/// A file in memory.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FileC {
    /// The path by which other files name it.
    pub path: *const c_char,
    /// Its content.
    pub content: *const u8,
    /// The number of bytes.
    pub length: usize,
}

unsafe fn options_of(given: *const LoadOptionsC) -> Result<LoadOptions, Failure> {
    let given = options("the options", given)?;
    let mut options = LoadOptions {
        floating_base: given.floating_base != 0,
        strict: given.strict != 0,
        repair_inertia: given.repair_inertia != 0,
        confined: given.confined != 0,
        ..LoadOptions::default()
    };
    if let Some(folder) = optional_text("the package path", given.package_path)? {
        options = options.with_package_path(folder);
    }
    if let Some(path) = optional_text("the path of the SRDF file", given.srdf)? {
        options = options.with_srdf(path);
    }
    Ok(options)
}

fn store(described: Result<LoadedDescription, FileError>, model: &mut ModelHandle) -> Result<(), Failure> {
    let robot = described?.compile()?;
    model.id = insert(RobotModel::new(robot.model, &robot.report))?;
    Ok(())
}

/// Loads a robot from a URDF, MJCF, SDF, USD or scene file. `options` may be null. Suspicious values are
/// taken as written and reported: see `rd_model_report`. Free the model with `rd_model_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_load(
    path: *const c_char,
    options: *const LoadOptionsC,
    model: *mut ModelHandle,
) -> Status {
    call(|| {
        let model = result("the result `model`", model)?;
        store(load_description(text("the path", path)?, &options_of(options)?), model)
    })
}

/// Loads a robot from the text of its file. `options` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_load_text(
    content: *const c_char,
    options: *const LoadOptionsC,
    model: *mut ModelHandle,
) -> Status {
    call(|| {
        let model = result("the result `model`", model)?;
        store(load_description_from_text(text("the text", content)?, &options_of(options)?), model)
    })
}

/// Loads a robot from files in memory. `path` names the main file among them. `options` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_load_files(
    files: *const FileC,
    file_count: usize,
    path: *const c_char,
    options: *const LoadOptionsC,
    model: *mut ModelHandle,
) -> Status {
    call(|| {
        let model = result("the result `model`", model)?;
        let mut set = Vec::new();
        for file in Arrays::default().any("the files", files, file_count)? {
            let content = Arrays::default().any("the content of a file", file.content, file.length)?;
            set.push((text("the path of a file", file.path)?.to_owned(), content.to_vec()));
        }
        let path = text("the path", path)?;
        store(load_description_from_files(&FileSet::new(set), path, &options_of(options)?), model)
    })
}

/// Frees a model. Workspaces, simulations and other objects of it remain valid. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_free(model: ModelHandle) -> Status {
    call(|| remove::<RobotModel>(model.id))
}

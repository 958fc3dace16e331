//! Robots by handle and by value, and calls of the interface with slices.

// Each test program uses a part of this module.
#![allow(dead_code, unused_macros)]

use std::ffi::{CStr, CString, c_char};
use std::path::PathBuf;

use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, RandomState, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{Format, LoadOptions, load_description, load_description_from_text, write};
use robot_dynamics_c::Status;
use robot_dynamics_c::calls::rd_error_message;
use robot_dynamics_c::load::{LoadOptionsC, rd_load, rd_load_text, rd_model_free};
use robot_dynamics_c::model::ModelHandle;
use robot_dynamics_c::workspace::{WorkspaceHandle, rd_workspace_free, rd_workspace_new};

/// Calls a function. `in x` stands for the pointer and the length of an input, `mut x` for those of an
/// output.
#[allow(unused_macro_rules)]
macro_rules! rd {
    ($function:ident($($rest:tt)*)) => { rd!(@ $function [] $($rest)*) };
    (@ $function:ident [$($done:expr,)*]) => {{
        // SAFETY: each pointer has as many numbers as its length says.
        #[allow(unused_unsafe)]
        let status = unsafe { $function($($done),*) };
        status
    }};
    (@ $function:ident [$($done:expr,)*] in $x:expr $(, $($rest:tt)*)?) => {
        rd!(@ $function [$($done,)* $x.as_ptr(), $x.len(),] $($($rest)*)?)
    };
    (@ $function:ident [$($done:expr,)*] mut $x:expr $(, $($rest:tt)*)?) => {
        rd!(@ $function [$($done,)* $x.as_mut_ptr(), $x.len(),] $($($rest)*)?)
    };
    (@ $function:ident [$($done:expr,)*] $x:expr $(, $($rest:tt)*)?) => {
        rd!(@ $function [$($done,)* $x,] $($($rest)*)?)
    };
}

/// A file of the repository.
pub(crate) fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// A text for C.
pub(crate) fn c(text: &str) -> CString {
    CString::new(text).expect("a text without zero bytes")
}

/// A text of C.
pub(crate) fn text(pointer: *const c_char) -> String {
    assert!(!pointer.is_null(), "{}", message());
    // SAFETY: the texts of the interface end with a zero byte.
    unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned()
}

/// The text of the last error of this thread.
pub(crate) fn message() -> String {
    text(rd_error_message())
}

/// Requires success.
#[track_caller]
pub(crate) fn ok(status: Status) {
    assert_eq!(status, Status::Ok, "{}", message());
}

/// Requires this error, and its text to contain `part`.
#[track_caller]
pub(crate) fn fails(found: Status, status: Status, part: &str) {
    assert_eq!(found, status, "{}", message());
    assert!(message().contains(part), "`{part}` is not in: {}", message());
}

/// Requires equal bits.
#[track_caller]
pub(crate) fn same_bits(name: &str, found: &[f64], expected: &[f64]) {
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(found), bits(expected), "{name}: {found:?} instead of {expected:?}");
}

/// A robot by handle, with a workspace, and by value.
pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) handle: ModelHandle,
    pub(crate) workspace: WorkspaceHandle,
    pub(crate) model: Model,
}

impl Robot {
    /// A robot from a file of the repository.
    pub(crate) fn load(name: &str, floating: bool) -> Self {
        let path = file(name);
        let options = LoadOptions { floating_base: floating, ..LoadOptions::default() };
        let robot = load_description(&path, &options).expect("a file").compile().expect("a robot");
        let options = LoadOptionsC { floating_base: i32::from(floating), ..LoadOptionsC::default() };
        let (path, mut handle) = (c(path.to_str().expect("UTF-8")), ModelHandle { id: 0 });
        ok(rd!(rd_load(path.as_ptr(), &raw const options, &raw mut handle)));
        Self::new(name, handle, robot.model)
    }

    /// A random robot, through the text of its file.
    pub(crate) fn random(seed: u64, base: Base) -> Self {
        let options = RandomRobotOptions {
            kinds: JointKinds::Turning,
            joints: 6,
            base,
            ..RandomRobotOptions::default()
        };
        let content = write(&random_robot(seed, &options), Format::Mjcf, None).expect("a text").text;
        let mut robot = Self::from_text(&content);
        robot.name = format!("random robot {seed}");
        robot
    }

    /// A robot from the text of a file.
    pub(crate) fn from_text(content: &str) -> Self {
        let robot = load_description_from_text(content, &LoadOptions::default());
        let robot = robot.expect("a text").compile().expect("a robot");
        let (content, mut handle) = (c(content), ModelHandle { id: 0 });
        ok(rd!(rd_load_text(content.as_ptr(), std::ptr::null(), &raw mut handle)));
        Self::new(robot.model.name().to_owned().as_str(), handle, robot.model)
    }

    fn new(name: &str, handle: ModelHandle, model: Model) -> Self {
        let mut workspace = WorkspaceHandle { id: 0 };
        ok(rd!(rd_workspace_new(handle, &raw mut workspace)));
        Self { name: name.to_owned(), handle, workspace, model }
    }

    /// A state from a seed.
    pub(crate) fn state(&self, seed: u64) -> RandomState {
        random_state(&self.model, &mut SplitMix64::new(seed))
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        rd_workspace_free(self.workspace);
        rd_model_free(self.handle);
    }
}

/// An arm, a floating quadruped, a robot with loops, and random robots.
pub(crate) fn robots() -> Vec<Robot> {
    vec![
        Robot::load("robots/panda.urdf", false),
        Robot::load("robots/quadruped.urdf", true),
        Robot::load("robots/linkage.xml", false),
        Robot::random(3, Base::Fixed),
        Robot::random(4, Base::Floating),
    ]
}

//! Facts of a model: sizes, names, limits, masses.

use std::ffi::{CString, c_char};
use std::ptr::null;
use std::sync::Arc;

use robot_dynamics::description::{Limits, LoadReport};
use robot_dynamics::model::{FrameId, Model};

use crate::Status;
use crate::arrays::{Arrays, c_text, result, text};
use crate::calls::{call, query};
use crate::failure::Failure;
use crate::handle::{object, shared};

/// A robot: immutable, for any number of threads.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

/// A loaded model, with its names as texts of C.
pub(crate) struct RobotModel {
    pub(crate) model: Arc<Model>,
    pub(crate) frames: Vec<FrameId>,
    name: CString,
    report: CString,
    joint_names: Vec<CString>,
    coordinate_names: Vec<CString>,
    frame_names: Vec<CString>,
    pose_names: Vec<CString>,
    limits: Vec<Limits>,
}

object!(RobotModel, 1, "the model");

impl RobotModel {
    pub(crate) fn new(model: Model, report: &LoadReport) -> Self {
        let names = |names: &mut dyn Iterator<Item = &str>| names.map(c_text).collect::<Vec<_>>();
        Self {
            frames: model.frames().iter().filter_map(|frame| model.frame(&frame.name)).collect(),
            name: c_text(model.name()),
            report: c_text(&report.to_string()),
            joint_names: names(&mut model.joints().iter().map(|joint| joint.name.as_str())),
            coordinate_names: names(&mut model.coordinate_names().iter().map(String::as_str)),
            frame_names: names(&mut model.frames().iter().map(|frame| frame.name.as_str())),
            pose_names: names(&mut model.description().poses.iter().map(|pose| pose.name.as_str())),
            limits: model.coordinate_limits(),
            model: Arc::new(model),
        }
    }

    /// The frame of this number.
    pub(crate) fn frame(&self, frame: u32) -> Result<FrameId, Failure> {
        frame_of(&self.frames, &self.model, frame)
    }
}

/// The frame of a number among those of a model.
pub(crate) fn frame_of(frames: &[FrameId], model: &Model, frame: u32) -> Result<FrameId, Failure> {
    frames.get(frame as usize).copied().ok_or_else(|| {
        let (name, count) = (model.name(), frames.len());
        Failure::invalid(format!("there is no frame {frame}; robot `{name}` has the frames 0 to {count} - 1"))
    })
}

/// A size, or 0 for an invalid handle.
fn size(model: ModelHandle, of: impl FnOnce(&RobotModel) -> usize) -> usize {
    query(0, || Ok(of(&*shared::<RobotModel>(model.id)?)))
}

/// A name by its number.
fn name(model: ModelHandle, index: usize, of: impl FnOnce(&RobotModel) -> &[CString]) -> *const c_char {
    query(null(), || {
        let robot = shared::<RobotModel>(model.id)?;
        let names = of(&robot);
        let name = names.get(index);
        let count = names.len();
        Ok(name
            .ok_or_else(|| Failure::invalid(format!("there is no name {index}; there are {count}")))?
            .as_ptr())
    })
}

/// The number of coordinates of a configuration q; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_nq(model: ModelHandle) -> usize {
    size(model, |robot| robot.model.nq())
}

/// The number of degrees of freedom: the length of v, a and tau; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_nv(model: ModelHandle) -> usize {
    size(model, |robot| robot.model.nv())
}

/// The number of joints; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_joint_count(model: ModelHandle) -> usize {
    size(model, |robot| robot.joint_names.len())
}

/// The number of frames; 0 if the handle is invalid. Every link is a frame.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_frame_count(model: ModelHandle) -> usize {
    size(model, |robot| robot.frames.len())
}

/// The number of named poses in the robot's files; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_pose_count(model: ModelHandle) -> usize {
    size(model, |robot| robot.pose_names.len())
}

/// The robot's name; null if the handle is invalid. This and the other texts of a model are valid until it is
/// freed.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_name(model: ModelHandle) -> *const c_char {
    query(null(), || Ok(shared::<RobotModel>(model.id)?.name.as_ptr()))
}

/// The report of the loader: everything that was read, defaulted, suspicious or ignored, by line.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_report(model: ModelHandle) -> *const c_char {
    query(null(), || Ok(shared::<RobotModel>(model.id)?.report.as_ptr()))
}

/// The name of a joint by its number; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_joint_name(model: ModelHandle, joint: usize) -> *const c_char {
    name(model, joint, |robot| &robot.joint_names)
}

/// The name of a coordinate of v by its number; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_coordinate_name(model: ModelHandle, coordinate: usize) -> *const c_char {
    name(model, coordinate, |robot| &robot.coordinate_names)
}

/// The name of a frame by its number; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_frame_name(model: ModelHandle, frame: u32) -> *const c_char {
    name(model, frame as usize, |robot| &robot.frame_names)
}

/// The name of a pose by its number; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_pose_name(model: ModelHandle, pose: usize) -> *const c_char {
    name(model, pose, |robot| &robot.pose_names)
}

/// The number of the frame with this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_frame(model: ModelHandle, name: *const c_char, frame: *mut u32) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let found = robot.model.frame_named(text("the frame's name", name)?)?;
        let index = robot.frames.iter().position(|own| *own == found).unwrap_or_default();
        *result("the result `frame`", frame)? = index as u32;
        Ok(())
    })
}

/// The places of a joint's coordinates: the first index in q and in v, and their numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_joint_indices(
    model: ModelHandle,
    joint: usize,
    q_index: *mut usize,
    nq: *mut usize,
    v_index: *mut usize,
    nv: *mut usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let missing = || Failure::invalid(format!("there is no joint {joint}"));
        let joint = robot.model.joints().get(joint).ok_or_else(missing)?;
        let mut arrays = Arrays::default();
        let results = [
            (arrays.result("the result `q_index`", q_index)?, joint.q_index),
            (arrays.result("the result `nq`", nq)?, joint.nq),
            (arrays.result("the result `v_index`", v_index)?, joint.v_index),
            (arrays.result("the result `nv`", nv)?, joint.nv),
        ];
        for (result, number) in results {
            *result = number;
        }
        Ok(())
    })
}

/// Copies one number of the limits of each coordinate.
unsafe fn limit(model: ModelHandle, out: *mut f64, len: usize, of: impl Fn(&Limits) -> f64) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let out = Arrays::default().output("the result", out, len, robot.limits.len())?;
        out.iter_mut().zip(&robot.limits).for_each(|(out, limits)| *out = of(limits));
        Ok(())
    })
}

/// The lower position limit of each coordinate, nv numbers \[rad or m\]; −∞ without a limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_lower_limits(model: ModelHandle, out: *mut f64, len: usize) -> Status {
    limit(model, out, len, |limits| limits.lower)
}

/// The upper position limit of each coordinate, nv numbers \[rad or m\]; ∞ without a limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_upper_limits(model: ModelHandle, out: *mut f64, len: usize) -> Status {
    limit(model, out, len, |limits| limits.upper)
}

/// The velocity limit of each coordinate, nv numbers \[rad/s or m/s\]; ∞ without a limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_velocity_limits(model: ModelHandle, out: *mut f64, len: usize) -> Status {
    limit(model, out, len, |limits| limits.velocity)
}

/// The effort limit of each coordinate, nv numbers \[N m or N\]; ∞ without a limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_effort_limits(model: ModelHandle, out: *mut f64, len: usize) -> Status {
    limit(model, out, len, |limits| limits.effort)
}

/// The mass of the moving bodies \[kg\]; NaN if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_mass(model: ModelHandle) -> f64 {
    query(f64::NAN, || Ok(shared::<RobotModel>(model.id)?.model.mass()))
}

/// The gravitational acceleration in the world, three numbers \[m/s²\].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_model_gravity(model: ModelHandle, out: *mut f64, len: usize) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        Arrays::default().output("the result", out, len, 3)?.copy_from_slice(&robot.model.gravity());
        Ok(())
    })
}

/// A hash of the description: equal for two models if every name and every digit is; 0 if the handle is
/// invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_model_fingerprint(model: ModelHandle) -> u64 {
    query(0, || Ok(shared::<RobotModel>(model.id)?.model.fingerprint()))
}

//! The configuration space of a model.

use std::ffi::c_char;

use robot_dynamics::model::{self, check_configuration, check_vector};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{InputProblem, InvalidInput};

use crate::Status;
use crate::arrays::{Arrays, text};
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::shared;
use crate::model::{ModelHandle, RobotModel};

/// The neutral configuration, nq numbers: zeros, and identity quaternions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_neutral(model: ModelHandle, q: *mut f64, nq: usize) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let q = Arrays::default().output("q", q, nq, robot.model.nq())?;
        q.copy_from_slice(&model::neutral(&robot.model));
        Ok(())
    })
}

/// A random configuration within the limits, nq numbers; equal seeds give equal configurations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_random_configuration(
    model: ModelHandle,
    seed: u64,
    q: *mut f64,
    nq: usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let q = Arrays::default().output("q", q, nq, robot.model.nq())?;
        q.copy_from_slice(&model::random_within_limits(&robot.model, &mut SplitMix64::new(seed)));
        Ok(())
    })
}

/// The configuration and the velocity of a named pose of the robot's files.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_named_pose(
    model: ModelHandle,
    name: *const c_char,
    q: *mut f64,
    nq: usize,
    v: *mut f64,
    nv: usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let (model, name) = (&robot.model, text("the name of the pose", name)?);
        let mut arrays = Arrays::default();
        let q = arrays.output("q", q, nq, model.nq())?;
        let v = arrays.output("v", v, nv, model.nv())?;
        let Some((pose_q, pose_v)) = model.named_pose(name) else {
            let names = model.description().poses.iter().map(|pose| pose.name.as_str());
            return Err(
                InvalidInput::unknown_name("pose", name, format!("robot `{}`", model.name()), names).into()
            );
        };
        q.copy_from_slice(&pose_q);
        v.copy_from_slice(&pose_v);
        Ok(())
    })
}

/// moved = q ⊕ displacement: along a velocity for one second. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_integrate(
    model: ModelHandle,
    q: *const f64,
    nq: usize,
    displacement: *const f64,
    nv: usize,
    moved: *mut f64,
    moved_len: usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let (model, mut arrays) = (&*robot.model, Arrays::default());
        let q = arrays.input("q", q, nq, model.nq())?;
        let displacement = arrays.input("the displacement", displacement, nv, model.nv())?;
        let moved = arrays.output("the result", moved, moved_len, model.nq())?;
        check_configuration(model, q)?;
        check_vector(model, "the displacement", displacement)?;
        model::integrate(model, q, displacement, moved);
        Ok(())
    })
}

/// displacement = q1 ⊖ q0, so that q0 ⊕ displacement = q1. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_difference(
    model: ModelHandle,
    q0: *const f64,
    q0_len: usize,
    q1: *const f64,
    q1_len: usize,
    displacement: *mut f64,
    nv: usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let (model, mut arrays) = (&*robot.model, Arrays::default());
        let q0 = arrays.input("q0", q0, q0_len, model.nq())?;
        let q1 = arrays.input("q1", q1, q1_len, model.nq())?;
        let displacement = arrays.output("the result", displacement, nv, model.nv())?;
        check_configuration(model, q0).map_err(|error| error.of("q0"))?;
        check_configuration(model, q1).map_err(|error| error.of("q1"))?;
        model::difference(model, q0, q1, displacement);
        Ok(())
    })
}

/// The configuration between q0 (s = 0) and q1 (s = 1), along the shortest path. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_interpolate(
    model: ModelHandle,
    q0: *const f64,
    q0_len: usize,
    q1: *const f64,
    q1_len: usize,
    s: f64,
    between: *mut f64,
    nq: usize,
) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let (model, mut arrays) = (&*robot.model, Arrays::default());
        let q0 = arrays.input("q0", q0, q0_len, model.nq())?;
        let q1 = arrays.input("q1", q1, q1_len, model.nq())?;
        let between = arrays.output("the result", between, nq, model.nq())?;
        check_configuration(model, q0).map_err(|error| error.of("q0"))?;
        check_configuration(model, q1).map_err(|error| error.of("q1"))?;
        check_finite("s", s)?;
        model::interpolate(model, q0, q1, s, between);
        Ok(())
    })
}

/// Scales the quaternions in q to unit length, in place. A quaternion of zeros is an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_normalize(model: ModelHandle, q: *mut f64, nq: usize) -> Status {
    call(|| {
        let robot = shared::<RobotModel>(model.id)?;
        let q = Arrays::default().output("q", q, nq, robot.model.nq())?;
        model::normalize_quaternions(&robot.model, q);
        Ok(check_configuration(&robot.model, q)?)
    })
}

/// Refuses a number that is not finite.
pub(crate) fn check_finite(name: &str, value: f64) -> Result<(), Failure> {
    if value.is_finite() {
        return Ok(());
    }
    Err(InvalidInput::new(name, InputProblem::NotFinite { index: None, coordinate: None, value }).into())
}

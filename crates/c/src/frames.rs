//! Motions of frames.

use robot_dynamics::algorithms::{self, ReferenceFrame};

use crate::Status;
use crate::arrays::Arrays;
use crate::calls::call;
use crate::failure::{Failure, check_result};
use crate::handle::exclusive;
use crate::quantities::pose_numbers;
use crate::workspace::{RobotWorkspace, WorkspaceHandle};

/// The axes and the point of a frame's velocity, acceleration, Jacobian or wrench.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceFrameC {
    /// The world's axes, and the frame's origin.
    LocalWorldAligned = 0,
    /// The frame's own axes, and its origin.
    Local = 1,
    /// The world's axes, and the point of the body at the world's origin.
    World = 2,
}

/// The reference frame of this number.
pub(crate) fn reference_frame(number: u32) -> Result<ReferenceFrame, Failure> {
    match number {
        0 => Ok(ReferenceFrame::LocalWorldAligned),
        1 => Ok(ReferenceFrame::Local),
        2 => Ok(ReferenceFrame::World),
        _ => Err(Failure::invalid(format!("there is no reference frame {number}; there are 0, 1 and 2"))),
    }
}

/// The pose of a frame in the world, 12 numbers: the rotation by rows, then the translation \[m\]. Does not
/// allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_pose(
    workspace: WorkspaceHandle,
    frame: u32,
    q: *const f64,
    nq: usize,
    pose: *mut f64,
    pose_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let frame = robot.frame(frame)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let pose = arrays.output("the pose", pose, pose_len, 12)?;
        robot.check_q(q)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        pose_numbers(&algorithms::frame_pose(model, memory, q, frame), pose);
        check_result("the pose", &*pose)
    })
}

/// The velocity of a frame, linear then angular, 6 numbers \[m/s, rad/s\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_velocity(
    workspace: WorkspaceHandle,
    frame: u32,
    reference: u32,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    velocity: *mut f64,
    velocity_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let (frame, reference) = (robot.frame(frame)?, reference_frame(reference)?);
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let out = arrays.output("the velocity", velocity, velocity_len, 6)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        let twist = algorithms::frame_velocity(model, memory, q, v, frame, reference);
        store([twist.linear, twist.angular], out)
    })
}

/// The time derivative of `rd_frame_velocity`'s numbers, linear then angular, 6 numbers \[m/s², rad/s²\].
/// Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_acceleration(
    workspace: WorkspaceHandle,
    frame: u32,
    reference: u32,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    acceleration: *mut f64,
    acceleration_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let (frame, reference) = (robot.frame(frame)?, reference_frame(reference)?);
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let a = arrays.input("a", a, a_len, robot.model.nv())?;
        let out = arrays.output("the acceleration", acceleration, acceleration_len, 6)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        robot.check_v("a", a)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        let found = algorithms::frame_acceleration(model, memory, q, v, a, frame, reference);
        store([found.linear, found.angular], out)
    })
}

/// J with J v = `rd_frame_velocity`, 6 × nv, row-major: linear rows, then angular ones. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_jacobian(
    workspace: WorkspaceHandle,
    frame: u32,
    reference: u32,
    q: *const f64,
    nq: usize,
    jacobian: *mut f64,
    jacobian_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let (frame, reference) = (robot.frame(frame)?, reference_frame(reference)?);
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let out = arrays.output("the Jacobian", jacobian, jacobian_len, 6 * robot.model.nv())?;
        robot.check_q(q)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        algorithms::frame_jacobian(model, memory, q, frame, reference, out);
        check_result("the Jacobian", &*out)
    })
}

/// J̇ v, the acceleration of a frame at a = 0, 6 numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_bias_acceleration(
    workspace: WorkspaceHandle,
    frame: u32,
    reference: u32,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    acceleration: *mut f64,
    acceleration_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let (frame, reference) = (robot.frame(frame)?, reference_frame(reference)?);
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let out = arrays.output("the acceleration", acceleration, acceleration_len, 6)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        let found = algorithms::frame_bias_acceleration(model, memory, q, v, frame, reference);
        store([found.linear, found.angular], out)
    })
}

/// The velocity of the centre of mass, 3 numbers \[m/s\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_center_of_mass_velocity(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    velocity: *mut f64,
    velocity_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let out = arrays.output("the velocity", velocity, velocity_len, 3)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        out.copy_from_slice(&algorithms::center_of_mass_velocity(model, memory, q, v));
        check_result("the velocity of the centre of mass", &*out)
    })
}

/// The wrench that each joint transmits to its child link, 6 numbers for each joint, without contacts:
/// force \[N\] and moment \[N m\], in the axes and about the origin of the child link. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_joint_reactions(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    reactions: *mut f64,
    reactions_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let a = arrays.input("a", a, a_len, robot.model.nv())?;
        let joints = robot.model.joints().len();
        let out = arrays.output("the reactions", reactions, reactions_len, 6 * joints)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        robot.check_v("a", a)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        algorithms::joint_reactions(model, memory, q, v, a, &[], out);
        check_result("the reactions", &*out)
    })
}

/// Y with tau = Y p, nv × 10 links, row-major; p are the inertial parameters of `rd_inertial_parameters`.
/// Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_joint_torque_regressor(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    regressor: *mut f64,
    regressor_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, robot.model.nv())?;
        let a = arrays.input("a", a, a_len, robot.model.nv())?;
        let entries = robot.model.nv() * parameter_count(&robot);
        let out = arrays.output("the regressor", regressor, regressor_len, entries)?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        robot.check_v("a", a)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        algorithms::joint_torque_regressor(model, memory, q, v, a, out);
        check_result("the regressor", &*out)
    })
}

/// The inertial parameters of the moving links, ten for each: the mass \[kg\], the first moment (3) \[kg m\],
/// and xx, xy, yy, xz, yz, zz of the inertia about the link's origin \[kg m²\].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_inertial_parameters(
    workspace: WorkspaceHandle,
    parameters: *mut f64,
    parameters_len: usize,
) -> Status {
    call(|| {
        let robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let found = algorithms::inertial_parameters(&robot.model);
        let out = Arrays::default().output("the parameters", parameters, parameters_len, found.len())?;
        out.copy_from_slice(&found);
        Ok(())
    })
}

/// The number of inertial parameters of the moving links; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_inertial_parameter_count(workspace: WorkspaceHandle) -> usize {
    crate::calls::query(0, || Ok(parameter_count(&*exclusive::<RobotWorkspace>(workspace.id)?)))
}

fn parameter_count(robot: &RobotWorkspace) -> usize {
    algorithms::PARAMETERS_PER_LINK * robot.model.moving_links().count()
}

fn store([linear, angular]: [[f64; 3]; 2], out: &mut [f64]) -> Result<(), Failure> {
    out[..3].copy_from_slice(&linear);
    out[3..].copy_from_slice(&angular);
    check_result("the motion of the frame", &*out)
}

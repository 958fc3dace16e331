//! Closed loops and couplings of the robot's file, and supports at points.

use std::ffi::{CString, c_char};

use robot_dynamics::constraints::{
    ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis, constrained_forward_dynamics,
    project_position,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::FrameId;

use crate::Status;
use crate::arrays::{Arrays, c_text, result};
use crate::calls::{call, query};
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};
use crate::workspace::{RobotWorkspace, WorkspaceHandle};

/// Constraints of one model, for any number of threads.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConstraintsHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct Constraints {
    set: ConstraintSet,
    fingerprint: u64,
    names: Vec<CString>,
}

object!(Constraints, 4, "the constraints");

impl Constraints {
    fn new(robot: &RobotModel, set: ConstraintSet) -> Self {
        let names = set.row_names().iter().map(|name| c_text(name)).collect();
        Self { set, fingerprint: robot.model.fingerprint(), names }
    }

    /// The set, if it belongs to the model of a workspace.
    fn of(&self, robot: &RobotWorkspace) -> Result<&ConstraintSet, Failure> {
        if self.fingerprint == robot.model.fingerprint() {
            return Ok(&self.set);
        }
        Err(Failure::new(Status::InvalidHandle, "the constraints belong to another robot than the workspace"))
    }
}

/// The loops, couplings and other equalities of the robot's file. Free them with `rd_constraints_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_constraints_from_file(
    model: ModelHandle,
    constraints: *mut ConstraintsHandle,
) -> Status {
    call(|| {
        let constraints = result("the result `constraints`", constraints)?;
        let robot = shared::<RobotModel>(model.id)?;
        constraints.id = insert(Constraints::new(&robot, ConstraintSet::from_equalities(&robot.model)?))?;
        Ok(())
    })
}

/// Supports that hold the origins of frames where they are. `points` has 3 numbers for each frame, its
/// position in the world \[m\]. Free them with `rd_constraints_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_constraints_at_points(
    model: ModelHandle,
    frames: *const u32,
    frame_count: usize,
    points: *const f64,
    points_len: usize,
    constraints: *mut ConstraintsHandle,
) -> Status {
    supports::<3>(
        model,
        (frames, frame_count),
        ("the points", points, points_len),
        constraints,
        |frame, point| FrameConstraint::point_contact(frame, *point),
    )
}

/// Supports that hold the poses of frames. `poses` has 12 numbers for each frame, its pose in the world. Free
/// them with `rd_constraints_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_constraints_at_poses(
    model: ModelHandle,
    frames: *const u32,
    frame_count: usize,
    poses: *const f64,
    poses_len: usize,
    constraints: *mut ConstraintsHandle,
) -> Status {
    supports::<12>(
        model,
        (frames, frame_count),
        ("the poses", poses, poses_len),
        constraints,
        |frame, pose| FrameConstraint::contact(frame, pose_of(pose), &ALL_AXES),
    )
}

/// Makes constraints with the names of their frames, from N numbers for each frame.
unsafe fn supports<const N: usize>(
    model: ModelHandle,
    (frames, frame_count): (*const u32, usize),
    (name, numbers, numbers_len): (&str, *const f64, usize),
    constraints: *mut ConstraintsHandle,
    constraint: impl Fn(FrameId, &[f64; N]) -> FrameConstraint,
) -> Status {
    call(|| {
        let constraints = result("the result `constraints`", constraints)?;
        let robot = shared::<RobotModel>(model.id)?;
        let mut arrays = Arrays::default();
        let frames = arrays.any("the frames", frames, frame_count)?;
        let numbers = arrays.input(name, numbers, numbers_len, frame_count.saturating_mul(N))?;
        let mut set = Vec::new();
        for (frame, numbers) in frames.iter().zip(numbers.as_chunks::<N>().0) {
            let id = robot.frame(*frame)?;
            set.push((robot.model.frame_of(id).name.clone(), constraint(id, numbers).into()));
        }
        constraints.id = insert(Constraints::new(&robot, ConstraintSet::new(&robot.model, set)?))?;
        Ok(())
    })
}

const ALL_AXES: [SpatialAxis; 6] = {
    use SpatialAxis::{Rx, Ry, Rz, X, Y, Z};
    [X, Y, Z, Rx, Ry, Rz]
};

/// The pose of twelve numbers: the rotation by rows, then the translation.
pub(crate) fn pose_of(numbers: &[f64]) -> Pose {
    let rotation = std::array::from_fn(|i| std::array::from_fn(|j| numbers[3 * i + j]));
    Pose { rotation, translation: std::array::from_fn(|i| numbers[9 + i]) }
}

/// Frees constraints. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_constraints_free(constraints: ConstraintsHandle) -> Status {
    call(|| remove::<Constraints>(constraints.id))
}

/// The number of rows; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_constraints_row_count(constraints: ConstraintsHandle) -> usize {
    query(0, || Ok(shared::<Constraints>(constraints.id)?.names.len()))
}

/// The name of a row; null for any other number. It is valid until the constraints are freed.
#[unsafe(no_mangle)]
pub extern "C" fn rd_constraints_row_name(constraints: ConstraintsHandle, row: usize) -> *const c_char {
    query(std::ptr::null(), || {
        let constraints = shared::<Constraints>(constraints.id)?;
        let missing =
            || Failure::invalid(format!("there is no row {row}; there are {}", constraints.names.len()));
        Ok(constraints.names.get(row).ok_or_else(missing)?.as_ptr())
    })
}

/// a and the multipliers lambda of M a + C v + g = tau + Aᵀ lambda with A a = −Ȧ v. Dependent rows are left
/// out. `multipliers` has one number for each row. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_constrained_forward_dynamics(
    workspace: WorkspaceHandle,
    constraints: ConstraintsHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *const f64,
    tau_len: usize,
    a: *mut f64,
    a_len: usize,
    multipliers: *mut f64,
    multipliers_len: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let constraints = shared::<Constraints>(constraints.id)?;
        let set = constraints.of(&robot)?;
        let (n, mut arrays) = (robot.model.nv(), Arrays::default());
        let q = arrays.input("q", q, nq, robot.model.nq())?;
        let v = arrays.input("v", v, nv, n)?;
        let tau = arrays.input("tau", tau, tau_len, n)?;
        let a = arrays.output("the acceleration", a, a_len, n)?;
        let multipliers = arrays.output("the multipliers", multipliers, multipliers_len, set.len())?;
        robot.check_q(q)?;
        robot.check_v("v", v)?;
        robot.check_v("tau", tau)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        let options = ConstraintOptions::of_files();
        let found = constrained_forward_dynamics(model, memory, set, &options, q, v, tau)?;
        a.copy_from_slice(found.acceleration.as_slice());
        multipliers.copy_from_slice(found.multipliers.as_slice());
        Ok(())
    })
}

/// Moves q, in place, to the nearest configuration that meets the constraints to a tolerance. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_project_position(
    workspace: WorkspaceHandle,
    constraints: ConstraintsHandle,
    tolerance: f64,
    q: *mut f64,
    nq: usize,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let constraints = shared::<Constraints>(constraints.id)?;
        let set = constraints.of(&robot)?;
        let q = Arrays::default().output("q", q, nq, robot.model.nq())?;
        robot.check_q(q)?;
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        project_position(model, memory, set, &ConstraintOptions::of_files(), tolerance, q)?;
        Ok(())
    })
}

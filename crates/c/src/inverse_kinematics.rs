//! Inverse kinematics of one frame.

use robot_dynamics::control::{
    FrameTarget, InverseKinematicsError, InverseKinematicsOptions, inverse_kinematics,
};

use crate::Status;
use crate::arrays::{Arrays, options};
use crate::calls::call;
use crate::constraints::pose_of;
use crate::failure::Failure;
use crate::handle::exclusive;
use crate::workspace::{RobotWorkspace, WorkspaceHandle};

/// Options of inverse kinematics. A structure filled with zeros selects the defaults.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct InverseKinematicsOptionsC {
    /// The allowed distance from the target \[m\]; 0 for the default, 1e-9.
    pub position_tolerance: f64,
    /// The allowed angle from the target \[rad\]; 0 for the default, 1e-9.
    pub angle_tolerance: f64,
    /// The most steps from each start; 0 for the default, 100.
    pub max_iterations: usize,
    /// The most random starts after the first; 0 for the default, 100.
    pub max_restarts: usize,
    /// Not 0: no random starts, so that the solution remains near the start.
    pub from_start_only: i32,
    /// The seed of the random starts.
    pub seed: u64,
}

/// The quality and the cost of a solution.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct InverseKinematicsReportC {
    /// The distance from the target \[m\].
    pub position_error: f64,
    /// The angle from the target \[rad\]; 0 if the orientation is free.
    pub angle_error: f64,
    /// The number of steps from all starts.
    pub iterations: usize,
    /// The number of random starts.
    pub restarts: usize,
}

impl InverseKinematicsOptionsC {
    fn options(&self) -> InverseKinematicsOptions {
        let mut options = InverseKinematicsOptions::default();
        let chosen = |given: f64, default: f64| if given == 0.0 { default } else { given };
        options.position_tolerance = chosen(self.position_tolerance, options.position_tolerance);
        options.angle_tolerance = chosen(self.angle_tolerance, options.angle_tolerance);
        if self.max_iterations > 0 {
            options.max_iterations = self.max_iterations;
        }
        if self.max_restarts > 0 {
            options.max_restarts = self.max_restarts;
        }
        if self.from_start_only != 0 {
            options.max_restarts = 0;
        }
        options.seed = self.seed;
        options
    }
}

/// Finds a configuration within the limits in which a frame reaches a target, near the start.
///
/// `target` has 12 numbers for a pose (the rotation by rows, then the translation), or 3 for a position.
/// `options` and `report` may be null. Without a solution the status is `RD_STATUS_NOT_CONVERGED`, and q is
/// the nearest configuration that was found. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_inverse_kinematics(
    workspace: WorkspaceHandle,
    frame: u32,
    target: *const f64,
    target_len: usize,
    start: *const f64,
    start_len: usize,
    options: *const InverseKinematicsOptionsC,
    q: *mut f64,
    nq: usize,
    report: *mut InverseKinematicsReportC,
) -> Status {
    call(|| {
        let mut robot = exclusive::<RobotWorkspace>(workspace.id)?;
        let frame = robot.frame(frame)?;
        let mut arrays = Arrays::default();
        let target = match arrays.any("the target", target, target_len)? {
            position @ [_, _, _] => FrameTarget::Position([position[0], position[1], position[2]]),
            pose if pose.len() == 12 => FrameTarget::Pose(pose_of(pose)),
            other => {
                let count = other.len();
                return Err(Failure::invalid(format!("the target has {count} numbers; it needs 3 or 12")));
            }
        };
        let start = arrays.input("the start", start, start_len, robot.model.nq())?;
        let q = arrays.output("q", q, nq, robot.model.nq())?;
        let report = arrays.optional_result("the report", report)?;
        let options = self::options("the options", options)?.options();
        let RobotWorkspace { model, memory, .. } = &mut *robot;
        let (solution, failure) = match inverse_kinematics(model, memory, frame, target, start, &options) {
            Ok(solution) => (solution, None),
            Err(error) => match &error {
                InverseKinematicsError::NoSolution { best, .. } => ((**best).clone(), Some(error)),
                _ => return Err(error.into()),
            },
        };
        q.copy_from_slice(&solution.q);
        if let Some(report) = report {
            *report = InverseKinematicsReportC {
                position_error: solution.position_error,
                angle_error: solution.angle_error,
                iterations: solution.iterations,
                restarts: solution.restarts,
            };
        }
        failure.map_or(Ok(()), |error| Err(error.into()))
    })
}

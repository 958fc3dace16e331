//! Control of a frame through its operational-space inertia.

use std::sync::{Arc, Mutex, PoisonError};

use robot_dynamics::algorithms::{SpatialAcceleration, Twist};
use robot_dynamics::control::{PoseReference, TaskControl, TaskGains, TaskReference};
use robot_dynamics::description::Pose;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Controller;

use crate::Status;
use crate::arrays::{Arrays, result};
use crate::calls::call;
use crate::constraints::pose_of;
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};

/// Control of the position or the pose of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaskControlHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

type Reference<T> = Box<dyn FnMut(f64) -> T + Send + Sync>;
type Law<T> = TaskControl<Arc<Model>, Reference<T>>;

enum FrameLaw {
    Position(Law<TaskReference>),
    Pose(Law<PoseReference>),
}

pub(crate) struct FrameControl {
    law: FrameLaw,
    target: Arc<Mutex<PoseReference>>,
    nq: usize,
    nv: usize,
}

object!(FrameControl, 8, "the task controller");

/// Makes a controller of a frame: of its position (`has_orientation` 0) or of its pose. The gains are kp
/// \[1/s²\], kd \[1/s\] and the damping of the null space \[1/s\]. `posture` has nq numbers, or is null; its
/// stiffness is in \[1/s²\]. The torque is within the effort limits of the robot. Free it with
/// `rd_task_control_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_task_control_new(
    model: ModelHandle,
    frame: u32,
    has_orientation: i32,
    stiffness: f64,
    damping: f64,
    null_damping: f64,
    posture: *const f64,
    posture_len: usize,
    posture_stiffness: f64,
    controller: *mut TaskControlHandle,
) -> Status {
    call(|| {
        let controller = result("the result `controller`", controller)?;
        let robot = shared::<RobotModel>(model.id)?;
        let (frame, model) = (robot.frame(frame)?, Arc::clone(&robot.model));
        let posture = Arrays::default().any("the posture", posture, posture_len)?;
        let gains = TaskGains { stiffness, damping, null_damping };
        let target = Arc::new(Mutex::new(PoseReference::at_rest(Pose::default())));
        let (nq, nv, own) = (model.nq(), model.nv(), Arc::clone(&target));
        let law = if has_orientation != 0 {
            let reference: Reference<PoseReference> =
                Box::new(move |_| *own.lock().unwrap_or_else(PoisonError::into_inner));
            let mut law: Law<PoseReference> = TaskControl::owning(model, frame, reference, gains)?;
            if !posture.is_empty() {
                law = law.with_posture(posture, posture_stiffness)?;
            }
            FrameLaw::Pose(law)
        } else {
            let reference: Reference<TaskReference> = Box::new(move |_| {
                let PoseReference { pose, velocity, acceleration } =
                    *own.lock().unwrap_or_else(PoisonError::into_inner);
                let (velocity, acceleration) = (velocity.linear, acceleration.linear);
                TaskReference { position: pose.translation, velocity, acceleration }
            });
            let mut law: Law<TaskReference> = TaskControl::owning(model, frame, reference, gains)?;
            if !posture.is_empty() {
                law = law.with_posture(posture, posture_stiffness)?;
            }
            FrameLaw::Position(law)
        };
        controller.id = insert(FrameControl { law, target, nq, nv })?;
        Ok(())
    })
}

/// Frees a controller. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_task_control_free(controller: TaskControlHandle) -> Status {
    call(|| remove::<FrameControl>(controller.id))
}

/// Sets the target: 12 numbers of a pose, or 3 of a position; its velocity and its acceleration along the
/// world's axes, 6 numbers each, or null at rest. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_task_control_set_target(
    controller: TaskControlHandle,
    target: *const f64,
    target_len: usize,
    velocity: *const f64,
    velocity_len: usize,
    acceleration: *const f64,
    acceleration_len: usize,
) -> Status {
    call(|| {
        let own = exclusive::<FrameControl>(controller.id)?;
        let mut arrays = Arrays::default();
        let numbers = arrays.any("the target", target, target_len)?;
        let pose = match (&own.law, numbers.len()) {
            (_, 12) => pose_of(numbers),
            (FrameLaw::Position(_), 3) => Pose::from_translation([numbers[0], numbers[1], numbers[2]]),
            (_, count) => {
                return Err(Failure::invalid(format!(
                    "the target has {count} numbers; a pose has 12, and a position without orientation 3"
                )));
            }
        };
        let mut rates = [[[0.0; 3]; 2]; 2];
        for (to, (name, numbers, len)) in rates.iter_mut().zip([
            ("the velocity", velocity, velocity_len),
            ("the acceleration", acceleration, acceleration_len),
        ]) {
            if len == 0 {
                continue;
            }
            let x = arrays.input(name, numbers, len, 6)?;
            *to = [[x[0], x[1], x[2]], [x[3], x[4], x[5]]];
        }
        let [[linear, angular], [linear_rate, angular_rate]] = rates;
        let velocity = Twist { linear, angular };
        let acceleration = SpatialAcceleration { linear: linear_rate, angular: angular_rate };
        *own.target.lock().unwrap_or_else(PoisonError::into_inner) =
            PoseReference { pose, velocity, acceleration };
        Ok(())
    })
}

/// The torque at a state, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_task_control_torque(
    controller: TaskControlHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *mut f64,
    tau_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<FrameControl>(controller.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, own.nq)?;
        let v = arrays.input("v", v, nv, own.nv)?;
        let tau = arrays.output("tau", tau, tau_len, own.nv)?;
        match &mut own.law {
            FrameLaw::Position(law) => law.torque(0.0, q, v, tau)?,
            FrameLaw::Pose(law) => law.torque(0.0, q, v, tau)?,
        }
        Ok(())
    })
}

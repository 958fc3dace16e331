//! Inverse kinematics with several tasks against central differences, the optimality conditions, forward
//! kinematics and closed forms.

mod jacobians;
mod limits;
mod solutions;
mod steps;

use robot_dynamics::LoadOptions;
use robot_dynamics::control::task_kinematics::{KinematicObjective, KinematicTask, TaskKinematics};
use robot_dynamics::description::{Base, JointKinds, Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{FrameId, Model, integrate, random_within_limits};
use robot_dynamics::number::SplitMix64;

const FILES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/");

/// A robot of the folder `robots`.
fn load(file: &str, base: Base) -> Model {
    let mut robot = robot_dynamics::load_description(format!("{FILES}{file}"), &LoadOptions::default())
        .expect("a robot")
        .description;
    robot.base = base;
    Model::new(robot).expect("a valid robot")
}

/// An arm of seven hinges.
fn arm(seed: u64) -> Model {
    let options =
        RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    Model::new(random_robot(seed, &options)).expect("a valid robot")
}

/// The last frame of a robot.
fn last_frame(model: &Model) -> FrameId {
    model.frame_named(&model.frames()[model.frames().len() - 1].name).expect("a frame")
}

/// q moved by random displacements up to `size`.
fn moved(model: &Model, q: &[f64], size: f64, random: &mut SplitMix64) -> Vec<f64> {
    let step: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-size, size)).collect();
    let mut to = q.to_vec();
    integrate(model, q, &step, &mut to);
    to
}

/// A pose from random numbers up to one.
fn random_pose(random: &mut SplitMix64) -> Pose {
    let mut three = || core::array::from_fn(|_| random.uniform(-1.0, 1.0));
    Pose::from_xyz_rpy(three(), three())
}

/// One task with an objective.
fn with_objective(model: &Model, objective: KinematicObjective) -> TaskKinematics<&Model> {
    let mut kinematics = TaskKinematics::new(model);
    kinematics.add_task(KinematicTask::new(objective)).expect("a valid task");
    kinematics
}

/// A random configuration within the limits.
fn random_q(model: &Model, random: &mut SplitMix64) -> Vec<f64> {
    random_within_limits(model, random)
}

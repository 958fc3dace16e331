//! Inverse kinematics of arms: random reachable poses, from the middle of the limits, by the search for one
//! frame and by that for tasks, and differential steps. Prints how many were reached within the limits, and
//! times in microseconds.
//!
//! `cargo run --release -p bench --bin measure_inverse_kinematics [-- POSES]`

use std::error::Error;
use std::time::Instant;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::control::task_kinematics::{KinematicObjective, KinematicTask, TaskKinematics};
use robot_dynamics::control::{InverseKinematicsOptions, inverse_kinematics};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{FrameId, Model, Workspace, random_within_limits};
use robot_dynamics::nalgebra::Matrix3;
use robot_dynamics::number::SplitMix64;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/");

/// The steps of the differential measurement.
const STEPS: usize = 2000;

/// The step of control \[s\].
const DT: f64 = 0.005;

/// The offsets along z \[m\] and the limits \[°\] of an arm like the KUKA LBR iiwa 14 R820. Its data sheet
/// gives 360, 420, 400 and 126 mm between base, shoulder, elbow, wrist and flange.
const IIWA: [(f64, f64); 7] =
    [(0.0, 170.0), (0.36, 120.0), (0.0, 170.0), (0.42, 120.0), (0.0, 170.0), (0.4, 120.0), (0.126, 175.0)];

fn iiwa() -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("iiwa");
    robot.links.push(LinkDescription::new("base", None));
    for (i, (offset, limit)) in IIWA.into_iter().enumerate() {
        let (parent, child) =
            (robot.links[i].name.clone(), if i == 6 { "flange".to_owned() } else { format!("link{i}") });
        let mass = MassProperties::new(2.0, [0.0; 3].into(), Matrix3::identity() * 0.01)?;
        robot.links.push(LinkDescription::new(&child, Some(mass)));
        let axis = if i % 2 == 0 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let at = Pose::from_translation([0.0, 0.0, offset]);
        let mut joint =
            JointDescription::new(format!("joint{i}"), JointKind::Revolute { axis }, &parent, &child, at);
        (joint.limits.lower, joint.limits.upper) = (-f64::to_radians(limit), f64::to_radians(limit));
        robot.joints.push(joint);
    }
    Ok(Model::new(robot)?)
}

/// The middle of the limits.
fn middle(model: &Model) -> Vec<f64> {
    let mut q = robot_dynamics::model::neutral(model);
    for joint in model.joints().iter().filter(|joint| (joint.nq, joint.nv) == (1, 1)) {
        let (lower, upper) = (joint.limits.lower, joint.limits.upper);
        if lower.is_finite() && upper.is_finite() {
            q[joint.q_index] = 0.5 * (lower + upper);
        }
    }
    q
}

/// Reached poses, restarts, and times.
#[derive(Default)]
struct Record {
    reached: usize,
    restarts: usize,
    times: Vec<f64>,
}

impl Record {
    fn add(&mut self, start: Instant, restarts: Option<usize>) {
        self.times.push(1e6 * start.elapsed().as_secs_f64());
        if let Some(restarts) = restarts {
            self.reached += 1;
            self.restarts += restarts;
        }
    }

    fn print(&mut self, name: &str, way: &str) {
        self.times.sort_by(f64::total_cmp);
        let (count, at) = (self.times.len(), |share: usize| self.times[self.times.len() * share / 100]);
        println!(
            "{name:10} {way:10} reached {} of {count}, {:.2} restarts, median {:.1} µs, 99 % {:.1} µs, mean {:.1} µs",
            self.reached,
            self.restarts as f64 / count as f64,
            at(50),
            at(99),
            self.times.iter().sum::<f64>() / count as f64,
        );
    }
}

fn is_within(model: &Model, q: &[f64], frame: FrameId, target: &Pose, workspace: &mut Workspace) -> bool {
    let limits = model
        .joints()
        .iter()
        .filter(|joint| (joint.nq, joint.nv) == (1, 1))
        .all(|joint| (joint.limits.lower..=joint.limits.upper).contains(&q[joint.q_index]));
    let off = target.inverse().compose(&frame_pose(model, workspace, q, frame));
    let (linear, angular) = off.log();
    limits && linear.iter().chain(&angular).all(|x| x.abs() < 1e-8)
}

fn measure(name: &str, model: &Model, frame: FrameId, poses: usize) -> Result<(), Box<dyn Error>> {
    let (workspace, mut random) = (&mut Workspace::new(model), SplitMix64::new(7));
    let (start, options) = (middle(model), InverseKinematicsOptions::default());
    let mut kinematics = TaskKinematics::new(model);
    let task = kinematics.add_task(KinematicObjective::pose(frame, Pose::IDENTITY))?;
    let (mut one, mut several) = (Record::default(), Record::default());
    for _ in 0..poses {
        let target: Pose = frame_pose(model, workspace, &random_within_limits(model, &mut random), frame);
        let begin = Instant::now();
        let found = inverse_kinematics(model, workspace, frame, target, &start, &options).ok();
        let found = found.filter(|found| is_within(model, &found.q, frame, &target, workspace));
        one.add(begin, found.map(|found| found.restarts));
        *kinematics.objective_mut(task) = KinematicObjective::pose(frame, target);
        let begin = Instant::now();
        let found = kinematics.solve(&start, &options).ok();
        let found = found.filter(|found| is_within(model, &found.q, frame, &target, workspace));
        several.add(begin, found.map(|found| found.restarts));
    }
    one.print(name, "one frame");
    several.print(name, "tasks");
    follow(name, model, frame)
}

/// Differential steps towards random targets, with a posture and damping.
fn follow(name: &str, model: &Model, frame: FrameId) -> Result<(), Box<dyn Error>> {
    let (workspace, mut random) = (&mut Workspace::new(model), SplitMix64::new(9));
    let start = middle(model);
    let mut kinematics = TaskKinematics::new(model);
    let pose = KinematicTask::new(KinematicObjective::pose(frame, Pose::IDENTITY)).with_gain(0.5);
    let task = kinematics.add_task(pose)?;
    let posture = KinematicObjective::Posture { target: start.clone() };
    kinematics.add_task(KinematicTask::new(posture).with_weight(1e-4))?;
    let (mut q, mut v, mut times) = (start, vec![0.0; model.nv()], Vec::new());
    for index in 0..STEPS {
        if index % 100 == 0 {
            let target = frame_pose(model, workspace, &random_within_limits(model, &mut random), frame);
            *kinematics.objective_mut(task) = KinematicObjective::pose(frame, target);
        }
        let begin = Instant::now();
        let step = kinematics.step(&q, &v, DT)?;
        times.push(1e6 * begin.elapsed().as_secs_f64());
        q.clone_from(&step.q);
        v.clone_from(&step.velocity);
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{name:10} one step   median {:.2} µs, 99 % {:.2} µs",
        times[STEPS / 2],
        times[STEPS * 99 / 100]
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let poses = std::env::args().nth(1).map_or(Ok(10_000), |text| text.parse())?;
    let load =
        |file: &str| Ok::<Model, Box<dyn Error>>(robot_dynamics::load(format!("{ROBOTS}{file}"))?.model);
    let (panda, ur5, iiwa, humanoid) =
        (load("panda.urdf")?, load("ur5.urdf")?, iiwa()?, load("humanoid.urdf")?);
    measure("panda", &panda, panda.frame_named("panda_link8")?, poses)?;
    let tip = |model: &Model| model.frame_named(&model.frames()[model.frames().len() - 1].name);
    measure("ur5", &ur5, tip(&ur5)?, poses)?;
    measure("iiwa", &iiwa, iiwa.frame_named("flange")?, poses)?;
    let hand = humanoid.frames().iter().rev().find(|frame| frame.name.contains("hand"));
    let hand = hand.map_or_else(|| tip(&humanoid), |frame| humanoid.frame_named(&frame.name))?;
    measure("humanoid", &humanoid, hand, poses)
}

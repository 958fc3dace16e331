//! Sensors against functions that share no code with their evaluation, and against time differences of their
//! own values.
//!
//! Tolerances: 1e-12 of the largest terms for the same sums in another order. Central differences with
//! h = 1e-5 have 1e-7: their error is h² times a third derivative and 1e-16/h of rounding.

use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, center_of_mass, centroidal_momentum, frame_acceleration, frame_pose,
    joint_reactions, kinetic_energy, potential_energy,
};
use robot_dynamics::description::{ModelError, SensorDescription, SensorKind, SensorObject};
use robot_dynamics::model::{Model, Workspace, integrate};
use robot_dynamics::simulation::{PointForce, SensorInputs, SensorSet};

use crate::common::{Robot, families, max_difference, size};

const ROUNDING: f64 = 1e-12;
const DIFFERENCED: f64 = 1e-7;

fn robots(family: &str) -> Vec<Robot> {
    families().iter().find(|own| own.name == family).expect("a family").robots().take(15).collect()
}

/// The robot with these sensors.
fn with_sensors(mut robot: Robot, sensors: Vec<SensorDescription>) -> (Robot, SensorSet) {
    let mut description = robot.model.description().clone();
    description.sensors = sensors;
    robot.model = Model::new(description).expect("a robot with sensors");
    let set = SensorSet::new(&robot.model).expect("sensors");
    (robot, set)
}

fn values(model: &Model, set: &SensorSet, inputs: &SensorInputs<'_>) -> Vec<f64> {
    let mut values = vec![0.0; set.value_count()];
    set.evaluate(model, &mut set.memory(model), inputs, &mut values);
    values
}

fn turned_back(rotation: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|j| (0..3).map(|i| rotation[i][j] * x[i]).sum())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[test]
fn sensors_of_whole_robot_match_its_quantities() {
    use SensorKind::{
        KineticEnergy, PotentialEnergy, SubtreeAngularMomentum, SubtreeCenterOfMass, SubtreeLinearVelocity,
    };
    for robot in robots("floating trees") {
        let root = robot.model.joints()[0].child_link.clone();
        let kinds = [SubtreeCenterOfMass, SubtreeLinearVelocity, SubtreeAngularMomentum];
        let mut sensors: Vec<_> =
            kinds.iter().map(|&kind| SensorDescription::new(kind.name(), kind, root.as_str())).collect();
        for kind in [KineticEnergy, PotentialEnergy] {
            sensors.push(SensorDescription::new(kind.name(), kind, SensorObject::Robot));
        }
        let (robot, set) = with_sensors(robot, sensors);
        let (model, state, w) = (&robot.model, &robot.state, &mut Workspace::new(&robot.model));
        let found = values(model, &set, &SensorInputs::new(&state.q, &state.v, &state.a));
        let momentum = centroidal_momentum(model, w, &state.q, &state.v);
        let mut expected = center_of_mass(model, w, &state.q).to_vec();
        expected.extend(momentum.linear.iter().map(|p| p / model.mass()));
        expected.extend(momentum.angular);
        expected.push(kinetic_energy(model, w, &state.q, &state.v));
        expected.push(potential_energy(model, w, &state.q));
        let allowed = ROUNDING * size(&expected).max(1.0) * model.joints().len() as f64;
        robot.require("sensors of the whole robot", max_difference(&found, &expected), allowed);
    }
}

#[test]
fn accelerometers_forces_and_torques_match_frame_functions() {
    for robot in robots("mimic joints").into_iter().chain(robots("trees of all joints")) {
        let frames: Vec<String> =
            robot.model.frames().iter().skip(1).step_by(2).map(|frame| frame.name.clone()).collect();
        let kinds = [SensorKind::Accelerometer, SensorKind::Force, SensorKind::Torque];
        let sensors = frames.iter().flat_map(|frame| {
            kinds.map(|kind| SensorDescription::new(format!("{}_{frame}", kind.name()), kind, frame.as_str()))
        });
        let (robot, set) = with_sensors_of(&robot, sensors.collect());
        let (model, w) = (&robot.model, &mut Workspace::new(&robot.model));
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        // The same wrenches in the axes of the frames and in world axes.
        let wrenches = robot.wrenches();
        let mut in_world = Vec::new();
        for &FrameWrench { frame, force_in_frame, moment_in_frame } in &wrenches {
            let pose = frame_pose(model, w, q, frame);
            let turn = |x: [f64; 3]| pose.rotation.map(|row| (0..3).map(|j| row[j] * x[j]).sum());
            let mut wrench = PointForce::new(frame, pose.translation, turn(force_in_frame));
            wrench.moment = turn(moment_in_frame);
            in_world.push(wrench);
        }
        let mut inputs = SensorInputs::new(q, v, a);
        inputs.wrenches = &in_world;
        let found = values(model, &set, &inputs);
        let mut reactions = vec![0.0; 6 * model.joints().len()];
        joint_reactions(model, w, q, v, a, &wrenches, &mut reactions);
        for (at, name) in frames.iter().enumerate() {
            let frame = model.frame(name).expect("its frame");
            let pose = frame_pose(model, w, q, frame);
            let mut rate =
                frame_acceleration(model, w, q, v, a, frame, ReferenceFrame::LocalWorldAligned).linear;
            for (rate, gravity) in rate.iter_mut().zip(model.gravity()) {
                *rate -= gravity;
            }
            let own = model.description().frames.iter().find(|own| own.name == *name);
            let link = own.map_or(name, |own| &own.link);
            let Some(joint) = model.joints().iter().position(|joint| joint.child_link == *link) else {
                continue;
            };
            // From the frame of the link to that of the sensor, through the world.
            let link = frame_pose(model, w, q, model.frame(link).expect("the link"));
            let in_world = |x: &[f64]| -> [f64; 3] {
                link.rotation.map(|row| row.iter().zip(x).map(|(row, x)| row * x).sum())
            };
            let force = in_world(&reactions[6 * joint..6 * joint + 3]);
            let moment = in_world(&reactions[6 * joint + 3..6 * joint + 6]);
            let arm = core::array::from_fn(|i| link.translation[i] - pose.translation[i]);
            let shifted = cross(arm, force);
            let moment = core::array::from_fn(|i| moment[i] + shifted[i]);
            let expected = [rate, force, moment].map(|x| turned_back(&pose.rotation, x)).concat();
            let allowed = ROUNDING * size(&expected).max(size(&reactions)) * 100.0;
            robot.require(name, max_difference(&found[9 * at..9 * at + 9], &expected), allowed);
        }
    }
}

/// Builds the robot again with these sensors, which refer to its links and joints.
fn with_sensors_of(robot: &Robot, sensors: Vec<SensorDescription>) -> (Robot, SensorSet) {
    let all = families();
    let family = all.iter().find(|own| own.name == robot.family).expect("its family");
    with_sensors(Robot::new(family.name, robot.seed, &family.options), sensors)
}

/// Differences of the values at q ⊕ ±h v are the values of the sensors of their rates.
#[test]
fn rates_are_time_differences() {
    use SensorKind::{
        FrameLinearVelocity, FramePosition, SubtreeCenterOfMass, SubtreeLinearVelocity, TendonPosition,
        TendonVelocity,
    };
    const STEP: f64 = 1e-5;
    for robot in robots("tendons with armature") {
        let frames = robot.model.frames();
        let (first, last) = (frames[1].name.clone(), frames[frames.len() - 1].name.clone());
        let tendon = robot.model.description().tendons[0].name.clone();
        let link = robot.model.description().links[1].name.clone();
        let pairs = [
            (FramePosition, FrameLinearVelocity, &last),
            (SubtreeCenterOfMass, SubtreeLinearVelocity, &link),
            (TendonPosition, TendonVelocity, &tendon),
        ];
        let mut sensors = Vec::new();
        for (position, velocity, object) in pairs {
            for kind in [position, velocity] {
                let sensor = SensorDescription::new(kind.name(), kind, object.as_str());
                let is_frame = position == FramePosition;
                sensors.push(if is_frame { sensor.relative_to(first.as_str()) } else { sensor });
            }
        }
        let (robot, set) = with_sensors(robot, sensors);
        let (model, state) = (&robot.model, &robot.state);
        let at = |h: f64| {
            let moved: Vec<f64> = state.v.iter().map(|v| h * v).collect();
            let mut q = vec![0.0; model.nq()];
            integrate(model, &state.q, &moved, &mut q);
            values(model, &set, &SensorInputs::new(&q, &state.v, &state.a))
        };
        let (before, now, after) = (at(-STEP), at(0.0), at(STEP));
        let speed = size(&state.v).max(1.0);
        for pair in 0..3 {
            let (from, to) = (set.range(2 * pair), set.range(2 * pair + 1));
            let rate: Vec<f64> = from.map(|i| (after[i] - before[i]) / (2.0 * STEP)).collect();
            // Positions of some metres turn at some radians a second.
            let allowed = DIFFERENCED * speed.powi(3) * (1.0 + size(&now));
            robot.require("a rate", max_difference(&rate, &now[to]), allowed);
        }
    }
}

/// A cutoff bounds each number except those of quaternions.
#[test]
fn cutoffs_bound_values() {
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    robot.sensors = vec![
        SensorDescription::new("load", SensorKind::Force, "rod").with_cutoff(1.5),
        SensorDescription::new("turn", SensorKind::FrameQuaternion, "rod").with_cutoff(0.1),
    ];
    let model = Model::new(robot).expect("a robot");
    let set = SensorSet::new(&model).expect("sensors");
    let found = values(&model, &set, &SensorInputs::new(&[0.4], &[0.0], &[0.0]));
    assert_eq!(size(&found[..3]), 1.5);
    assert!(
        (found[4] - 0.2_f64.sin()).abs() < 1e-15 && (found[6] - 0.2_f64.cos()).abs() < 1e-15,
        "{found:?}"
    );
}

#[test]
fn invalid_sensors_are_errors() {
    let refused = |sensor: SensorDescription| {
        let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
        robot.sensors.push(sensor);
        Model::new(robot).expect_err("an invalid sensor")
    };
    let gyro = |object: &str| SensorDescription::new("s", SensorKind::Gyro, object);
    let error = refused(gyro("nose"));
    assert!(matches!(&error, ModelError::UnknownName { name, .. } if name == "nose"), "{error}");
    let error = refused(gyro("tip").with_cutoff(-1.0));
    assert!(matches!(error, ModelError::BadNumber { quantity: "cutoff", value: -1.0, .. }), "{error}");
    for sensor in [
        gyro("tip").relative_to("rod"),
        SensorDescription::new("s", SensorKind::Gyro, SensorObject::Robot),
        SensorDescription::new("s", SensorKind::BallQuaternion, "hinge"),
        SensorDescription::new("s", SensorKind::Clock, "rod"),
        SensorDescription::new("s", SensorKind::InsideSite, "tip"),
    ] {
        let kind = sensor.kind.name();
        let error = refused(sensor);
        assert!(
            matches!(&error, ModelError::BadSensor { sensor, kind: named, .. } if sensor == "s" && *named == kind),
            "{error}"
        );
    }
}

/// A locked joint has no sensors of its own motion.
#[test]
fn sensors_of_locked_joint_are_removed() {
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    robot.sensors = vec![
        SensorDescription::new("encoder", SensorKind::JointPosition, "hinge"),
        SensorDescription::new("imu", SensorKind::Accelerometer, "tip"),
    ];
    robot.lock_joint("hinge", &[0.3]).expect("locked");
    assert_eq!(robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>(), ["imu"]);
    Model::new(robot).expect("a robot");
}

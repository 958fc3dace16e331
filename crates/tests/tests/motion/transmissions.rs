//! Transmissions between frames and along the axes of a joint's parent: lengths by differences, power, and
//! edits.

use robot_dynamics::description::{
    ActuatorDescription, FrameDescription, JointKind, Mount, Pose, RandomRobotOptions, RobotDescription,
    Scene, Transmission, random_robot,
};
use robot_dynamics::model::{Model, integrate, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Actuation;

/// The names of a link and of one that it carries, or of itself.
fn carried(robot: &RobotDescription, random: &mut SplitMix64) -> [String; 2] {
    let mut below = |count: usize| usize::try_from(random.next_u64() % count as u64).unwrap();
    let tip = robot.links[below(robot.links.len())].name.clone();
    let mut chain = vec![tip.clone()];
    while let Some(joint) = robot.joints.iter().find(|joint| joint.child == *chain.last().unwrap()) {
        chain.push(joint.parent.clone());
    }
    [chain[below(chain.len())].clone(), tip]
}

/// A random robot with motors between frames of its links and along the axes of joints' frames. In the pairs
/// of the first three motors the reference carries the frame.
fn with_transmissions(seed: u64) -> RobotDescription {
    let mut robot = random_robot(seed, &RandomRobotOptions::default());
    let mut random = SplitMix64::new(seed);
    let frame = |robot: &mut RobotDescription, random: &mut SplitMix64, link: &str| {
        let mut three = |size: f64| core::array::from_fn(|_| random.uniform(-size, size));
        let name = format!("point_{}", robot.frames.len());
        let pose = Pose::from_xyz_rpy(three(0.5), three(3.0));
        robot.frames.push(FrameDescription::new(name.clone(), link, pose));
        name
    };
    let mut transmissions = Vec::new();
    for _ in 0..3 {
        let [a, b] = carried(&robot, &mut random);
        let (reference, tip) = (frame(&mut robot, &mut random, &a), frame(&mut robot, &mut random, &b));
        let gear = [0.7, -0.4, 1.2, 0.0, 0.0, 0.0];
        transmissions.push(Transmission::RelativeFrame { frame: tip, reference, gear });
    }
    for rod_length in [0.1, 3.0, 9.0] {
        let [a, b] = carried(&robot, &mut random);
        let (slider, crank) = (frame(&mut robot, &mut random, &a), frame(&mut robot, &mut random, &b));
        transmissions.push(Transmission::SliderCrank { crank, slider, rod_length, gear: 1.7 });
    }
    let joints = robot.joints.iter();
    let turning = joints.filter(|joint| matches!(joint.kind, JointKind::Spherical | JointKind::Floating));
    for joint in turning {
        for moment_in_child in [false, true] {
            let gear = core::array::from_fn(|_| random.uniform(-1.0, 1.0));
            let joint = joint.name.clone();
            transmissions.push(Transmission::JointInParent { joint, gear, moment_in_child });
        }
    }
    for (k, transmission) in transmissions.into_iter().enumerate() {
        robot.actuators.push(ActuatorDescription::new(format!("motor_{k}"), transmission));
    }
    robot
}

fn lengths(model: &Model, actuation: &Actuation, state: (&[f64], &[f64])) -> [Vec<f64>; 2] {
    let count = actuation.control_count();
    let (mut lengths, mut rates) = (vec![0.0; count], vec![0.0; count]);
    actuation.actuator_lengths(model, &mut actuation.workspace(), state, &mut lengths, &mut rates);
    [lengths, rates]
}

/// ℓ̇ is the derivative of ℓ along a motion. The difference has the order 4, so its error is h⁴ = 1e-16 times
/// the fifth derivative, up to 1e6 near a dead center of a crank, and rounding over h, 1e-12.
#[test]
fn rates_are_derivatives_of_lengths() {
    for seed in 0..12 {
        let model = Model::new(with_transmissions(seed)).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed + 50));
        let [_, rates] = lengths(&model, &actuation, (&state.q, &state.v));
        let at = |h: f64| {
            let way: Vec<f64> = state.v.iter().map(|v| h * v).collect();
            let mut q = state.q.clone();
            integrate(&model, &state.q, &way, &mut q);
            let [lengths, _] = lengths(&model, &actuation, (&q, &state.v));
            lengths
        };
        let h = 1e-4;
        let [a, b, c, d] = [at(h), at(-h), at(2.0 * h), at(-2.0 * h)];
        for k in 0..6 {
            let expected = (8.0 * (a[k] - b[k]) - (c[k] - d[k])) / (12.0 * h);
            assert!((rates[k] - expected).abs() < 1e-9, "robot {seed}, motor {k}: {} {expected}", rates[k]);
        }
    }
}

/// The power of the torques, τᵀv, is f ℓ̇ of each motor.
#[test]
fn torques_have_the_power_of_the_forces() {
    for seed in 0..12 {
        let model = Model::new(with_transmissions(seed)).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let mut memory = actuation.workspace();
        let state = random_state(&model, &mut SplitMix64::new(seed + 70));
        let [_, rates] = lengths(&model, &actuation, (&state.q, &state.v));
        for (k, rate) in rates.iter().enumerate() {
            let mut u = vec![0.0; rates.len()];
            u[k] = 2.5;
            let mut tau = vec![0.0; model.nv()];
            actuation.actuator_torques(&model, &mut memory, &u, &state.q, &state.v, &mut tau);
            let power: f64 = tau.iter().zip(&state.v).map(|(tau, v)| tau * v).sum();
            assert!((power - 2.5 * rate).abs() < 1e-12 * (1.0 + power.abs()), "robot {seed}, motor {k}");
        }
    }
}

/// A servo of a ball joint turns the shorter way to a setpoint beyond half a turn.
#[test]
fn servos_of_rotations_take_the_nearest_setpoint() {
    let seed = (0..100).find(|&seed| {
        let robot = random_robot(seed, &RandomRobotOptions::default());
        robot.joints.iter().any(|joint| joint.kind == JointKind::Spherical)
    });
    let mut robot = random_robot(seed.unwrap(), &RandomRobotOptions::default());
    let joint = robot.joints.iter().find(|joint| joint.kind == JointKind::Spherical).unwrap().name.clone();
    let transmission = Transmission::Joint { joint, gear: [0.0, 0.0, 1.0, 0.0, 0.0, 0.0] };
    robot.actuators.push(ActuatorDescription::new("servo", transmission).servo(10.0, 1.0));
    let model = Model::new(robot).unwrap();
    let actuation = Actuation::new(&model).unwrap();
    let state = random_state(&model, &mut SplitMix64::new(1));
    let force = |u: f64| {
        let mut forces = [0.0];
        let memory = &mut actuation.workspace();
        actuation.actuator_forces(&model, memory, &[u], &state.q, &state.v, &mut forces);
        forces[0]
    };
    let [lengths, rates] = lengths(&model, &actuation, (&state.q, &state.v));
    let (length, rate) = (lengths[0], rates[0]);
    let turn = core::f64::consts::TAU;
    for away in [-3.0, -0.5, 0.1, 3.0] {
        let expected = 10.0 * away - rate;
        for turns in [-2.0, 0.0, 1.0] {
            assert!((force(length + away + turns * turn) - expected).abs() < 1e-12, "{away} {turns}");
        }
    }
}

/// Motors of removed frames are removed, and prefixes reach all names.
#[test]
fn edits_reach_the_frames_of_transmissions() {
    let robot = with_transmissions(3);
    let mut scene = Scene::new("two");
    for prefix in ["left_", "right_"] {
        scene.add(&robot, &Mount::at(Pose::IDENTITY).with_prefix(prefix)).unwrap();
    }
    assert_eq!(
        Model::new(scene.into_description()).unwrap().nv(),
        2 * Model::new(robot.clone()).unwrap().nv()
    );
    let joint = robot.joints.last().unwrap().name.clone();
    let mut smaller = robot.clone();
    let notes = smaller.remove_joint(&joint).unwrap();
    let removed = notes.iter().filter(|note| note.place.starts_with("actuator")).count();
    assert_eq!(smaller.actuators.len() + removed, robot.actuators.len());
    Model::new(smaller).unwrap();
}

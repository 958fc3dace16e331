//! Sensors and joint reactions of a simulation, at rest and in free fall.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription,
    SensorDescription, SensorKind, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{AppliedWrench, Simulation, SimulationBuilder};

/// A floating box of 6 kg with a fixed mast of 1 kg, which carries the sensors.
fn boxed() -> (Simulation, [f64; 7]) {
    let mut robot = RobotDescription::new("box");
    robot.links.push(LinkDescription::new("world", None));
    let body = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).expect("a mass");
    robot.links.push(LinkDescription::new("body", body));
    let mast = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 1e-3).expect("a mass");
    robot.links.push(LinkDescription::new("mast", mast));
    let joint = |name: &str, kind, parent: &str, child: &str, at| {
        JointDescription::new(name, kind, parent, child, at)
    };
    robot.joints.push(joint("free", JointKind::Floating, "world", "body", Pose::IDENTITY));
    let on_top = Pose::from_translation([0.0, 0.0, 0.25]);
    robot.joints.push(joint("mount", JointKind::Fixed, "body", "mast", on_top));
    let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    robot.shapes.push(LinkShape::new("body", ShapeRole::Collision, Pose::IDENTITY, shape));
    for (name, kind) in [("imu", SensorKind::Accelerometer), ("turn", SensorKind::Gyro)] {
        robot.sensors.push(SensorDescription::new(name, kind, "mast"));
    }
    let model = Model::new(robot).expect("a robot");
    let simulation = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build();
    (simulation.expect("a simulation"), [0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0])
}

fn sensor(simulation: &Simulation, name: &str) -> Vec<f64> {
    simulation.sensors().into_iter().find(|(own, _)| own == name).expect("a sensor").1
}

/// At rest an accelerometer measures +g, the mount carries the mast, and the floating joint transmits no
/// force.
#[test]
fn at_rest_mount_transmits_weight_of_mast() {
    let (mut simulation, q) = boxed();
    simulation.reset(&q, &[0.0; 6]).expect("a start");
    simulation.run_for(0.5).expect("steps");
    let imu = sensor(&simulation, "imu");
    assert!((imu[2] - 9.81).abs() < 1e-6 && imu[0].abs() < 1e-6, "{imu:?}");
    let [free, mount] = simulation.joint_reactions()[..] else { panic!("two joints") };
    // Tolerance: 1e-6 of the weight. The contact force is that at the end of the step, the acceleration is
    // the mean over the step.
    assert!(free.iter().all(|x| x.abs() < 1e-5), "{free:?}");
    assert!((mount[2] - 9.81).abs() < 1e-6, "{mount:?}");
    let up: f64 = simulation.contacts().iter().map(|contact| contact.force[2]).sum();
    assert!((up - 7.0 * 9.81).abs() < 1e-5, "{up}");
}

/// In free fall an accelerometer measures zero, and the gyroscope measures the spin.
#[test]
fn sensors_measure_no_force_in_free_fall() {
    let (mut simulation, mut q) = boxed();
    q[2] = 10.0;
    // The spin is about the axis of symmetry through the mast.
    simulation.reset(&q, &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]).expect("a start");
    simulation.run_for(0.1).expect("steps");
    let (imu, turn) = (sensor(&simulation, "imu"), sensor(&simulation, "turn"));
    assert!(imu.iter().all(|x| x.abs() < 1e-9), "{imu:?}");
    assert!((turn[2] - 2.0).abs() < 1e-9, "{turn:?}");
    assert!(simulation.joint_reactions().as_flattened().iter().all(|x| x.abs() < 1e-9));
}

/// The mount transmits a push on the mast, whichever axes the push is given in.
#[test]
fn mount_transmits_push() {
    let (mut simulation, mut q) = boxed();
    (q[2], q[5], q[6]) = (10.0, 0.6, 0.8); // turned about z
    let mast = simulation.model().frame_named("mast").expect("a link");
    let mut found = Vec::new();
    let turned = |x: f64, y: f64| {
        let (sin, cos) = (2.0 * 0.6 * 0.8, 0.8 * 0.8 - 0.6 * 0.6);
        [cos * x - sin * y, sin * x + cos * y, 0.0]
    };
    let (local, world) = ([3.0, -1.0, 0.0], turned(3.0, -1.0));
    let at_origin = Vector3::new(0.0, 0.0, 10.25).cross(&Vector3::from(world));
    for (axes, force, moment) in [
        (ReferenceFrame::Local, local, [0.0; 3]),
        (ReferenceFrame::LocalWorldAligned, world, [0.0; 3]),
        (ReferenceFrame::World, world, at_origin.into()),
    ] {
        simulation.reset(&q, &[0.0; 6]).expect("a start");
        simulation.set_wrenches(&[AppliedWrench { frame: mast, axes, force, moment }]);
        simulation.step().expect("a step");
        found.push((simulation.v().to_vec(), simulation.joint_reactions()[1]));
    }
    for other in &found[1..] {
        assert!(found[0].0.iter().zip(&other.0).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // The wrenches are held while the box falls by 5 µm and turns: 3.2 N on that arm are 1.6e-5 N m.
        assert!(found[0].1.iter().zip(&other.1).all(|(a, b)| (a - b).abs() < 2e-5), "{found:?}");
    }
    // F = 7 a for the whole, so the mount transmits 6/7 of the push, and more while the box turns.
    assert!(found[0].1[0] < -0.5 && found[0].0[0] > 0.0, "{found:?}");
}

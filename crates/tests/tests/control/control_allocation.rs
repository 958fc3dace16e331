//! Controls of actuators for given torques.

use std::error::Error;

use robot_dynamics::control::ControlAllocation;
use robot_dynamics::description::{
    ActuatorDescription, Base, IntegralAction, JointKinds, RandomRobotOptions, RobotDescription,
    TendonDescription, Transmission, random_robot,
};
use robot_dynamics::model::{Model, RandomState, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Actuation;

type Tested = Result<(), Box<dyn Error>>;

fn arm() -> (RobotDescription, Vec<String>) {
    let options = RandomRobotOptions {
        joints: 4,
        kinds: JointKinds::Turning,
        chain: 1.0,
        base: Base::Fixed,
        ..RandomRobotOptions::default()
    };
    let robot = random_robot(7, &options);
    let joints = robot.joints.iter().filter(|joint| joint.kind.nv() == 1);
    let joints = joints.map(|joint| joint.name.clone()).collect();
    (robot, joints)
}

/// Motors and servos with gears, a motor over a tendon, and two actuators on one joint.
fn driven_arm(limit: f64) -> Model {
    let (mut robot, joints) = arm();
    let mut push = |mut actuator: ActuatorDescription| {
        actuator.force_range = [-limit, 0.8 * limit];
        robot.actuators.push(actuator);
    };
    push(ActuatorDescription::new("motor", Transmission::joint(&joints[0], -50.0)));
    push(ActuatorDescription::new("servo", Transmission::joint(&joints[1], 3.0)).servo(20.0, 2.0));
    push(ActuatorDescription::new("strong", Transmission::joint(&joints[2], 2.0)));
    push(ActuatorDescription::new("weak", Transmission::joint(&joints[2], 1.0)));
    push(ActuatorDescription::new("cable", Transmission::Tendon { tendon: "both".to_owned(), gear: 4.0 }));
    let joints = vec![(joints[2].clone(), 0.5), (joints[3].clone(), -1.5)];
    robot.tendons.push(TendonDescription::new("both", joints));
    Model::new(robot).expect("a robot")
}

/// The actuators' own law returns τ for the controls, and redundant actuators share it with the least sum of
/// squares.
#[test]
fn controls_give_the_torque() -> Tested {
    let model = driven_arm(f64::INFINITY);
    let (actuation, mut allocation) = (Actuation::new(&model)?, ControlAllocation::new(&model)?);
    let mut random = SplitMix64::new(1);
    for _ in 0..50 {
        let RandomState { q, v, tau, .. } = random_state(&model, &mut random);
        let (mut controls, mut found, mut forces) = ([0.0; 5], [0.0; 4], [0.0; 5]);
        let residual = allocation.controls(&q, &v, &tau, &mut controls)?;
        let memory = &mut actuation.workspace();
        actuation.actuator_torques(&model, memory, &controls, &q, &v, &mut found);
        let size = tau.iter().fold(0.0, |most: f64, tau| most.max(tau.abs()));
        for k in 0..4 {
            assert!((found[k] - tau[k]).abs() < 1e-10 * size, "{found:?} {tau:?}");
        }
        assert!(residual < 1e-10 * size);
        // The sum of squares is least if it does not change along the null space (−1, 2) of (2, 1).
        actuation.actuator_forces(&model, memory, &controls, &q, &v, &mut forces);
        assert!((2.0 * forces[3] - forces[2]).abs() < 1e-6 * size, "{forces:?}");
    }
    Ok(())
}

/// With bounds on the forces, no change of one force within its bounds brings the torque nearer.
#[test]
fn bounded_controls_are_nearest() -> Tested {
    let model = driven_arm(1.0);
    let (actuation, mut allocation) = (Actuation::new(&model)?, ControlAllocation::new(&model)?);
    let mut random = SplitMix64::new(2);
    let mut at_bounds = 0;
    for _ in 0..50 {
        let RandomState { q, v, tau, .. } = random_state(&model, &mut random);
        let mut controls = [0.0; 5];
        let residual = allocation.controls(&q, &v, &tau, &mut controls)?;
        let memory = &mut actuation.workspace();
        let mut distance = |controls: &[f64]| {
            let (mut found, mut forces) = ([0.0; 4], [0.0; 5]);
            actuation.actuator_torques(&model, memory, controls, &q, &v, &mut found);
            actuation.actuator_forces(&model, memory, controls, &q, &v, &mut forces);
            let square: f64 = found.iter().zip(&tau).map(|(a, b)| (a - b) * (a - b)).sum();
            (square, found, forces)
        };
        let (least, found, forces) = distance(&controls);
        assert!(forces.iter().all(|force| *force >= -1.0 - 1e-9 && *force <= 0.8 + 1e-9), "{forces:?}");
        at_bounds += usize::from(residual > 1e-6);
        let worst = found.iter().zip(&tau).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!((worst - residual).abs() < 1e-9 * (1.0 + worst));
        for k in 0..5 {
            for by in [-1e-3, 1e-3] {
                let mut other = controls;
                other[k] += by;
                assert!(distance(&other).0 > least - 1e-9 * (1.0 + least));
            }
        }
    }
    assert!(at_bounds > 10, "{at_bounds}");
    Ok(())
}

/// Coordinates without an actuator count in the residual, and an actuator with states is refused by name.
#[test]
fn other_actuators_are_refused() -> Tested {
    let (mut robot, joints) = arm();
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint(&joints[1], 10.0)));
    let model = Model::new(robot.clone())?;
    let mut controls = [0.0];
    let residual = ControlAllocation::new(&model)?.controls(
        &[0.0; 4],
        &[0.0; 4],
        &[0.0, 5.0, -3.0, 0.0],
        &mut controls,
    )?;
    assert!((controls[0] - 0.5).abs() < 1e-12 && (residual - 3.0).abs() < 1e-12);
    robot.actuators[0].integral = Some(IntegralAction { gain: 1.0, limit: 1.0 });
    let error = ControlAllocation::new(&Model::new(robot)?).map(drop).unwrap_err().to_string();
    assert!(error.contains("`motor`"), "{error}");
    Ok(())
}

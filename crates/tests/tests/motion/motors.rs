//! Electric motors with gears and limits, and elastic joints: closed forms and energy balances.

use std::error::Error;

use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::control::ControlAllocation;
use robot_dynamics::description::{
    Derating, ElectricMotor, JointElasticity, JointKinds, MotorDrive, PassiveForces, RandomRobotOptions,
    RobotDescription, WindingTemperature, pendulum, random_robot,
};
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Integrator, Method, Simulation, SimulationBuilder};

type Tested = Result<(), Box<dyn Error>>;

const GEAR: f64 = 50.0;

/// A rod of 0.5 kg m² without gravity, and its motor.
fn driven_rod(motor: ElectricMotor) -> RobotDescription {
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0; 3];
    robot.add_motor("hinge", &MotorDrive::new(motor, GEAR, 4e-5)).expect("a hinge");
    robot
}

fn simulation(robot: RobotDescription, h: f64) -> Result<Simulation, Box<dyn Error>> {
    let model = Model::new(robot)?;
    Ok(SimulationBuilder::new(&model).dt(h).method(Method::Fixed(Integrator::RungeKutta4)).build()?)
}

/// At the current limit the rod accelerates evenly. From the speed at which the voltage is reached, it
/// approaches the speed without load exponentially.
#[test]
fn motor_follows_its_torque_speed_curve() -> Tested {
    let mut motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0); // K = 0.08 N m/A, R = 1.6 Ω
    motor.current_limit = 6.0;
    let mut simulation = simulation(driven_rod(motor), 1e-4)?;
    simulation.reset(&[0.0], &[0.0])?;
    simulation.set_controls(&[100.0]); // more than the motor has
    let (inertia, k, r) = (0.5 + GEAR * GEAR * 4e-5, 0.08, 1.6);
    let even = GEAR * k * 6.0 / inertia;
    let corner = (24.0 - r * 6.0) / (k * GEAR); // the joint's speed at which the voltage is reached
    let reached = corner / even;
    let (fastest, rate) = (24.0 / (k * GEAR), GEAR * GEAR * k * k / r / inertia);
    let mut tested = [0, 0];
    for _ in 0..40 {
        simulation.run_for(0.01)?;
        let t = simulation.time();
        let expected = if t < reached {
            tested[0] += 1;
            even * t
        } else {
            tested[1] += 1;
            fastest - (fastest - corner) * (-rate * (t - reached)).exp()
        };
        // The step at the corner has an error of its length squared.
        assert!((simulation.v()[0] - expected).abs() < 1e-6, "{t}: {} {expected}", simulation.v()[0]);
    }
    assert!(tested[0] > 3 && tested[1] > 10, "{tested:?}");
    Ok(())
}

/// A motor that pushes against a heavy rod heats its winding until the reduced current holds the temperature.
#[test]
fn hot_winding_reduces_the_current() -> Tested {
    let mut motor = ElectricMotor::new(1.5, 0.08);
    motor.current_limit = 5.0;
    motor.derating = Some(Derating { start: 80.0, end: 120.0 });
    let (resistance, capacity, coefficient) = (4.0, 0.5, 0.0);
    let (reference, ambient) = (20.0, 25.0);
    motor.winding = Some(WindingTemperature { resistance, capacity, coefficient, reference, ambient });
    let mut robot = driven_rod(motor);
    robot.joints[0].passive.armature = 1e9; // it stays at rest
    let mut simulation = simulation(robot, 1e-2)?;
    simulation.reset(&[0.0], &[0.0])?;
    simulation.set_controls(&[10.0]);
    simulation.run_for(60.0)?;
    let rise = simulation.activations()[1];
    let current = 5.0 * (120.0 - 25.0 - rise) / 40.0;
    assert!(rise > 56.0 && rise < 95.0, "{rise}");
    assert!((resistance * 1.5 * current * current - rise).abs() < 1e-6, "{rise} {current}");
    // Without derating the winding would be at R_th R i² = 150 K.
    assert!(resistance * 1.5 * 25.0 > rise + 50.0);
    Ok(())
}

/// A motor that stands still holds what its current allows, and the allocation says what is missing.
#[test]
fn allocation_respects_motors() -> Tested {
    let mut robot = pendulum(2.0, 0.5);
    let mut motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0);
    motor.current_limit = 2.0;
    robot.add_motor("hinge", &MotorDrive::new(motor, GEAR, 4e-5))?;
    let model = Model::new(robot)?;
    let mut allocation = ControlAllocation::new(&model)?;
    let mut controls = [0.0];
    let residual = allocation.controls(&[0.0], &[0.0], &[-9.81], &mut controls)?;
    assert!((residual - (9.81 - GEAR * 0.08 * 2.0)).abs() < 1e-9, "{residual}");
    // At 95 % of the speed without load, a twentieth of the stall torque is left.
    let fast = 0.95 * 300.0 / GEAR;
    let residual = allocation.controls(&[0.0], &[fast], &[100.0], &mut controls)?;
    assert!((residual - (100.0 - GEAR * 0.06)).abs() < 1e-9, "{residual}");
    let load = allocation.motor_loads().next().flatten().ok_or("a motor")?;
    assert!((load.voltage - 24.0).abs() < 1e-9 && (load.current - 0.75).abs() < 1e-9, "{load:?}");
    Ok(())
}

/// The frequency of a rotor and a rod on a spring is √(k/B + k/I); the momentum stays zero.
#[test]
fn elastic_joint_has_its_resonance() -> Tested {
    let (k, b, i) = (900.0, 0.1, 0.5);
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0; 3];
    robot.joints[0].passive.armature = b;
    robot.add_joint_elasticity("hinge", &JointElasticity::new(k, 0.0))?;
    let mut simulation = simulation(robot, 1e-4)?;
    let frequency = f64::sqrt(k / b + k / i);
    let (motor, spring) = (-0.01 * i / (b + i), 0.01); // the centre of mass at rest
    simulation.reset(&[motor, spring], &[0.0; 2])?;
    for _ in 0..50 {
        simulation.run_for(0.02)?;
        let phase = (frequency * simulation.time()).cos();
        let q = simulation.q();
        assert!((q[0] - motor * phase).abs() < 1e-9 && (q[1] - spring * phase).abs() < 1e-9, "{q:?}");
    }
    Ok(())
}

/// The equations of motion are those of Spong: B θ̈ = τ − k δ' with the torque of the spring, and the links
/// move as the rigid robot under that torque.
#[test]
fn links_move_by_the_springs() -> Tested {
    let options = RandomRobotOptions {
        joints: 4,
        kinds: JointKinds::Turning,
        chain: 1.0,
        massless: 0.0,
        ..RandomRobotOptions::default()
    };
    for seed in 0..8 {
        let mut rigid = random_robot(seed, &options);
        for joint in &mut rigid.joints {
            joint.passive = PassiveForces::default();
            joint.mimic = None;
        }
        let mut elastic = rigid.clone();
        let names: Vec<String> =
            rigid.joints.iter().filter(|j| j.kind.nv() == 1).map(|j| j.name.clone()).collect();
        let (k, d) = (3e3, 2.0);
        for name in &names {
            elastic.joints.iter_mut().find(|j| j.name == *name).ok_or("it")?.passive.armature = 0.3;
            elastic.add_joint_elasticity(name, &JointElasticity::new(k, d))?;
        }
        let (rigid, elastic) = (Model::new(rigid)?, Model::new(elastic)?);
        let n = names.len();
        assert_eq!((rigid.nv(), elastic.nv()), (n, 2 * n));
        let mut random = SplitMix64::new(seed);
        let RandomState { q, v, tau, .. } = random_state(&rigid, &mut random);
        let bent: Vec<f64> = (0..n).map(|_| random.uniform(-0.1, 0.1)).collect();
        let slip: Vec<f64> = (0..n).map(|_| random.uniform(-0.5, 0.5)).collect();
        let at = |of_motor: &dyn Fn(usize) -> f64, of_spring: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..2 * n).map(|k| if k % 2 == 0 { of_motor(k / 2) } else { of_spring(k / 2) }).collect()
        };
        // Link angles q with springs bent by δ: θ = q − δ.
        let state = at(&|k| q[k] - bent[k], &|k| bent[k]);
        let rate = at(&|k| v[k] - slip[k], &|k| slip[k]);
        let drive = at(&|k| tau[k], &|_| 0.0);
        let mut simulation = SimulationBuilder::new(&elastic)
            .dt(1e-7)
            .method(Method::Fixed(Integrator::RungeKutta4))
            .without(robot_dynamics::simulation::Effect::EffortLimits)
            .build()?;
        simulation.reset(&state, &rate)?;
        simulation.set_torques(&drive);
        simulation.step()?;
        let a: Vec<f64> = (0..2 * n).map(|k| (simulation.v()[k] - rate[k]) / 1e-7).collect();
        let spring: Vec<f64> = (0..n).map(|j| -k * bent[j] - d * slip[j]).collect();
        let link: Vec<f64> = (0..n).map(|j| a[2 * j] + a[2 * j + 1]).collect();
        let mut needed = vec![0.0; n];
        inverse_dynamics(&rigid, &mut Workspace::new(&rigid), &q, &v, &link, &mut needed);
        let size = spring.iter().chain(&tau).fold(0.0, |most: f64, x| most.max(x.abs()));
        for j in 0..n {
            assert!((needed[j] - spring[j]).abs() < 1e-4 * size, "{seed}: {needed:?} {spring:?}");
            assert!((0.3 * a[2 * j] - (tau[j] - spring[j])).abs() < 1e-4 * size, "{seed}");
        }
    }
    Ok(())
}

/// Within the backlash nothing couples the link to its motor; beyond it the spring does.
#[test]
fn backlash_is_a_dead_band() -> Tested {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive.armature = 0.1;
    let mut elasticity = JointElasticity::new(5e3, 20.0);
    elasticity.backlash = 0.02;
    let mut other = robot.clone();
    other.gravity = [0.0; 3];
    robot.add_joint_elasticity("hinge", &elasticity)?;
    elasticity.damping = 0.0;
    other.add_joint_elasticity("hinge", &elasticity)?;
    // Without gravity, a slow link crosses the band at constant speed.
    let model = Model::new(other)?;
    let mut free = SimulationBuilder::new(&model).dt(1e-3).build()?;
    free.reset(&[0.0, -0.009], &[0.0, 0.1])?;
    free.run_for(0.18)?;
    assert!((free.q()[1] - 0.009).abs() < 1e-9 && free.q()[0].abs() < 1e-12, "{:?}", free.q());
    // Under gravity the rod rests at the edge of the band, bent further by its weight over the stiffness.
    let model = Model::new(robot)?;
    let mut held = SimulationBuilder::new(&model).dt(1e-3).build()?;
    held.reset(&[0.0, 0.0], &[0.0, 0.0])?;
    for _ in 0..4000 {
        let torque = -400.0 * held.q()[0] - 60.0 * held.v()[0];
        held.set_torques(&[torque + model.gravity_forces(held.q())?[0], 0.0]);
        held.step()?;
    }
    let weight = model.gravity_forces(held.q())?[0];
    let bent = held.q()[1];
    assert!(
        (bent.abs() - 0.01 - weight.abs() / 5e3).abs() < 1e-6,
        "{bent} {weight} {:?} {:?}",
        held.q(),
        held.v()
    );
    Ok(())
}

/// Wrong drives are refused, and leave the robot as it was.
#[test]
fn wrong_drives_are_refused() -> Tested {
    let robot = pendulum(2.0, 0.5);
    let motor = ElectricMotor::new(1.0, 0.1);
    let mut changed = robot.clone();
    let refuse = |result: Result<(), String>, word: &str| {
        let message = result.unwrap_err();
        assert!(message.contains(word), "{message}");
    };
    let text = |error: robot_dynamics::description::ModelError| error.to_string();
    refuse(
        changed.add_motor("hing", &MotorDrive::new(motor, 1.0, 0.0)).map_err(text),
        "did you mean `hinge`",
    );
    refuse(changed.add_motor("hinge", &MotorDrive::new(motor, 0.0, 0.0)).map_err(text), "gear");
    let cold = ElectricMotor { current_limit: -1.0, ..motor };
    refuse(changed.add_motor("hinge", &MotorDrive::new(cold, 1.0, 0.0)).map_err(text), "current limit");
    let soft = JointElasticity::new(100.0, 0.0);
    refuse(changed.add_joint_elasticity("hinge", &soft).map(drop).map_err(text), "armature");
    assert_eq!(changed, robot);
    changed.add_motor("hinge", &MotorDrive::new(motor, 10.0, 1e-3))?;
    refuse(changed.add_motor("hinge", &MotorDrive::new(motor, 10.0, 1e-3)).map_err(text), "hinge_motor");
    changed.add_joint_elasticity("hinge", &soft)?;
    let again = serde_json::to_string(&changed)?;
    assert_eq!(serde_json::from_str::<RobotDescription>(&again)?, changed);
    Ok(())
}

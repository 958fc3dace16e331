//! States of controllers and motors: steps of all methods agree, and closed forms.

use robot_dynamics::description::{
    Activation, ActuatorDescription, BristleFriction, CurrentDynamics, ElectricMotor, IntegralAction,
    RobotDescription, Transmission, WindingTemperature, pendulum,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, Method, Simulation, SimulationBuilder};

/// A pendulum with a servo that has an integral, a rate limit, and a motor with all its states.
fn motorized() -> RobotDescription {
    let mut robot = pendulum(0.4, 0.5);
    let mut servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(8.0, 0.6);
    servo.integral = Some(IntegralAction { gain: 5.0, limit: 3.0 });
    servo.activation = Activation::RateLimit { rate: 0.7 };
    let mut motor = ElectricMotor::new(1.5, 0.6);
    motor.current = Some(CurrentDynamics { time_constant: 0.03, rate_limit: f64::INFINITY });
    motor.winding = Some(WindingTemperature {
        resistance: 3.0,
        capacity: 0.5,
        coefficient: 0.004,
        reference: 20.0,
        ambient: 25.0,
    });
    motor.friction = Some(BristleFriction {
        stiffness: 8.0,
        damping: 0.3,
        coulomb: 0.15,
        static_friction: 0.2,
        stribeck_velocity: 0.1,
    });
    servo.motor = Some(motor);
    robot.actuators.push(servo);
    robot
}

/// The end after 0.6 s: q, v, and the activations.
fn end(model: &Model, method: Method, h: f64) -> (Simulation, Vec<f64>) {
    let mut simulation = SimulationBuilder::new(model).dt(h).method(method).build().unwrap();
    simulation.reset(&[0.2], &[0.5]).unwrap();
    simulation.set_controls(&[0.9]);
    simulation.run_for(0.6).unwrap();
    let end = [simulation.q(), simulation.v(), simulation.activations()].concat();
    (simulation, end)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f64::max)
}

const RK4: Method = Method::Fixed(Integrator::RungeKutta4);

/// The friction has a second derivative with a jump where the velocity changes its sign, so the methods are
/// of their order only between such instants; the tolerances allow for that.
#[test]
fn methods_converge_to_one_motion() {
    let model = Model::new(motorized()).unwrap();
    let (simulation, reference) = end(&model, RK4, 5e-5);
    assert_eq!(reference.len(), 2 + 1 + 4);
    assert!(reference[3..].iter().all(|state| state.abs() > 1e-4), "{reference:?}");
    assert!((reference[2] - 0.7 * 0.6).abs() < 1e-12, "the setpoint moves at its largest rate");
    assert!(simulation.energy_account().imbalance().abs() < 1e-7);
    let (_, coarse) = end(&model, RK4, 2e-3);
    assert!(distance(&coarse, &reference) < 1e-6, "{coarse:?} {reference:?}");
    let implicit = [2e-3, 1e-3].map(|h| distance(&end(&model, Method::Implicit, h).1, &reference));
    assert!(implicit[1] < 1e-4 && implicit[1] < 0.4 * implicit[0], "{implicit:?}");
    let euler = [1e-3, 5e-4].map(|h| {
        let row = Method::Fixed(Integrator::SemiImplicitEuler);
        distance(&end(&model, row, h).1, &reference)
    });
    assert!(euler[1] < 3e-3 && euler[1] < 0.6 * euler[0], "{euler:?}");
}

/// A current that is faster than the steps makes the steps implicit. The current then is V/R at rest.
#[test]
fn fast_currents_need_implicit_steps() {
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0; 3];
    let mut coil = ActuatorDescription::new("coil", Transmission::joint("hinge", 1.0));
    let mut motor = ElectricMotor::new(2.0, 0.1);
    motor.current = Some(CurrentDynamics { time_constant: 1e-5, rate_limit: f64::INFINITY });
    (coil.motor, coil.at_terminals) = (Some(motor), true);
    coil.gain.constant = motor.constant / motor.resistance;
    robot.actuators.push(coil);
    let model = Model::new(robot).unwrap();
    let mut simulation = SimulationBuilder::new(&model).dt(1e-3).build().unwrap();
    assert_eq!(simulation.method(), Method::Implicit);
    assert!(simulation.reason().contains("current"), "{}", simulation.reason());
    simulation.set_controls(&[3.0]);
    simulation.run_for(1.0).unwrap();
    // I v̇ = K/R (V − K v) with I = 0.5 kg·m².
    let rate: f64 = 0.1 * 0.1 / 2.0 / 0.5;
    let expected = 30.0 * -(-rate).exp_m1();
    assert!((simulation.v()[0] - expected).abs() < 1e-5, "{} {expected}", simulation.v()[0]);
    let current = (3.0 - 0.1 * simulation.v()[0]) / 2.0;
    assert!((simulation.activations()[1] - current).abs() < 1e-5, "{:?}", simulation.activations());
}

/// A snapshot contains the states, and a reset clears them.
#[test]
fn states_are_part_of_a_snapshot() {
    let model = Model::new(motorized()).unwrap();
    let (mut simulation, _) = end(&model, RK4, 1e-3);
    let snapshot = simulation.snapshot();
    let mut ends = Vec::new();
    for _ in 0..2 {
        simulation.restore(&snapshot);
        simulation.run_for(0.05).unwrap();
        ends.push([simulation.q(), simulation.activations()].concat());
    }
    assert_eq!(ends[0], ends[1]);
    simulation.reset(&[0.0], &[0.0]).unwrap();
    assert_eq!(simulation.activations(), [0.0; 5]);
}

#[cfg(feature = "adaptive")]
#[test]
fn adaptive_steps_integrate_the_states() {
    let model = Model::new(motorized()).unwrap();
    let (_, reference) = end(&model, RK4, 5e-5);
    let options = robot_dynamics::simulation::AdaptiveOptions::default();
    let mut simulation = SimulationBuilder::new(&model).dt(1e-2).adaptive(options).build().unwrap();
    simulation.reset(&[0.2], &[0.5]).unwrap();
    simulation.set_controls(&[0.9]);
    simulation.run_for(0.6).unwrap();
    let end = [simulation.q(), simulation.v(), simulation.activations()].concat();
    assert!(distance(&end, &reference) < 1e-7, "{end:?} {reference:?}");
    // Single steps continue from the states of the step before.
    simulation.reset(&[0.2], &[0.5]).unwrap();
    simulation.set_controls(&[0.9]);
    for _ in 0..60 {
        simulation.step().unwrap();
    }
    let end = [simulation.q(), simulation.v(), simulation.activations()].concat();
    assert!(distance(&end, &reference) < 1e-7, "{end:?} {reference:?}");
}

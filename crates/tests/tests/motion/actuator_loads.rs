//! The forces of actuators that a stepper reports balance the change of momentum, and the weight at rest.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use robot_dynamics::description::{
    ActuatorDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose,
    RobotDescription, Transmission, pendulum,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, Method, RunOptions, SimulationBuilder, StepInfo};

const MASS: f64 = 2.0;
const GEAR: f64 = 3.0;
/// \[s\]
const DURATION: f64 = 0.5;

/// A mass on a slide without gravity, with a servo over a gear; the joint takes at most ±`range` from the
/// servo.
fn slider(range: f64) -> Model {
    let mut robot = RobotDescription::new("slider");
    robot.gravity = [0.0; 3];
    robot.links.push(LinkDescription::new("rail", None));
    let mass = MassProperties::solid_box(MASS / 0.008, Vector3::new(0.2, 0.2, 0.2)).unwrap();
    robot.links.push(LinkDescription::new("mass", mass));
    robot.joints.push(JointDescription::new(
        "slide",
        JointKind::Prismatic { axis: [1.0, 0.0, 0.0] },
        "rail",
        "mass",
        Pose::IDENTITY,
    ));
    robot.joints[0].actuator_force_range = [-range, range];
    robot
        .actuators
        .push(ActuatorDescription::new("servo", Transmission::joint("slide", GEAR)).servo(2.0, 0.2));
    Model::new(robot).unwrap()
}

/// Sums h τ and checks single steps: τ is the force times the gear, within the joint's range.
struct Impulse {
    h: f64,
    range: f64,
    sum: f64,
    largest: f64,
}

impl Impulse {
    const fn new(h: f64, range: f64) -> Self {
        Self { h, range, sum: 0.0, largest: 0.0 }
    }

    fn see(&mut self, info: &StepInfo<'_>) -> ControlFlow<()> {
        let ([force], [torque]) = (info.actuator_forces, info.actuator_torques) else {
            panic!("one actuator on one coordinate");
        };
        if self.range.is_infinite() {
            assert!((torque - GEAR * force).abs() < 1e-12, "{torque} {force}");
        }
        assert!(torque.abs() < self.range + 1e-12, "{torque}");
        self.sum += self.h * torque;
        self.largest = self.largest.max(torque.abs());
        ControlFlow::Continue(())
    }
}

/// |Σ h τ − m Δv| over half a second in `steps` steps of a method.
fn by_method(model: &Model, steps: usize, method: Method) -> f64 {
    let mut impulse = Impulse::new(DURATION / steps as f64, f64::INFINITY);
    let mut simulation = SimulationBuilder::new(model).method(method).dt(impulse.h).build().unwrap();
    simulation.set_controls(&[0.8]);
    let mut see = |info: &StepInfo<'_>| impulse.see(info);
    let run = simulation.run_steps(steps, RunOptions::new().observer(&mut see)).unwrap();
    assert!(run.v[0].abs() > 0.1 && impulse.largest > 1.0, "{} {}", run.v[0], impulse.largest);
    (impulse.sum - MASS * run.v[0]).abs()
}

fn by_explicit(model: &Model, steps: usize, range: f64) -> (f64, f64) {
    let mut impulse = Impulse::new(DURATION / steps as f64, range);
    let row = Method::Fixed(Integrator::RungeKutta4);
    let mut simulation = SimulationBuilder::new(model).dt(impulse.h).method(row).build().unwrap();
    simulation.set_controls(&[0.8]);
    let mut see = |info: &StepInfo<'_>| impulse.see(info);
    let run = simulation.run_steps(steps, RunOptions::new().observer(&mut see)).unwrap();
    ((impulse.sum - MASS * run.v[0]).abs(), impulse.largest)
}

/// MuJoCo's step holds the forces of its start, so that the sum is m Δv to rounding.
#[test]
fn mujoco_euler_impulses_are_momentum() {
    let model = slider(f64::INFINITY);
    // Steps of 5 ms.
    let off = by_method(&model, 100, Method::Mujoco);
    assert!(off < 1e-13, "{off:e}");
}

/// The mean over an implicit step is of order 2: half the step leaves a quarter.
#[test]
fn implicit_impulses_are_momentum_to_second_order() {
    let model = slider(f64::INFINITY);
    let off = |steps| by_method(&model, steps, Method::Implicit);
    let (coarse, fine) = (off(100), off(200));
    assert!(coarse < 1e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// Simpson's rule over steps of order 4: half the step leaves a sixteenth.
#[test]
fn explicit_impulses_are_momentum_to_fourth_order() {
    let model = slider(f64::INFINITY);
    let (coarse, _) = by_explicit(&model, 25, f64::INFINITY);
    let (fine, _) = by_explicit(&model, 50, f64::INFINITY);
    assert!(coarse < 1e-4 && (12.0..20.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// The range of a joint bounds its torque, not the force of the actuator.
#[test]
fn torques_stay_within_the_range_of_the_joint() {
    let (_, largest) = by_explicit(&slider(4.0), 100, 4.0);
    assert!((largest - 4.0).abs() < 1e-12, "{largest}");
}

/// At rest the servo of a pendulum carries its weight.
#[test]
fn at_rest_actuators_carry_the_weight() {
    let mut robot = pendulum(2.0, 0.5);
    robot
        .actuators
        .push(ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(500.0, 50.0));
    let model = Model::new(robot).unwrap();
    let mut last = 0.0;
    let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).dt(1e-2).build().unwrap();
    simulation.set_controls(&[1.0]);
    let mut observer = |info: &StepInfo<'_>| {
        last = info.actuator_torques[0];
        ControlFlow::Continue(())
    };
    let run = simulation.run_steps(2000, RunOptions::new().observer(&mut observer)).unwrap();
    let weight = model.gravity_forces(&run.q).unwrap()[0];
    assert!(weight.abs() > 1.0 && (last - weight).abs() < 1e-9 * weight.abs(), "{last} {weight}");
}

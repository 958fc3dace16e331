//! Compares actuators with states with MuJoCo (`testdata/mjcf/controller_states/golden.json`): torques, the
//! rates of the states, and the ends of motions by the same Runge–Kutta steps.
//!
//! Tolerance: 1e-10 of torques and rates, 1e-8 of motions, relative to the largest number or 1. They differ
//! by the rounding of sums in another order, and by MuJoCo's principal axes of inertia.

use robot_dynamics::description::{Activation, ActuatorDescription, RobotDescription};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Actuation, Effect, Integrator, Method, SimulationBuilder};
use robot_dynamics_mjcf::{LoadOptions, load, parse, write};
use serde_json::Value;

use crate::golden::{Golden, assert_ends, assert_near, numbers, root};

const FORCES: f64 = 1e-10;
const MOTIONS: f64 = 1e-8;

fn golden() -> Value {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/controller_states/golden.json"));
    serde_json::from_str(&text.expect("the golden file")).expect("JSON")
}

fn robot(file: &str) -> RobotDescription {
    let robot =
        load(root().join(file), &LoadOptions::default()).unwrap_or_else(|error| panic!("{file}: {error}"));
    assert_eq!(robot.report.counts.ignored_physics, 0, "{}", robot.report);
    robot.description
}

/// MuJoCo's controls in this robot's order: a motor without an input has no control in MuJoCo.
pub(crate) fn controls(robot: &RobotDescription, ctrl: &[f64]) -> Vec<f64> {
    let mut ctrl = ctrl.iter().copied();
    let mut next = |own: &ActuatorDescription| if is_passive(own) { Some(0.0) } else { ctrl.next() };
    robot.actuators.iter().map(|own| next(own).expect("a control")).collect()
}

pub(crate) fn is_passive(actuator: &ActuatorDescription) -> bool {
    actuator.control_range == [0.0; 2]
}

/// The activations for MuJoCo's `act`, which has a setpoint before the other states of its actuator. MuJoCo's
/// forces use the setpoint at the end of the step.
fn activations(robot: &RobotDescription, controls: &[f64], act: &[f64], step: f64) -> Vec<f64> {
    let (mut first, mut states, mut act) = (controls.to_vec(), Vec::new(), act.iter().copied());
    for (k, actuator) in robot.actuators.iter().enumerate() {
        if actuator.activation != Activation::None {
            let [lower, upper] = actuator.control_range;
            let start = act.next().expect("a setpoint");
            first[k] = actuator.activation.after(step, controls[k].max(lower).min(upper), start);
        }
        let count = state_count(actuator);
        states.extend(act.by_ref().take(count));
    }
    assert_eq!(act.next(), None);
    first.append(&mut states);
    first
}

pub(crate) fn state_count(actuator: &ActuatorDescription) -> usize {
    let motor = actuator.motor.map_or([false; 3], |motor| {
        [motor.winding.is_some(), motor.friction.is_some(), motor.current.is_some()]
    });
    usize::from(actuator.integral.is_some()) + motor.into_iter().filter(|is_there| *is_there).count()
}

#[test]
fn torques_are_mujocos() {
    for (file, record) in golden()["files"].as_object().expect("files") {
        let robot = robot(file);
        let model = Model::new(robot.clone()).expect("a robot");
        let actuation = Actuation::new(&model).expect("actuation");
        for state in record["states"].as_array().expect("states") {
            let (q, v) = Golden::state(&model, state);
            let controls = controls(&robot, &numbers(&state["ctrl"]));
            let u = activations(
                &robot,
                &controls,
                &numbers(&state["act"]),
                numbers(&record["motion"]["step"])[0],
            );
            assert_eq!(u.len(), actuation.activation_count());
            let mut tau = vec![0.0; model.nv()];
            actuation.actuator_torques(&model, &mut actuation.workspace(), &u, &q, &v, &mut tau);
            assert_near(file, &tau, &numbers(&state["actuator_torques"]), FORCES);
        }
    }
}

/// The change of the states in a short step, whose error is that of the explicit Euler method, h·2e4: the
/// fastest state, the friction of a fast joint, has a second derivative of that size.
#[test]
fn rates_of_states_are_mujocos() {
    const H: f64 = 1e-9;
    for (file, record) in golden()["files"].as_object().expect("files") {
        let robot = robot(file);
        let model = Model::new(robot.clone()).expect("a robot");
        let mut simulation = SimulationBuilder::new(&model)
            .dt(H)
            .method(Method::Fixed(Integrator::ExplicitEuler))
            .without(Effect::Contacts)
            .build()
            .expect("a simulation");
        for state in record["states"].as_array().expect("states") {
            let (q, v) = Golden::state(&model, state);
            let controls = controls(&robot, &numbers(&state["ctrl"]));
            let act = numbers(&state["act"]);
            let u = activations(&robot, &controls, &act, numbers(&record["motion"]["step"])[0]);
            simulation.reset(&q, &v).expect("a state");
            simulation.set_controls(&controls);
            simulation.set_activations(&u);
            simulation.step().expect("a step");
            let all = numbers(&state["rates"]);
            let (mut rates, mut own) = (Vec::new(), Vec::new());
            let (mut at, mut place) = (0, robot.actuators.len());
            let ends = simulation.activations();
            for actuator in &robot.actuators {
                at += usize::from(actuator.activation != Activation::None);
                for k in 0..state_count(actuator) {
                    // The end of a step returns an integral to its limit.
                    let is_inside = actuator.integral.is_none_or(|own| k > 0 || u[place].abs() < own.limit);
                    if is_inside {
                        rates.push(all[at]);
                        own.push((ends[place] - u[place]) / H);
                    }
                    (at, place) = (at + 1, place + 1);
                }
            }
            // The difference of two states of up to 3 has a rounding of 4e-16/H.
            assert_near(file, &own, &rates, 1e-5);
        }
    }
}

#[test]
fn motions_end_where_mujocos_do() {
    for (file, record) in golden()["files"].as_object().expect("files") {
        let robot = robot(file);
        let model = Model::new(robot.clone()).expect("a robot");
        let motion = &record["motion"];
        let (q, v) = Golden::state(&model, motion);
        let step = numbers(&motion["step"])[0];
        let mut simulation = SimulationBuilder::new(&model)
            .dt(step)
            .method(Method::Fixed(Integrator::RungeKutta4))
            .without(Effect::Contacts)
            .build()
            .expect("a simulation");
        simulation.reset(&q, &v).expect("a state");
        let controls = controls(&robot, &numbers(&motion["ctrl"]));
        simulation.set_controls(&controls);
        let states = numbers(&motion["end_act"]).len();
        simulation.set_activations(&activations(&robot, &controls, &vec![0.0; states], step));
        simulation.run_for(numbers(&motion["duration"])[0]).expect("a motion");
        assert_ends(file, &model, motion, (simulation.q(), simulation.v()), MOTIONS);
        let ends = activations(&robot, &controls, &numbers(&motion["end_act"]), step);
        assert_near(file, simulation.activations(), &ends, MOTIONS);
    }
}

/// A written file is read as the same actuators.
#[test]
fn controllers_are_written() {
    for file in golden()["files"].as_object().expect("files").keys() {
        let robot = robot(file);
        let written = write(&robot, None).expect("a file");
        let lost: Vec<_> = written.lost_physics().map(|lost| lost.message.clone()).collect();
        assert!(lost.is_empty(), "{file}: {lost:?}");
        let again = parse(&written.text, &LoadOptions::default()).expect("a robot").description;
        assert_eq!(robot.actuators, again.actuators, "{file}");
    }
}

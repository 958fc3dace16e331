//! Optimal control through actuators: gears, servos and tendons as controls of a step of a simulation.

use robot_dynamics::control::optimal::{
    DiscreteDynamics, Fddp, FddpOptions, LinearizedDynamics, Problem, SimulationStep,
};
use robot_dynamics::description::{
    Activation, ActuatorDescription, ElectricMotor, MotorDrive, RobotDescription, TendonDescription,
    Transmission,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, Method, SimulationBuilder};

use super::quadratic;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
const GEARS: [f64; 2] = [20.0, -8.0];
const NODES: usize = 30;

fn arm() -> RobotDescription {
    robot_dynamics::load(FILE).expect("an arm").model.description().clone()
}

fn geared() -> RobotDescription {
    let mut robot = arm();
    for (joint, gear) in ["shoulder", "elbow"].into_iter().zip(GEARS) {
        robot.actuators.push(ActuatorDescription::new(joint, Transmission::joint(joint, gear)));
    }
    robot
}

fn step_of(robot: RobotDescription, method: Method) -> SimulationStep {
    let model = Model::new(robot).expect("a robot");
    SimulationStep::new(&SimulationBuilder::new(&model).dt(0.01).method(method).build().expect("a method"))
}

/// The least cost of a reach with the weights r of the controls, and the controls of the first node.
fn reach(step: SimulationStep, r: [f64; 2]) -> (f64, Vec<f64>) {
    let mut problem = Problem::new(step, &[0.2, 0.4, 0.0, 0.0], NODES).expect("a problem");
    let space = problem.state_space().clone();
    let goal = [0.9, -0.3, 0.0, 0.0];
    let running = quadratic(&space, &goal, vec![0.01; 4], Some(r.to_vec()));
    problem.set_running_cost(0..NODES, running).expect("a cost");
    problem.set_terminal_cost(quadratic(&space, &goal, vec![100.0; 4], None)).expect("a cost");
    let mut options = FddpOptions::default();
    options.max_iterations = 100;
    let mut solver = Fddp::new(problem, options).expect("options");
    solver.set_rollout(&vec![vec![0.0; 2]; NODES]).expect("a rollout");
    let report = solver.solve().expect("a trajectory");
    assert!(report.is_solved(), "{report:?}");
    (report.cost, solver.control(0).to_vec())
}

/// Through gears the same motion is optimal: u = τ/n, if the weight of u is that of τ times n².
#[test]
fn gears_change_the_controls_alone() {
    for method in [Method::Implicit, Method::Fixed(Integrator::RungeKutta4)] {
        let (cost, tau) = reach(step_of(arm(), method), [1e-4; 2]);
        let weights = GEARS.map(|gear| 1e-4 * gear * gear);
        let driven = step_of(geared(), method).with_actuators().expect("actuators");
        assert_eq!(driven.controls(), 2);
        let (other, u) = reach(driven, weights);
        assert!((other - cost).abs() < 1e-6 * cost, "{} {cost} {other}", method.name());
        for k in 0..2 {
            assert!((u[k] * GEARS[k] - tau[k]).abs() < 1e-3 * (1.0 + tau[k].abs()), "{u:?} {tau:?}");
        }
    }
}

/// A and B agree with differences of the step, for servos, tendons and motors at their torque-speed curve.
#[test]
fn derivatives_by_controls_agree_with_differences() {
    let mut robot = geared();
    robot.actuators[0] = robot.actuators[0].clone().servo(30.0, 0.4);
    let both = [("shoulder".to_owned(), 0.5), ("elbow".to_owned(), 1.0)];
    robot.tendons.push(TendonDescription::new("cable", both));
    let over = Transmission::Tendon { tendon: "cable".to_owned(), gear: 3.0 };
    robot.actuators.push(ActuatorDescription::new("cable", over));
    let motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0);
    robot.add_motor("elbow", &MotorDrive::new(motor, 10.0, 1e-5)).expect("a motor");
    for method in [Method::Implicit, Method::Fixed(Integrator::RungeKutta4)] {
        let mut step = step_of(robot.clone(), method).with_actuators().expect("actuators");
        let (x, u) = ([0.3, -0.8, 0.5, 1.1], [0.2, 1.5, -0.7, 0.3]);
        let (mut a, mut b) = (vec![0.0; 16], vec![0.0; 16]);
        step.linearize(&x, &u, LinearizedDynamics { by_state: &mut a, by_control: &mut b }).expect("A and B");
        let mut ends = |k: usize, by: f64| {
            let (mut x, mut u, mut next) = (x, u, [0.0; 4]);
            if k < 4 {
                x[k] += by;
            } else {
                u[k - 4] += by;
            }
            step.step(&x, &u, &mut next).expect("a step");
            next
        };
        for k in 0..8 {
            let h = 1e-6;
            let (after, before) = (ends(k, h), ends(k, -h));
            for i in 0..4 {
                let slope = (after[i] - before[i]) / (2.0 * h);
                let found = if k < 4 { a[4 * i + k] } else { b[4 * i + k - 4] };
                assert!(
                    (found - slope).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{} {i} {k}: {found} {slope}",
                    method.name()
                );
            }
        }
    }
}

/// A robot without actuators, and an actuator with states, are refused with their names.
#[test]
fn actuators_with_states_are_refused() {
    let error = step_of(arm(), Method::Implicit).with_actuators().map(drop).unwrap_err().to_string();
    assert!(error.contains("no actuator"), "{error}");
    let mut robot = geared();
    robot.actuators[1].activation = Activation::Filter { time_constant: 0.1 };
    let error = step_of(robot, Method::Implicit).with_actuators().map(drop).unwrap_err().to_string();
    assert!(error.contains("`elbow`"), "{error}");
}

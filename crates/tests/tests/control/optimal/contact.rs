//! Optimal control through the contacts of a simulation.

use robot_dynamics::contact::Ground;
use robot_dynamics::control::optimal::{
    ActuationMatrix, Cost, Fddp, FddpOptions, Problem, SimulationStep, StateResidual,
};
use robot_dynamics::description::{
    Base, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::nalgebra::{Matrix3, Vector3};
use robot_dynamics::simulation::{Method, SimulationBuilder};

const G: f64 = 9.81;
const FRICTION: f64 = 0.3;
const MASS: f64 = 2.0;
const H: f64 = 0.01;
const NODES: usize = 40;

/// A block on the ground, pushed along x.
fn pushed_block() -> SimulationStep {
    let mut robot = RobotDescription::new("block");
    robot.base = Base::Floating;
    let inertia = Matrix3::identity() * 8e-3;
    let mass = MassProperties::new(MASS, Vector3::zeros(), inertia).expect("a mass");
    robot.links.push(LinkDescription::new("block", mass));
    let shape = Shape::Box { size: [0.2, 0.2, 0.1] };
    robot.shapes.push(LinkShape::new("block", ShapeRole::Collision, Pose::IDENTITY, shape));
    let model = Model::new(robot).expect("a robot");
    let ground = Ground::level(0.0).with_friction(FRICTION);
    let simulation = SimulationBuilder::new(&model).method(Method::Implicit).ground(ground).dt(H);
    let step = SimulationStep::new(&simulation.build().expect("a simulation"));
    let push = ActuationMatrix::new(6, 1, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).expect("a matrix");
    step.with_actuation(push).expect("a matrix")
}

/// The block slides to a goal and is nearly at rest there. The work of the pushes is what friction takes.
#[test]
fn a_block_is_pushed_to_its_goal() {
    let (goal, resting) = (0.25, 0.05);
    let start = [&[0.0, 0.0, resting, 0.0, 0.0, 0.0, 1.0][..], &[0.0; 6]].concat();
    let mut problem = Problem::new(pushed_block(), &start, NODES).expect("a problem");
    let space = problem.state_space().clone();
    let mut target = start.clone();
    target[0] = goal;
    let mut terminal = Cost::new();
    let weights = [[1e3, 0.0, 0.0, 0.0, 0.0, 0.0], [1e1, 0.0, 0.0, 0.0, 0.0, 0.0]].concat();
    terminal.add(StateResidual::new(&space, &target).expect("a state"), weights).expect("weights");
    problem.set_terminal_cost(terminal).expect("a cost");
    let mut running = Cost::new();
    let effort = robot_dynamics::control::optimal::ControlResidual::new(&[0.0]).expect("controls");
    running.add(effort, 1e-4 * H).expect("weights");
    problem.set_running_cost(0..NODES, running).expect("a cost");
    let mut solver = Fddp::new(problem, FddpOptions::default()).expect("options");
    // The first guess moves the block: while it sticks, a push changes nothing.
    let guess = vec![vec![FRICTION * MASS * G + 2.0]; NODES];
    solver.set_rollout(&guess).expect("a rollout");
    let report = solver.solve().expect("a solution");
    let end = solver.state(NODES);
    assert!(report.is_solved(), "{report:?}");
    assert!((end[0] - goal).abs() < 2e-2 && end[7].abs() < 0.1, "{end:?}");
    // The block stays on the ground and does not turn.
    assert!((end[2] - resting).abs() < 1e-9 && end[6] > 1.0 - 1e-9, "{end:?}");
    let work: f64 =
        (0..NODES).map(|k| solver.control(k)[0] * (solver.state(k + 1)[0] - solver.state(k)[0])).sum();
    let kinetic = 0.5 * MASS * end[7] * end[7];
    let friction = FRICTION * MASS * G * end[0];
    // Friction takes the work, to the order of the step.
    assert!((work - kinetic - friction).abs() < 3e-2 * friction, "{work} {kinetic} {friction}");
}

//! A quadruped that falls and lands, with contacts that the simulator finds.

use std::sync::Arc;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::contact::Ground;
use robot_dynamics::control::optimal::{
    ActuationMatrix, ControlResidual, Cost, DiscreteDynamics, Fddp, FddpOptions, Problem, SimulationStep,
    StateResidual,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::nalgebra::DVector;
use robot_dynamics::simulation::{Method, SimulationBuilder};
use robot_dynamics::{LoadOptions, load_with};

const QUADRUPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
const STEP: f64 = 0.01;
const NODES: usize = 40;

/// The quadruped with its feet on the ground, and its state at rest.
fn standing() -> (Arc<Model>, Vec<f64>) {
    let model =
        load_with(QUADRUPED, &LoadOptions::default().with_floating_base()).expect("a quadruped").model;
    let mut x = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &[0.0, 0.7, -1.4].repeat(4), &[0.0; 18]].concat();
    let foot = model.frame_named("front_left_foot").expect("a foot");
    x[2] = 0.02 - frame_pose(&model, &mut Workspace::new(&model), &x[..19], foot).translation[2];
    (Arc::new(model), x)
}

/// The springs of the first guess end in a crouch. The solver finds torques with which the quadruped lands
/// and stands still at the target, although its feet touch the ground in steps that impacts divide.
#[test]
fn a_quadruped_falls_and_stands() {
    let (model, target) = standing();
    let mut start = target.clone();
    start[2] += 0.1;
    let ground = Ground::level(0.0).with_friction(0.7);
    let simulation = SimulationBuilder::new(&model).method(Method::Implicit).ground(ground).dt(STEP);
    let mut step = SimulationStep::new(&simulation.build().expect("a simulation"))
        .with_actuation(ActuationMatrix::actuated(&model))
        .expect("motors");
    let mut problem = Problem::new(step.clone(), &start, NODES).expect("a problem");
    let space = problem.state_space().clone();
    let weights = |scale: f64| {
        let parts = [(100.0, 6), (1.0, 12), (1.0, 6), (0.01, 12)];
        parts.into_iter().flat_map(|(weight, count)| vec![scale * weight; count]).collect::<Vec<_>>()
    };
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    let state = || StateResidual::new(&space, &target).expect("a state");
    running.add(state(), weights(STEP)).expect("weights");
    running.add(ControlResidual::new(&[0.0; 12]).expect("controls"), 1e-3 * STEP).expect("weights");
    terminal.add(state(), weights(10.0)).expect("weights");
    problem.set_running_cost(0..NODES, running).expect("a cost");
    problem.set_terminal_cost(terminal).expect("a cost");
    let mut options = FddpOptions::default();
    options.max_iterations = 7;
    let mut solver = Fddp::new(problem, options).expect("options");
    let (mut x, mut guess) = (start, Vec::new());
    for _ in 0..NODES {
        let u: Vec<f64> = (0..12).map(|k| 30.0 * (target[7 + k] - x[7 + k]) - x[25 + k]).collect();
        let mut next = x.clone();
        step.step(&x, &u, &mut next).expect("a step");
        x = next;
        guess.push(u);
    }
    solver.set_rollout(&guess).expect("a rollout");
    let off = |x: &[f64]| {
        let mut away = vec![0.0; 36];
        space.difference(&target, x, &mut away);
        (DVector::from_column_slice(&away[..6]).amax(), DVector::from_column_slice(&away[18..]).amax())
    };
    assert!(off(&x).0 > 0.04);
    let report = solver.solve().expect("a trajectory");
    let (pose, speed) = off(solver.state(NODES));
    assert!(report.cost < 0.25 && pose < 2e-3 && speed < 0.1, "{report:?} {pose} {speed}");
}

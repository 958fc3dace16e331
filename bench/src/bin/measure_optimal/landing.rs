//! A quadruped that falls from 10 cm and lands, with contacts that the simulator finds.

use std::error::Error;
use std::sync::Arc;

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::contact::Ground;
use robot_dynamics::control::optimal::{
    ActuationMatrix, ControlResidual, Cost, DiscreteDynamics, Problem, SimulationStep, StateResidual,
};
use robot_dynamics::model::Workspace;
use robot_dynamics::simulation::{Method, SimulationBuilder};
use robot_dynamics::{LoadOptions, load_with};

const QUADRUPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/quadruped.urdf");

/// The radius of the feet \[m\], and the length of a step \[s\].
const RADIUS: f64 = 0.02;
const STEP: f64 = 0.01;

/// The problem and a first guess of its torques.
type Landing = (Problem, Vec<Vec<f64>>);

/// The problem, and torques of springs at the joints, which land in a crouch.
pub(crate) fn landing(nodes: usize) -> Result<Landing, Box<dyn Error>> {
    let model = Arc::new(load_with(QUADRUPED, &LoadOptions::default().with_floating_base())?.model);
    let mut target =
        [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &[0.0, 0.7, -1.4].repeat(4), &[0.0; 18]].concat();
    let foot =
        frame_pose(&model, &mut Workspace::new(&model), &target[..19], model.frame_named("front_left_foot")?);
    target[2] = RADIUS - foot.translation[2];
    let mut start = target.clone();
    start[2] += 0.1;
    let ground = Ground::level(0.0).with_friction(0.7);
    let simulation =
        SimulationBuilder::new(&model).method(Method::Implicit).ground(ground).dt(STEP).build()?;
    let mut step = SimulationStep::new(&simulation).with_actuation(ActuationMatrix::actuated(&model))?;
    let mut problem = Problem::new(step.clone(), &start, nodes)?;
    let space = problem.state_space().clone();
    let weights = |scale: f64| {
        let parts = [(100.0, 6), (1.0, 12), (1.0, 6), (0.01, 12)];
        parts.into_iter().flat_map(|(weight, count)| vec![scale * weight; count]).collect::<Vec<_>>()
    };
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    running.add(StateResidual::new(&space, &target)?, weights(STEP))?;
    running.add(ControlResidual::new(&[0.0; 12])?, 1e-3 * STEP)?;
    terminal.add(StateResidual::new(&space, &target)?, weights(10.0))?;
    problem.set_running_cost(0..nodes, running)?;
    problem.set_terminal_cost(terminal)?;
    let (mut x, mut torques) = (start, Vec::new());
    for _ in 0..nodes {
        let u: Vec<f64> = (0..12).map(|k| 30.0 * (target[7 + k] - x[7 + k]) - x[25 + k]).collect();
        let mut next = x.clone();
        step.step(&x, &u, &mut next)?;
        x = next;
        torques.push(u);
    }
    Ok((problem, torques))
}

//! Optimal control: residuals and their derivatives, FDDP against closed forms and independent solutions.

mod actuators;
mod bounds;
mod constraints;
mod contact;
mod derivatives;
mod gait;
mod held_contacts;
mod landing;
mod linear_quadratic;
mod mpc;
mod robots;
mod sampling;

use std::sync::Arc;

use robot_dynamics::control::optimal::{
    ControlResidual, Cost, LinearDynamics, Problem, StateResidual, StateSpace,
};
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::model::Model;
use robot_dynamics::nalgebra::DMatrix;

/// A cost ½ Σ q (x − x\*)² + ½ Σ r u².
pub(crate) fn quadratic(space: &StateSpace, target: &[f64], q: Vec<f64>, r: Option<Vec<f64>>) -> Cost {
    let mut cost = Cost::new();
    cost.add(StateResidual::new(space, target).expect("a state"), q).expect("weights");
    if let Some(r) = r {
        cost.add(ControlResidual::new(&vec![0.0; r.len()]).expect("controls"), r).expect("weights");
    }
    cost
}

/// x′ = A x + B u from x₀ with the costs of `quadratic`.
pub(crate) fn linear_problem(
    (a, b): (&DMatrix<f64>, &DMatrix<f64>),
    (q, r, last): (&[f64], &[f64], &[f64]),
    start: &[f64],
    nodes: usize,
) -> Problem {
    let dynamics = LinearDynamics::new(a.clone(), b.clone()).expect("matrices");
    let mut problem = Problem::new(dynamics, start, nodes).expect("a problem");
    let (space, origin) = (problem.state_space().clone(), vec![0.0; start.len()]);
    let running = quadratic(&space, &origin, q.to_vec(), Some(r.to_vec()));
    problem.set_running_cost(0..nodes, running).expect("a cost");
    problem.set_terminal_cost(quadratic(&space, &origin, last.to_vec(), None)).expect("a cost");
    problem
}

/// A tree with quaternions, hinges and sliders.
pub(crate) fn floating_tree(seed: u64) -> Arc<Model> {
    let options =
        RandomRobotOptions { joints: 5, kinds: JointKinds::All, base: Base::Floating, ..Default::default() };
    Arc::new(Model::new(random_robot(seed, &options)).expect("a robot"))
}

//! Robots: a reach of the Panda, a swing-up with bounded force, infeasible starts, phases.

use std::ops::ControlFlow;
use std::sync::Arc;

use robot_dynamics::control::optimal::{
    ActuationMatrix, ControlBounds, ControlResidual, Cost, Fddp, FddpOptions, FrameTranslationResidual,
    Problem, SmoothStep, StateResidual, Termination,
};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::Model;
use robot_dynamics::nalgebra::{Matrix3, Vector3};
use robot_dynamics::simulation::Integrator;

const PANDA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");

/// The reach of 50 steps of 20 ms that is also solved with crocoddyl and by an iLQR in Python.
fn panda_reach(nodes: usize) -> Problem {
    let model = Arc::new(robot_dynamics::load(PANDA).expect("the Panda").model);
    let (n, h) = (model.nv(), 0.02);
    let start = [0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6];
    let x0: Vec<f64> = start.into_iter().chain([0.0; 7]).collect();
    let hold = model.gravity_forces(&start).expect("torques").as_slice().to_vec();
    let step = SmoothStep::new(model.clone(), Integrator::SemiImplicitEuler, h).expect("a step");
    let mut problem = Problem::new(step.with_dissipation(false), &x0, nodes).expect("a problem");
    let space = problem.state_space().clone();
    let by_part = |q: f64, v: f64| [vec![q; n], vec![v; n]].concat();
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    let state = || StateResidual::new(&space, &x0).expect("a state");
    running.add(state(), by_part(1e-2 * h, 1e-1 * h)).expect("weights");
    running.add(ControlResidual::new(&hold).expect("controls"), 1e-3 * h).expect("weights");
    terminal.add(state(), by_part(1e-2, 10.0)).expect("weights");
    let hand = model.frame_named("panda_link8").expect("the hand");
    let reach = FrameTranslationResidual::new(model, hand, [0.35, 0.45, 0.25]).expect("a target");
    terminal.add(reach, 1e4).expect("weights");
    problem.set_running_cost(0..nodes, running).expect("a cost");
    problem.set_terminal_cost(terminal).expect("a cost");
    problem
}

fn hold_torques(problem: &Problem) -> Vec<Vec<f64>> {
    let model = problem.state_space().model().expect("a robot");
    let hold = model.gravity_forces(&problem.initial_state()[..model.nq()]).expect("torques");
    vec![hold.as_slice().to_vec(); problem.nodes()]
}

/// The cost that crocoddyl 3.2.1 and the iLQR of a user reach, to the digits that they print.
#[test]
fn the_reach_of_a_panda_costs_what_other_programs_find() {
    let problem = panda_reach(50);
    let torques = hold_torques(&problem);
    let mut feasible = Fddp::new(problem, FddpOptions::default()).expect("options");
    // Multiple shooting from a start that violates the dynamics finds the same minimum.
    let mut infeasible = feasible.clone();
    feasible.set_rollout(&torques).expect("a rollout");
    let states: Vec<Vec<f64>> = (0..=50)
        .map(|k| feasible.problem().initial_state().iter().map(|x| x + 0.002 * f64::from(k)).collect())
        .collect();
    infeasible.set_trajectory(&states, &torques).expect("a start");
    for solver in [&mut feasible, &mut infeasible] {
        let report = solver.solve().expect("a solution");
        assert!(report.is_solved(), "{report:?} {:#?}", solver.log());
        assert!((report.cost - 0.048312).abs() < 1e-6, "{report:?}");
        assert!(report.defect <= 1e-9 && report.iterations <= 20, "{report:?}");
    }
}

/// Each next step of the solution is that of the dynamics, to the rounding of a step.
#[test]
fn solutions_satisfy_the_dynamics() {
    let mut solver = Fddp::new(panda_reach(12), FddpOptions::default()).expect("options");
    let report = solver.solve().expect("a solution");
    assert!(report.is_solved(), "{report:?}");
    let controls: Vec<Vec<f64>> = (0..12).map(|k| solver.control(k).to_vec()).collect();
    let mut again = solver.clone();
    again.set_rollout(&controls).expect("a rollout");
    for node in 0..=12 {
        let off = solver.state(node).iter().zip(again.state(node)).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{node}");
    }
}

/// A cart of 1 kg on a rail, and a pole of 0.2 kg at 0.5 m that hangs at 0.
fn cart_pole() -> Arc<Model> {
    let mut robot = RobotDescription::new("cart-pole");
    let point =
        |mass: f64, at: Vector3<f64>| MassProperties::new(mass, at, Matrix3::zeros()).expect("a mass");
    robot.links.push(LinkDescription::new("rail", None));
    robot.links.push(LinkDescription::new("cart", point(1.0, Vector3::zeros())));
    robot.links.push(LinkDescription::new("pole", point(0.2, Vector3::new(0.0, 0.0, -0.5))));
    let slide = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.joints.push(JointDescription::new("slide", slide, "rail", "cart", Pose::IDENTITY));
    robot.joints.push(JointDescription::new("hinge", hinge, "cart", "pole", Pose::IDENTITY));
    Arc::new(Model::new(robot).expect("a robot"))
}

const SWING_NODES: usize = 120;

fn swing_up(limit: f64) -> Problem {
    let model = cart_pole();
    let step = SmoothStep::new(model, Integrator::SemiImplicitEuler, 0.025).expect("a step");
    let push = ActuationMatrix::new(2, 1, &[1.0, 0.0]).expect("a matrix");
    let step = step.with_actuation(push).expect("a matrix");
    let mut problem = Problem::new(step, &[0.0; 4], SWING_NODES).expect("a problem");
    let space = problem.state_space().clone();
    let up = [0.0, std::f64::consts::PI, 0.0, 0.0];
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    running.add(ControlResidual::new(&[0.0]).expect("controls"), 1e-3).expect("weights");
    terminal
        .add(StateResidual::new(&space, &up).expect("a state"), vec![300.0, 600.0, 100.0, 100.0])
        .expect("weights");
    problem.set_running_cost(0..SWING_NODES, running).expect("a cost");
    problem.set_terminal_cost(terminal).expect("a cost");
    let bounds = ControlBounds::new(&[-limit], &[limit]).expect("bounds");
    problem.set_control_bounds(0..SWING_NODES, bounds).expect("bounds");
    problem
}

#[test]
fn a_pole_swings_up_within_the_limit_of_the_force() {
    let limit = 5.0;
    let mut options = FddpOptions::default();
    options.max_iterations = 500;
    let mut solver = Fddp::new(swing_up(limit), options).expect("options");
    let report = solver.solve().expect("a solution");
    assert!(report.is_solved(), "{report:?}");
    let last = solver.state(SWING_NODES);
    let off = [last[0], last[1] - std::f64::consts::PI, last[2], last[3]];
    assert!(off.iter().all(|x| x.abs() < 0.05), "{last:?} {report:?}");
    let forces: Vec<f64> = (0..SWING_NODES).map(|k| solver.control(k)[0]).collect();
    assert!(forces.iter().all(|u| u.abs() <= limit));
    assert!(forces.iter().any(|u| u.abs() == limit), "{forces:?}");
}

#[test]
fn a_callback_and_a_limit_end_the_solver() {
    let mut options = FddpOptions::default();
    options.max_iterations = 3;
    let mut solver = Fddp::new(swing_up(4.0), options).expect("options");
    assert_eq!(solver.solve().expect("a report").termination, Termination::IterationLimit);
    assert_eq!(solver.log().len(), 3);
    let stop = |record: &robot_dynamics::control::optimal::IterationRecord| match record.iteration {
        1 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let report = solver.solve_with(stop).expect("a report");
    assert_eq!((report.termination, report.iterations), (Termination::Interrupted, 2));
}

/// The same motion whether one dynamics or two equal ones serve the nodes.
#[test]
fn nodes_have_their_own_dynamics() {
    let whole = panda_reach(20);
    let mut phases = whole.clone();
    let model = whole.state_space().model().expect("a robot").clone();
    let step = SmoothStep::new(model.clone(), Integrator::SemiImplicitEuler, 0.02).expect("a step");
    phases.set_dynamics(5..20, step.clone().with_dissipation(false)).expect("dynamics");
    let cost = |problem: Problem| {
        let mut solver = Fddp::new(problem, FddpOptions::default()).expect("options");
        let report = solver.solve().expect("a solution");
        assert!(report.is_solved(), "{report:?}");
        report.cost
    };
    assert_eq!(cost(whole), cost(phases));
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let mut problem = swing_up(1.0);
    let mut cost = Cost::new();
    cost.add(ControlResidual::new(&[0.0; 2]).expect("controls"), 1.0).expect("weights");
    let error = problem.set_running_cost(0..3, cost.clone()).expect_err("two controls");
    assert!(error.to_string().contains("2 controls"), "{error}");
    assert!(problem.set_terminal_cost(cost).is_err());
    assert!(problem.set_running_cost(100..121, Cost::new()).is_err());
    assert!(problem.set_initial_state(&[0.0; 3]).is_err());
    assert!(problem.set_initial_state(&[f64::NAN; 4]).is_err());
    assert!(
        Problem::new(
            SmoothStep::new(cart_pole(), Integrator::RungeKutta4, 0.1).expect("a step"),
            &[0.0; 4],
            0
        )
        .is_err()
    );
}

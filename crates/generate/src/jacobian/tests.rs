//! Derivatives through the graph agree with those of the recursions, of dual numbers and of differences.

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics_expression::interpret;

use super::*;
use crate::free_robot::free_robot;

/// The graph's tangents agree with the recursions for derivatives, to the rounding of both, with κ(M) below
/// 1e5.
#[test]
fn tangents_agree_with_the_recursions() {
    let model = free_robot();
    for function in [Function::InverseDynamics, Function::ForwardDynamics] {
        for arithmetic in [Arithmetic::default(), Arithmetic::default().with_fused()] {
            let program = Program::new(&function, &model, arithmetic, 5).unwrap();
            let (graph, results) = forward(&program, arithmetic);
            let plan = Plan::new(&graph, &results);
            let compute = by_recursions(&function, &model).unwrap();
            for case in &program.cases {
                let (found, _) = interpret(&graph, &plan, &results, arithmetic, &case.arguments);
                let expected = evaluate(arithmetic, &case.arguments, &compute);
                for (found, expected) in found.iter().zip(&expected) {
                    let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                    for (x, y) in found.iter().zip(expected) {
                        assert!((x - y).abs() <= 1e5 * f64::EPSILON * size, "{function}: {x:e}, {y:e}");
                    }
                }
            }
        }
    }
}

/// Every function's Jacobian agrees with central differences over the numbers of its arguments. Steps of 1e-6
/// leave 1e-12 of curvature and 1e-10 of rounding, times the size of the derivatives.
#[test]
fn tangents_are_the_limits_of_differences() {
    let (model, arithmetic) = (free_robot(), Arithmetic::default());
    let frame = model.frames().last().unwrap().name.clone();
    for function in
        [Function::FramePose(frame.clone()), Function::FrameJacobian(ReferenceFrame::Local, frame)]
            .iter()
            .chain(&Function::PLAIN)
    {
        if *function == Function::Dissipation {
            continue; // friction jumps with the sign of v
        }
        let program = Program::new(function, &model, arithmetic, 1).unwrap();
        if program.plan.steps() > 3000 {
            continue; // derivatives of derivatives: long, and nothing new
        }
        let derivatives = jacobian(&program, &model, arithmetic);
        let at = &program.cases[0].arguments;
        let (found, _) =
            interpret(&derivatives.graph, &derivatives.plan, &derivatives.results, arithmetic, at);
        let value = |arguments: &[Vec<f64>]| {
            interpret(&program.graph, &program.plan, &program.results, arithmetic, arguments).0
        };
        for (a, argument) in program.arguments.iter().enumerate() {
            for index in 0..argument.length {
                let moved = |by: f64| {
                    let mut arguments = at.clone();
                    arguments[a][index] += by;
                    value(&arguments)
                };
                let (ahead, back) = (moved(1e-6), moved(-1e-6));
                for (r, outcome) in program.outcomes.iter().enumerate() {
                    let block = &found[r * program.arguments.len() + a];
                    let size = block.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                    let size = ahead[r].iter().fold(size, |most, x| most.max(x.abs()));
                    for entry in 0..outcome.length() {
                        let difference = (ahead[r][entry] - back[r][entry]) / 2e-6;
                        let slope = block[entry * argument.length + index];
                        assert!(
                            (difference - slope).abs() < 1e-6 * size,
                            "{function}, {} {entry} by {} {index}: {slope:e}, {difference:e}",
                            outcome.name,
                            argument.name
                        );
                    }
                }
            }
        }
    }
}

/// The derivatives of a step through the graph are those of the linearised step, which differentiates the
/// recursions. The robot is an arm, whose q are plain numbers. The tolerance is 1e4 roundings of the largest
/// number, as κ(M) is below 1e4.
#[test]
fn the_derivatives_of_a_step_are_those_of_the_linearised_step() {
    use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
    use robot_dynamics::simulation::StepForces;
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/panda.urdf");
    let model = robot_dynamics::load(path).unwrap().model;
    let (arithmetic, function) = (Arithmetic::default(), Function::SemiImplicitEulerStep);
    let row = function.integrator().unwrap();
    let program = Program::new(&function, &model, arithmetic, 4).unwrap();
    let derivatives = jacobian(&program, &model, arithmetic);
    println!("{} operations, their derivatives {}", program.plan.steps(), derivatives.plan.steps());
    let n = model.nv();
    for case in &program.cases {
        let (found, _) = interpret(
            &derivatives.graph,
            &derivatives.plan,
            &derivatives.results,
            arithmetic,
            &case.arguments,
        );
        let [q, v, tau, h] = &case.arguments[..] else { unreachable!("four arguments") };
        let (mut by_state, mut by_force) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
        let forces = StepForces::new(tau, true);
        let w = &mut LinearizeStepWorkspace::new(&model);
        let out = LinearizedStep { by_state: &mut by_state, by_force: &mut by_force };
        linearize_step(&model, row, w, &forces, h[0], RobotState { q, v }, out).unwrap();
        let size = by_state.iter().chain(&by_force).fold(1.0_f64, |most, x| most.max(x.abs()));
        // Blocks of results by arguments: q after the step by q, v, τ, h, then v by these.
        for (block, found) in found.iter().enumerate().filter(|(block, _)| block % 4 < 3) {
            let (result, argument) = (block / 4, block % 4);
            for (i, derivatives) in found.chunks(n).enumerate() {
                for (j, slope) in derivatives.iter().enumerate() {
                    let row = result * n + i;
                    let expected = match argument {
                        2 => by_force[row * n + j],
                        argument => by_state[row * 2 * n + argument * n + j],
                    };
                    let off = (slope - expected).abs();
                    assert!(off <= 1e4 * f64::EPSILON * size, "{block}, {i}, {j}: {slope:e}, {expected:e}");
                }
            }
        }
    }
}

//! Derivatives through the graph, forward, backward and as pullbacks, agree with the library's dual numbers
//! and recursions.

use robot_dynamics::derivatives::{
    LinearizeStepWorkspace, LinearizedStep, MotionCotangents, RobotState, StepPullbackWorkspace,
    linearize_step, step_pullback,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, StepForces};
use robot_dynamics_expression::{Precision, interpret};

use super::*;
use crate::FunctionError;
use crate::free_robot::free_robot;

/// All functions that have derivatives, those of frames for the last frame.
fn functions(model: &Model) -> Vec<Function> {
    let of_frames = Function::of_frame(&model.frames().last().unwrap().name);
    Function::PLAIN.into_iter().chain(of_frames).filter(Function::is_differentiable).collect()
}

/// In both precisions, fused and not, the simplified derivatives agree with the library's dual numbers up to
/// rounding. In doubles they agree to 1e-10 of the largest number (κ(M) is below 1e5 in these states).
#[test]
fn derivatives_agree_with_dual_numbers() {
    let model = free_robot();
    let (own, single) = (Arithmetic::default(), Arithmetic::new(Precision::Single));
    let mut compared = 0;
    for function in functions(&model) {
        for derivatives in
            [Function::Derivatives(Box::new(function.clone())), Function::Pullback(Box::new(function))]
        {
            for arithmetic in [own, own.with_fused(), single] {
                let program = Program::new(&derivatives, &model, arithmetic, 2).unwrap();
                for case in &program.cases {
                    let (found, _) = interpret(
                        &program.graph,
                        &program.plan,
                        &program.results,
                        arithmetic,
                        &case.arguments,
                    );
                    assert_eq!(found.len(), program.outcomes.len());
                    let mut size = 0.0_f64;
                    for ((found, expected), outcome) in found.iter().zip(&case.results).zip(&program.outcomes)
                    {
                        assert_eq!(expected.len(), outcome.length(), "{derivatives}: {}", outcome.name);
                        assert_eq!(found.len(), expected.len(), "{derivatives}: {}", outcome.name);
                        for (x, y) in found.iter().zip(expected) {
                            let off = (x - y).abs();
                            assert!(
                                off <= program.tolerance,
                                "{derivatives}, {arithmetic:?}: {x:e}, not {y:e}"
                            );
                            size = size.max(y.abs());
                            compared += 1;
                        }
                    }
                    let is_precise =
                        arithmetic.precision == Precision::Single || program.tolerance < 1e-10 * size;
                    assert!(is_precise || size == 0.0, "{derivatives}: {:e} of {size:e}", program.tolerance);
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// A step's derivatives are A and B of the library's linearised step, and its pullback is the library's. This
/// holds for each integrator of generated steps; κ(M) is below 1e5 in these states.
#[test]
fn derivatives_of_a_step_agree_with_the_library() {
    let (model, arithmetic) = (free_robot(), Arithmetic::default());
    let nv = model.nv();
    for function in [Function::SemiImplicitEulerStep, Function::Rk4Step] {
        let row: Integrator = function.integrator().unwrap();
        let run = |function: &Function| {
            let program = Program::new(function, &model, arithmetic, 3).unwrap();
            let of = |case: &crate::program::Case| {
                interpret(&program.graph, &program.plan, &program.results, arithmetic, &case.arguments).0
            };
            let found: Vec<_> = program.cases.iter().map(of).collect();
            (program.cases, found)
        };
        let close = |x: &[f64], y: &[f64], what: &str| {
            let size = y.iter().fold(1.0_f64, |most, y| most.max(y.abs()));
            for (x, y) in x.iter().zip(y) {
                assert!((x - y).abs() <= 1e5 * f64::EPSILON * size, "{function}, {what}: {x:e}, {y:e}");
            }
        };
        let (cases, found) = run(&function.clone().derivatives());
        for (case, found) in cases.iter().zip(&found) {
            let [q, v, tau, h] = &case.arguments[..] else { panic!("four arguments") };
            let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
            let w = &mut LinearizeStepWorkspace::new(&model);
            let forces = StepForces::new(tau, true);
            let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
            linearize_step(&model, row, w, &forces, h[0], RobotState { q, v }, out).unwrap();
            let block = |of: &[f64], width: usize, i: usize, j: usize| -> Vec<f64> {
                (0..nv).flat_map(|k| of[(i * nv + k) * width + j * nv..][..nv].to_vec()).collect()
            };
            for half in 0..2 {
                let own = |k: usize| &found[k][half * nv * nv..][..nv * nv];
                close(own(0), &block(&a, 2 * nv, half, 0), "by q");
                close(own(1), &block(&a, 2 * nv, half, 1), "by v");
                close(own(2), &block(&b, nv, half, 0), "by force");
            }
        }
        let (cases, found) = run(&function.clone().pullback());
        for (case, found) in cases.iter().zip(&found) {
            let [q, v, tau, h, weights] = &case.arguments[..] else { panic!("five arguments") };
            let (q_weights, v_weights) = weights.split_at(nv);
            let (mut by_q, mut by_v, mut by_tau) = (q_weights.to_vec(), v_weights.to_vec(), vec![0.0; nv]);
            let w = &mut StepPullbackWorkspace::new(&model);
            let forces = StepForces::new(tau, true);
            let cotangents = MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: &mut [],
            };
            step_pullback(&model, row, w, &forces, h[0], RobotState { q, v }, cotangents).unwrap();
            close(&found[0], &by_q, "pulled to q");
            close(&found[1], &by_v, "pulled to v");
            close(&found[2], &by_tau, "pulled to tau");
        }
    }
}

/// The chain rule backward through the graph agrees with the library's recursions for pullbacks.
#[test]
fn pullbacks_agree_with_the_library() {
    let (model, arithmetic) = (free_robot(), Arithmetic::default());
    for (function, by_recursions) in [
        (Function::InverseDynamics, Function::InverseDynamicsPullback),
        (Function::ForwardDynamics, Function::ForwardDynamicsPullback),
    ] {
        let through = Program::new(&Function::Pullback(Box::new(function)), &model, arithmetic, 3).unwrap();
        let own = Program::new(&by_recursions, &model, arithmetic, 3).unwrap();
        for case in &own.cases {
            let (found, _) =
                interpret(&through.graph, &through.plan, &through.results, arithmetic, &case.arguments);
            let expected = &case.results[case.results.len() - 3..];
            for (found, expected) in found.iter().zip(expected) {
                let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                for (x, y) in found.iter().zip(expected) {
                    let off = (x - y).abs();
                    assert!(off <= 1e5 * f64::EPSILON * size, "{by_recursions}: {x:e}, {y:e}");
                }
            }
        }
    }
}

/// Derivatives of derivatives are refused by name.
#[test]
fn derivatives_have_no_derivatives() {
    let model = free_robot();
    let parsed = |text: &str| text.parse::<Function>().unwrap_err();
    let text = "inverse_dynamics_pullback_derivatives";
    assert!(matches!(parsed(text), FunctionError::NotDifferentiable { function } if function == text));
    let text = "gravity_derivatives_derivatives";
    assert!(matches!(parsed(text), FunctionError::Unknown { name } if name == text));
    let nested = Function::Gravity.derivatives().derivatives();
    let error = Program::new(&nested, &model, Arithmetic::default(), 1).unwrap_err();
    let GenerateError::Function(FunctionError::NotDifferentiable { function }) = &error else {
        panic!("{error}")
    };
    assert_eq!(function, "gravity_derivatives_derivatives");
    let pose: Function = "frame_pose_pullback:hand".parse().unwrap();
    assert_eq!(pose, Function::FramePose("hand".into()).pullback());
    assert_eq!("rk4_step_derivatives".parse::<Function>().unwrap(), Function::Rk4Step.derivatives());
}

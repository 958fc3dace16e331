//! Slopes through the graph against the recursions', against dual numbers and against differences.

use multibody::{Base, JointKind, RandomRobotOptions, random_robot};

use super::*;
use crate::program::interpret;

/// A robot that nothing holds, with a ball, springs, friction and a follower.
fn robot() -> Model {
    let options = RandomRobotOptions {
        joints: 4,
        base: Base::Floating,
        mimic: 0.3,
        passive: 1.0,
        ..Default::default()
    };
    let has_ball = |model: &Model| model.joints().iter().any(|joint| joint.kind == JointKind::Spherical);
    (0..1000)
        .map(|seed| Model::new(random_robot(seed, &options)).unwrap())
        .find(|model| has_ball(model) && model.has_mimic())
        .unwrap()
}

/// The graph's tangents and the recursions for slopes agree: to the rounding of both, with κ(M) below 1e5.
#[test]
fn tangents_are_the_recursions_slopes() {
    let model = robot();
    for function in [Function::InverseDynamics, Function::ForwardDynamics] {
        for arithmetic in [Arithmetic::default(), Arithmetic::default().with_fused()] {
            let program = Program::new(&function, &model, arithmetic, 5).unwrap();
            let (graph, results) = forward(&program, arithmetic);
            let plan = Plan::new(&graph, &results);
            let compute = by_recursions(&function, &model).unwrap();
            for case in &program.cases {
                let found = interpret(&graph, &plan, &results, arithmetic, &case.arguments);
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

/// Every function's Jacobian against central differences over the numbers of its arguments: steps of 1e-6 leave
/// 1e-12 of curvature and 1e-10 of rounding, times what the slopes are.
#[test]
fn tangents_are_the_limits_of_differences() {
    let (model, arithmetic) = (robot(), Arithmetic::default());
    let frame = model.frames().last().unwrap().name.clone();
    for function in [Function::FramePose(frame.clone()), Function::FrameJacobianInFrame(frame)]
        .iter()
        .chain(&Function::PLAIN)
    {
        if *function == Function::Dissipation {
            continue; // friction jumps with the sign of v
        }
        let program = Program::new(function, &model, arithmetic, 1).unwrap();
        if program.plan.steps() > 3000 {
            continue; // slopes of slopes: long, and nothing new
        }
        let slopes = jacobian(&program, &model, arithmetic);
        let at = &program.cases[0].arguments;
        let found = interpret(&slopes.graph, &slopes.plan, &slopes.results, arithmetic, at);
        let value = |arguments: &[Vec<f64>]| {
            interpret(&program.graph, &program.plan, &program.results, arithmetic, arguments)
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

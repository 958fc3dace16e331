//! The methods of differentiation agree with each other.

use robot_dynamics_core::{RandomState, random_state};
use robot_dynamics_expression::{Plan, interpret};
use robot_dynamics_number::SplitMix64;

use super::*;
use crate::testing::free_robot;

/// Forward mode, backward mode and, for gravity and bias, the library's recursions give the same derivatives.
#[test]
fn all_methods_agree() {
    let (model, arithmetic) = (free_robot(), Arithmetic::default());
    let mut random = SplitMix64::new(2026);
    for function in
        [Function::Gravity, Function::Bias, Function::SemiImplicitEulerStep, Function::KineticEnergy]
    {
        let traced = function.trace(&model, arithmetic).unwrap();
        let mut graph = traced.graph.clone();
        let arguments = (function.arguments(&model).iter().enumerate())
            .map(|(k, argument)| (0..argument.length).map(|index| graph.input(k, index)).collect())
            .collect();
        let input = DifferentiationInput {
            function: &function,
            model: &model,
            arithmetic,
            graph: &graph,
            results: &traced.results,
            arguments,
        };
        let mut methods = vec![input.forward(), input.backward()];
        methods.extend(input.by_recursions());
        let is_recursive = matches!(function, Function::Gravity | Function::Bias);
        assert_eq!(methods.len(), if is_recursive { 3 } else { 2 });
        for _ in 0..3 {
            let RandomState { q, v, tau, .. } = random_state(&model, &mut random);
            let state = [q, v, tau, vec![random.uniform(1e-4, 1e-2)]];
            let given = &state[..function.arguments(&model).len()];
            let found: Vec<_> = (methods.iter())
                .map(|(graph, results)| {
                    interpret(graph, &Plan::new(graph, results), results, arithmetic, given)
                })
                .collect();
            for (other, bounds) in &found[1..] {
                let (first, first_bounds) = &found[0];
                let all = |x: &[Vec<f64>]| x.concat();
                let bounds: Vec<f64> =
                    all(bounds).iter().zip(all(first_bounds)).map(|(x, y)| 2.0 * (x + y)).collect();
                for ((x, y), bound) in all(first).iter().zip(all(other)).zip(bounds) {
                    assert!((x - y).abs() <= bound, "{function}: {x:e}, {y:e}, to {bound:e}");
                }
            }
        }
    }
}

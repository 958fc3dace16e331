//! The Jacobians of a function with respect to all its arguments, as CasADi requests them.

use robot_dynamics::model::{InstructionSet, Model, Workspace, cotangent_to_coordinates};
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, Traced, chain, evaluate, trace};
use robot_dynamics_number::Scalar;

use crate::Function;
use crate::program::{Argument, Program, ProgramResult};

/// The program of ∂result/∂argument for each result and argument, with a row for each entry of the result.
/// Derivatives are with respect to the numbers of q; of a quaternion, the function depends on the direction
/// alone.
pub(crate) fn jacobian(program: &Program, model: &Model, arithmetic: Arithmetic) -> Program {
    let lengths: Vec<usize> = program.arguments.iter().map(|argument| argument.length).collect();
    let (mut graph, mut results) = forward(program, arithmetic);
    let mut plan = Plan::new(&graph, &results);
    let mut cases = program.cases.clone();
    cases.clear();
    if let Some(compute) = by_recursions(&program.function, model) {
        let (other, other_results) = trace(arithmetic, &lengths, &compute);
        let other_plan = Plan::new(&other, &other_results);
        // The shorter program is used.
        if other_plan.steps() < plan.steps() {
            (graph, results, plan) = (other, other_results, other_plan);
            for case in &program.cases {
                let mut case = case.clone();
                case.results = evaluate(arithmetic, &case.arguments, &compute);
                cases.push(case);
            }
        }
    }
    let mut outcomes = Vec::new();
    for outcome in &program.outcomes {
        for argument in &program.arguments {
            let name = format!("jac_{}_{}", outcome.name, argument.name);
            outcomes.push(ProgramResult { name, rows: outcome.length(), columns: argument.length, what: "" });
        }
    }
    Program {
        function: program.function.clone(),
        symbol: format!("jac_{}", program.symbol),
        arguments: program.arguments.iter().map(|x| Argument { unit: "", ..*x }).collect(),
        outcomes,
        graph,
        results,
        plan,
        cases,
        entries: Vec::new(),
        tolerance: 0.0,
        stages: None,
    }
}

/// The library's own recursions for the derivatives, where it has them.
fn by_recursions(function: &Function, model: &Model) -> Option<impl Fn(&[Vec<Traced>]) -> Vec<Vec<Traced>>> {
    let is_inverse = match function {
        Function::InverseDynamics => true,
        Function::ForwardDynamics => false,
        _ => return None,
    };
    Some(move |arguments: &[Vec<Traced>]| {
        let [q, v, x] = arguments else { unreachable!("three arguments") };
        let (nq, nv) = (model.nq(), model.nv());
        let w = &mut Workspace::<Traced>::limited(model, InstructionSet::Portable);
        let zeros = |count: usize| vec![Traced::zero(); count];
        let (mut by_q, mut by_v, mut by_x) = (zeros(nv * nv), zeros(nv * nv), zeros(nv * nv));
        if is_inverse {
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, q, v, x, out);
            robot_dynamics::algorithms::mass_matrix(model, w, q, &mut by_x);
        } else {
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_x,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, q, v, x, out);
        }
        let mut by_numbers = zeros(nv * nq);
        for (row, by_numbers) in by_q.chunks(nv).zip(by_numbers.chunks_mut(nq)) {
            cotangent_to_coordinates(model, q, row, by_numbers);
        }
        vec![by_numbers, by_v, by_x]
    })
}

/// Forward mode through the graph: a tangent for each number of each argument.
fn forward(program: &Program, arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    let mut graph = program.graph.clone();
    let steps = chain::steps(&graph, &program.results);
    let mut blocks = vec![Vec::new(); program.results.len() * program.arguments.len()];
    for (result, entries) in program.results.iter().enumerate() {
        for (argument, of) in program.arguments.iter().enumerate() {
            blocks[result * program.arguments.len() + argument] =
                vec![Operand::ZERO; entries.len() * of.length];
        }
    }
    for (argument, of) in program.arguments.iter().enumerate() {
        for index in 0..of.length {
            let seed =
                |a: usize, i: usize| Operand::constant(if (a, i) == (argument, index) { 1.0 } else { 0.0 });
            let tangents = chain::push_forward(&mut graph, &steps, seed, arithmetic);
            for (result, entries) in program.results.iter().enumerate() {
                let block = &mut blocks[result * program.arguments.len() + argument];
                for (row, &entry) in entries.iter().enumerate() {
                    block[row * of.length + index] = chain::tangent_of(&tangents, entry);
                }
            }
        }
    }
    (graph, blocks)
}

#[cfg(test)]
mod tests;

//! The slopes of a function by all its arguments, as CasADi asks for them.

use multibody::{InstructionSet, Model, Workspace, cotangent_to_coordinates};
use number::Scalar;

use crate::graph::{Graph, Operand, Operation};
use crate::plan::Plan;
use crate::program::{Argument, Outcome, Program};
use crate::traced::{Traced, evaluate, trace};
use crate::{Arithmetic, Function};

/// The program of ∂result/∂argument for each result and argument, a row for each entry of the result. By the numbers of q:
/// of a quaternion the function depends on the direction alone.
pub(crate) fn jacobian(program: &Program, model: &Model, arithmetic: Arithmetic) -> Program {
    let lengths: Vec<usize> = program.arguments.iter().map(|argument| argument.length).collect();
    let (mut graph, mut results) = forward(program, arithmetic);
    let mut plan = Plan::new(&graph, &results);
    let mut cases = program.cases.clone();
    cases.clear();
    if let Some(compute) = by_recursions(&program.function, model) {
        let (other, other_results) = trace(arithmetic, &lengths, &compute);
        let other_plan = Plan::new(&other, &other_results);
        // Whichever is shorter.
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
            outcomes.push(Outcome { name, rows: outcome.length(), columns: argument.length, what: "" });
        }
    }
    Program {
        function: program.function.clone(),
        symbol: format!("jac_{}", program.symbol),
        arguments: program.arguments.iter().map(|x| Argument { unit: "", ..x.clone() }).collect(),
        outcomes,
        graph,
        results,
        plan,
        cases,
        entries: Vec::new(),
        tolerance: 0.0,
    }
}

/// The library's own recursions for the slopes, where it has them.
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
            multibody::inverse_dynamics_derivatives(model, w, q, v, x, &mut by_q, &mut by_v);
            multibody::mass_matrix(model, w, q, &mut by_x);
        } else {
            multibody::forward_dynamics_derivatives(model, w, q, v, x, &mut by_q, &mut by_v, &mut by_x);
        }
        let mut by_numbers = zeros(nv * nq);
        for (row, by_numbers) in by_q.chunks(nv).zip(by_numbers.chunks_mut(nq)) {
            cotangent_to_coordinates(model, q, row, by_numbers);
        }
        vec![by_numbers, by_v, by_x]
    })
}

/// A tangent for each number of each argument through the graph (Griewank, Walther, *Evaluating Derivatives*, 2008, ch. 3.1).
fn forward(program: &Program, arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    let mut graph = program.graph.clone();
    let steps: Vec<usize> = {
        let needed = graph.needed(program.results.iter().flatten().copied());
        (0..graph.nodes.len()).filter(|&node| needed[node]).collect()
    };
    let mut blocks = vec![Vec::new(); program.results.len() * program.arguments.len()];
    for (result, entries) in program.results.iter().enumerate() {
        for (argument, of) in program.arguments.iter().enumerate() {
            blocks[result * program.arguments.len() + argument] =
                vec![Operand::ZERO; entries.len() * of.length];
        }
    }
    let mut tangents = vec![Operand::ZERO; graph.nodes.len()];
    for (argument, of) in program.arguments.iter().enumerate() {
        for index in 0..of.length {
            tangents.fill(Operand::ZERO);
            for &node in &steps {
                tangents[node] = match graph.nodes[node] {
                    Operation::Input { argument: a, index: i } => {
                        let is_own = (a as usize, i as usize) == (argument, index);
                        Operand::constant(if is_own { 1.0 } else { 0.0 })
                    }
                    operation => tangent(&mut graph, &tangents, node, operation, arithmetic),
                };
            }
            for (result, entries) in program.results.iter().enumerate() {
                let block = &mut blocks[result * program.arguments.len() + argument];
                for (row, &entry) in entries.iter().enumerate() {
                    block[row * of.length + index] = tangent_of(&tangents, entry);
                }
            }
        }
    }
    (graph, blocks)
}

fn tangent_of(tangents: &[Operand], operand: Operand) -> Operand {
    match operand {
        Operand::Constant(_) => Operand::ZERO,
        Operand::Plus(node) => tangents[node as usize],
        Operand::Minus(node) => tangents[node as usize].negated(),
    }
}

/// The chain rule for one operation.
fn tangent(
    graph: &mut Graph,
    tangents: &[Operand],
    node: usize,
    operation: Operation,
    arithmetic: Arithmetic,
) -> Operand {
    let of = |operand| tangent_of(tangents, operand);
    if operation.operands().all(|operand| of(operand) == Operand::ZERO) {
        return Operand::ZERO;
    }
    let value = Operand::Plus(u32::try_from(node).expect("fewer than 2³² operations"));
    let product = |graph: &mut Graph, a: Operand, b: Operand, c: Operand| {
        if arithmetic.fused {
            return graph.fused(a, b, c);
        }
        let product = graph.product(a, b);
        graph.sum(product, c)
    };
    match operation {
        Operation::Input { .. } | Operation::Sign(_) => Operand::ZERO,
        Operation::Sum(a, b) => graph.sum(of(a), of(b)),
        Operation::Difference(a, b) => graph.sum(of(a), of(b).negated()),
        Operation::Product(a, b) => {
            let second = graph.product(a, of(b));
            product(graph, of(a), b, second)
        }
        Operation::Fused(a, b, c) => {
            let second = product(graph, a, of(b), of(c));
            product(graph, of(a), b, second)
        }
        Operation::FusedMinus(a, b, c) => {
            let second = product(graph, a.negated(), of(b), of(c));
            product(graph, of(a).negated(), b, second)
        }
        // (a′ − (a/b) b′)/b, by 1/b, which all tangents share.
        Operation::Quotient(a, b) => {
            let rest = product(graph, value.negated(), of(b), of(a));
            let inverse = graph.quotient(Operand::constant(1.0), b);
            graph.product(rest, inverse)
        }
        Operation::Root(a) => {
            let half = graph.quotient(Operand::constant(0.5), value);
            graph.product(of(a), half)
        }
        Operation::SineCosine(a) => of(a),
        Operation::Sine(pair) => {
            let cosine = graph.push(Operation::Cosine(pair));
            graph.product(of(pair), cosine)
        }
        Operation::Cosine(pair) => {
            let sine = graph.push(Operation::Sine(pair));
            graph.product(of(pair), sine).negated()
        }
    }
}

#[cfg(test)]
mod tests;

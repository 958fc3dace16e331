//! What generated code does, done here.

use super::*;

/// The operations done one after the other, in its plan's order: the oracle of what each language writes.
pub(crate) fn interpret(
    graph: &Graph,
    plan: &Plan,
    results: &[Vec<Operand>],
    arithmetic: Arithmetic,
    arguments: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let mut values = vec![f64::NAN; graph.nodes.len()];
    for (node, operation) in graph.nodes.iter().enumerate() {
        if let Operation::Input { argument, index } = *operation {
            values[node] = arguments[argument as usize][index as usize];
        }
    }
    let round = |x: f64| arithmetic.precision.round(x);
    let value = |values: &[f64], operand: Operand| match operand {
        Operand::Constant(bits) => f64::from_bits(bits),
        Operand::Plus(node) => values[node as usize],
        Operand::Minus(node) => -values[node as usize],
    };
    for &node in plan.parts.iter().flatten() {
        let of = |operand| value(&values, operand);
        values[node] = match graph.nodes[node] {
            Operation::Input { .. } => unreachable!("no step"),
            Operation::Sum(a, b) => round(of(a) + of(b)),
            Operation::Difference(a, b) => round(of(a) - of(b)),
            Operation::Product(a, b) => round(of(a) * of(b)),
            Operation::Quotient(a, b) => round(of(a) / of(b)),
            Operation::Fused(a, b, c) => arithmetic.precision.multiply_add(of(a), of(b), of(c)),
            Operation::FusedMinus(a, b, c) => arithmetic.precision.multiply_add(-of(a), of(b), of(c)),
            Operation::Root(a) => round(of(a).sqrt()),
            Operation::Sign(a) => number::Scalar::signum0(of(a)),
            Operation::SineCosine(a) => of(a),
            Operation::Sine(a) | Operation::Cosine(a) => {
                let angle = vec![vec![of(a)]];
                let pair = |x: &[Vec<Traced>]| {
                    let (sine, cosine) = number::Scalar::sin_cos(x[0][0]);
                    vec![vec![sine, cosine]]
                };
                let is_cosine = matches!(graph.nodes[node], Operation::Cosine(_));
                evaluate(arithmetic, &angle, pair)[0][usize::from(is_cosine)]
            }
        };
    }
    let result = |result: &Vec<Operand>| result.iter().map(|&entry| value(&values, entry)).collect();
    results.iter().map(result).collect()
}

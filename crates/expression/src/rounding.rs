//! The evaluation of a graph, operation by operation, with a bound on the rounding errors.

use robot_dynamics_number::Scalar;

use crate::Arithmetic;
use crate::graph::{Graph, Operand, Operation};
use crate::plan::Plan;
use crate::traced::{Traced, evaluate};

/// The results, by rows, and a bound on the error of each.
///
/// Each operation propagates the errors of its operands by its derivatives and adds half a unit of its
/// result's last place. This is a running error analysis, to first order (Higham, *Accuracy and Stability of
/// Numerical Algorithms*, 2002, §3.3). The error of a sine or cosine is two units.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Plan, interpret, trace};
/// let arithmetic = Arithmetic::default();
/// let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] / x[0][1]]]);
/// let plan = Plan::new(&graph, &results);
/// let (values, bounds) = interpret(&graph, &plan, &results, arithmetic, &[vec![1.0, 3.0]]);
/// assert_eq!(values[0][0], 1.0 / 3.0);
/// assert_eq!(bounds[0][0], 0.5 * f64::EPSILON / 3.0); // half a unit of the last place
/// ```
#[allow(clippy::type_complexity)] // values, bounds
pub fn interpret(
    graph: &Graph,
    plan: &Plan,
    results: &[Vec<Operand>],
    arithmetic: Arithmetic,
    arguments: &[Vec<f64>],
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let mut values = vec![(f64::NAN, f64::NAN); graph.nodes.len()];
    for (node, operation) in graph.nodes.iter().enumerate() {
        if let Operation::Input { argument, index } = *operation {
            values[node] = (arguments[argument as usize][index as usize], 0.0);
        }
    }
    let round = |x: f64| arithmetic.precision.round(x);
    let half = 0.5 * arithmetic.precision.epsilon();
    for &node in &plan.order {
        let of = |operand| value(&values, operand, half);
        let (result, passed_on) = match graph.nodes[node] {
            Operation::Input { .. } => unreachable!("no step"),
            Operation::Sum(a, b) => (round(of(a).0 + of(b).0), of(a).1 + of(b).1),
            Operation::Difference(a, b) => (round(of(a).0 - of(b).0), of(a).1 + of(b).1),
            Operation::Product(a, b) => (round(of(a).0 * of(b).0), product(of(a), of(b))),
            Operation::Quotient(a, b) => {
                let ((a, of_a), (b, of_b)) = (of(a), of(b));
                (round(a / b), (of_a + (a / b).abs() * of_b) / b.abs())
            }
            Operation::Fused(a, b, c) => {
                let result = arithmetic.precision.multiply_add(of(a).0, of(b).0, of(c).0);
                (result, product(of(a), of(b)) + of(c).1)
            }
            Operation::FusedMinus(a, b, c) => {
                let result = arithmetic.precision.multiply_add(-of(a).0, of(b).0, of(c).0);
                (result, product(of(a), of(b)) + of(c).1)
            }
            Operation::Root(a) => {
                let root = of(a).0.sqrt();
                (round(root), if root > 0.0 { of(a).1 / (2.0 * root) } else { 0.0 })
            }
            Operation::Sign(a) => (Scalar::signum0(of(a).0), 0.0),
            Operation::SineCosine(a) => of(a),
            Operation::Sine(a) | Operation::Cosine(a) => {
                let angle = vec![vec![of(a).0]];
                let pair = |x: &[Vec<Traced>]| {
                    let (sine, cosine) = Scalar::sin_cos(x[0][0]);
                    vec![vec![sine, cosine]]
                };
                let is_cosine = matches!(graph.nodes[node], Operation::Cosine(_));
                (evaluate(arithmetic, &angle, pair)[0][usize::from(is_cosine)], of(a).1 + 3.0 * half)
            }
        };
        values[node] = (result, passed_on + half * result.abs());
    }
    let result = |result: &Vec<Operand>| result.iter().map(|&entry| value(&values, entry, half)).unzip();
    results.iter().map(result).unzip()
}

/// |b| δa + |a| δb.
fn product((a, of_a): (f64, f64), (b, of_b): (f64, f64)) -> f64 {
    b.abs() * of_a + a.abs() * of_b
}

/// The value and error bound of an operand; a constant was rounded too.
fn value(values: &[(f64, f64)], operand: Operand, half: f64) -> (f64, f64) {
    match operand {
        Operand::Constant(bits) => {
            let x = f64::from_bits(bits);
            (x, half * x.abs())
        }
        Operand::Plus(node) => values[node as usize],
        Operand::Minus(node) => {
            let (x, off) = values[node as usize];
            (-x, off)
        }
    }
}

//! The chain rule through a graph, forward and backward.
//!
//! Source: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.1 (tangents), 3.2 (adjoints).

use crate::Arithmetic;
use crate::graph::{Graph, Operand, Operation};

/// The operations that the results depend on, inputs included, in order.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, trace};
/// use robot_dynamics_expression::chain::steps;
/// let (graph, results) = trace(Arithmetic::default(), &[2], |x| {
///     let _ = x[0][0] * x[0][1]; // no result depends on it
///     vec![vec![x[0][0] + x[0][1]]]
/// });
/// assert_eq!(steps(&graph, &results).len(), 3);
/// ```
pub fn steps(graph: &Graph, results: &[Vec<Operand>]) -> Vec<usize> {
    let needed = graph.needed(results.iter().flatten().copied());
    (0..graph.nodes.len()).filter(|&node| needed[node]).collect()
}

/// The tangents of these operations along one direction, whose component for each number of the arguments is
/// `seed(argument, index)`.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Operand, trace};
/// use robot_dynamics_expression::chain::{push_forward, steps, tangent_of};
/// let arithmetic = Arithmetic::default();
/// let (mut graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
/// let order = steps(&graph, &results);
/// let tangents = push_forward(&mut graph, &order, |_, _| Operand::constant(1.0), arithmetic);
/// let x = graph.input(0, 0);
/// assert_eq!(tangent_of(&tangents, results[0][0]), graph.sum(x, x)); // d(x²) = x dx + x dx
/// ```
pub fn push_forward(
    graph: &mut Graph,
    steps: &[usize],
    seed: impl Fn(usize, usize) -> Operand,
    arithmetic: Arithmetic,
) -> Vec<Operand> {
    let mut tangents = vec![Operand::ZERO; graph.nodes.len()];
    for &node in steps {
        tangents[node] = match graph.nodes[node] {
            Operation::Input { argument, index } => seed(argument as usize, index as usize),
            operation => tangent(graph, &tangents, node, operation, arithmetic),
        };
    }
    tangents
}

/// The adjoints of these operations, accumulated from the given weights of some values. An adjoint is the
/// derivative of the weighted sum of these values with respect to an operation's value.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Operand, trace};
/// use robot_dynamics_expression::chain::{pull_back, steps};
/// let arithmetic = Arithmetic::default();
/// let (mut graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] * x[0][1]]]);
/// let (order, weight) = (steps(&graph, &results), Operand::constant(1.0));
/// let adjoints = pull_back(&mut graph, &order, std::iter::once((results[0][0], weight)), arithmetic);
/// let (x, y) = (graph.input(0, 0), graph.input(0, 1));
/// assert_eq!([adjoints[0], adjoints[1]], [y, x]); // ∂(x y)/∂x = y, ∂(x y)/∂y = x
/// ```
pub fn pull_back(
    graph: &mut Graph,
    steps: &[usize],
    weights: impl Iterator<Item = (Operand, Operand)>,
    arithmetic: Arithmetic,
) -> Vec<Operand> {
    let mut adjoints = vec![Operand::ZERO; graph.nodes.len()];
    for (value, weight) in weights {
        add_to_adjoint(graph, &mut adjoints, value, weight);
    }
    for &node in steps.iter().rev() {
        let weight = adjoints[node];
        if weight != Operand::ZERO {
            let operation = graph.nodes[node];
            propagate_adjoint(graph, &mut adjoints, node, operation, weight, arithmetic);
        }
    }
    adjoints
}

/// Adds `weight` to the adjoint of an operand.
fn add_to_adjoint(graph: &mut Graph, adjoints: &mut [Operand], to: Operand, weight: Operand) {
    if let Some(node) = to.node() {
        let (is_negative, _) = to.split_sign();
        adjoints[node] = graph.sum(adjoints[node], weight.negated_if(is_negative));
    }
}

/// Adds a b to the adjoint of an operand.
fn add_product_to_adjoint(
    graph: &mut Graph,
    adjoints: &mut [Operand],
    to: Operand,
    (a, b): (Operand, Operand),
    arithmetic: Arithmetic,
) {
    if let Some(node) = to.node() {
        let (is_negative, _) = to.split_sign();
        adjoints[node] = multiply_add(graph, arithmetic, a.negated_if(is_negative), b, adjoints[node]);
    }
}

/// Adds the contributions of one operation with this adjoint to the adjoints of its operands.
fn propagate_adjoint(
    graph: &mut Graph,
    adjoints: &mut [Operand],
    node: usize,
    operation: Operation,
    weight: Operand,
    arithmetic: Arithmetic,
) {
    let value = value_of(node);
    match operation {
        Operation::Input { .. } | Operation::Sign(_) => {}
        Operation::Sum(a, b) => {
            add_to_adjoint(graph, adjoints, a, weight);
            add_to_adjoint(graph, adjoints, b, weight);
        }
        Operation::Difference(a, b) => {
            add_to_adjoint(graph, adjoints, a, weight);
            add_to_adjoint(graph, adjoints, b, weight.negated());
        }
        Operation::Product(a, b) => {
            add_product_to_adjoint(graph, adjoints, a, (weight, b), arithmetic);
            add_product_to_adjoint(graph, adjoints, b, (weight, a), arithmetic);
        }
        Operation::Fused(a, b, c) => {
            add_product_to_adjoint(graph, adjoints, a, (weight, b), arithmetic);
            add_product_to_adjoint(graph, adjoints, b, (weight, a), arithmetic);
            add_to_adjoint(graph, adjoints, c, weight);
        }
        Operation::FusedMinus(a, b, c) => {
            add_product_to_adjoint(graph, adjoints, a, (weight.negated(), b), arithmetic);
            add_product_to_adjoint(graph, adjoints, b, (weight.negated(), a), arithmetic);
            add_to_adjoint(graph, adjoints, c, weight);
        }
        // By 1/b, as in `tangent`.
        Operation::Quotient(a, b) => {
            let inverse = graph.quotient(Operand::constant(1.0), b);
            let of_numerator = graph.product(weight, inverse);
            add_to_adjoint(graph, adjoints, a, of_numerator);
            add_product_to_adjoint(graph, adjoints, b, (of_numerator.negated(), value), arithmetic);
        }
        Operation::Root(a) => {
            let half = graph.quotient(Operand::constant(0.5), value);
            add_product_to_adjoint(graph, adjoints, a, (weight, half), arithmetic);
        }
        Operation::SineCosine(a) => add_to_adjoint(graph, adjoints, a, weight),
        Operation::Sine(pair) => {
            let cosine = graph.push(Operation::Cosine(pair));
            add_product_to_adjoint(graph, adjoints, pair, (weight, cosine), arithmetic);
        }
        Operation::Cosine(pair) => {
            let sine = graph.push(Operation::Sine(pair));
            add_product_to_adjoint(graph, adjoints, pair, (weight.negated(), sine), arithmetic);
        }
    }
}

fn value_of(node: usize) -> Operand {
    Operand::Plus(u32::try_from(node).expect("fewer than 2³² operations"))
}

/// a b + c.
fn multiply_add(graph: &mut Graph, arithmetic: Arithmetic, a: Operand, b: Operand, c: Operand) -> Operand {
    if arithmetic.fused {
        return graph.fused(a, b, c);
    }
    let product = graph.product(a, b);
    graph.sum(product, c)
}

/// The tangent of an operand, from the tangents that [`push_forward`] returns. The tangent of a constant is
/// zero.
///
/// ```
/// use robot_dynamics_expression::Operand;
/// use robot_dynamics_expression::chain::tangent_of;
/// assert_eq!(tangent_of(&[], Operand::constant(3.0)), Operand::ZERO);
/// ```
pub fn tangent_of(tangents: &[Operand], operand: Operand) -> Operand {
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
    let value = value_of(node);
    let product =
        |graph: &mut Graph, a: Operand, b: Operand, c: Operand| multiply_add(graph, arithmetic, a, b, c);
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

//! The schedule of operations: the order in which they are computed.

use crate::graph::{Graph, Operand};

/// The operations that the results depend on, in order.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The operations, without inputs.
    pub order: Vec<usize>,
    /// The largest number of values that are live at the same time.
    pub live: usize,
}

impl Plan {
    /// The one of two orders with fewer live values: as traced, or depth first from the results.
    pub fn new(graph: &Graph, results: &[Vec<Operand>]) -> Self {
        let needed = graph.needed(results.iter().flatten().copied());
        let orders = [as_traced(graph, results), insert_halves(graph, &needed, &depth_first(graph, results))];
        let [(live, order), other] = orders.map(|order| (most_live(graph, &order), order));
        let (live, order) = if other.0 < live { other } else { (live, order) };
        Self { order, live }
    }

    /// The number of operations.
    pub fn steps(&self) -> usize {
        self.order.len()
    }
}

/// The operations that the results depend on, in the order of the trace, without inputs.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, as_traced, trace};
/// let (graph, results) = trace(Arithmetic::default(), &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
/// assert_eq!(as_traced(&graph, &results), [1]); // after the input
/// ```
pub fn as_traced(graph: &Graph, results: &[Vec<Operand>]) -> Vec<usize> {
    let needed = graph.needed(results.iter().flatten().copied());
    let traced: Vec<usize> = (0..graph.nodes.len()).filter(|&node| needed[node]).collect();
    insert_halves(graph, &needed, &traced)
}

/// The order without inputs, each pair followed by those of its halves that are needed.
fn insert_halves(graph: &Graph, needed: &[bool], order: &[usize]) -> Vec<usize> {
    let mut halves = vec![Vec::new(); graph.nodes.len()];
    for (node, operation) in graph.nodes.iter().enumerate() {
        if operation.is_half() && needed[node] {
            operation.reads().for_each(|pair| halves[pair].push(node));
        }
    }
    let mut with = Vec::with_capacity(order.len());
    for &node in order.iter().filter(|&&node| !graph.nodes[node].is_half() && !graph.nodes[node].is_input()) {
        with.push(node);
        with.append(&mut halves[node]);
    }
    with
}

/// The operations of one result after the other, depth first. The operand that needs more live values comes
/// first (Sethi and Ullman, *The generation of optimal code for arithmetic expressions*, J. ACM 17, 1970).
fn depth_first(graph: &Graph, results: &[Vec<Operand>]) -> Vec<usize> {
    let mut need = vec![0_usize; graph.nodes.len()];
    let operands = |node: usize, need: &[usize]| -> Vec<usize> {
        let mut operands: Vec<usize> = graph.nodes[node].reads().collect();
        operands.dedup();
        operands.sort_by_key(|&operand| (core::cmp::Reverse(need[operand]), operand));
        operands
    };
    for node in 0..need.len() {
        let each = operands(node, &need);
        need[node] = each.iter().enumerate().map(|(k, &operand)| need[operand] + k).max().unwrap_or(0).max(1);
    }
    let (mut order, mut seen) = (Vec::new(), vec![false; need.len()]);
    for root in results.iter().flatten().filter_map(|result| result.node()) {
        let mut pending = vec![(root, false)];
        while let Some((node, is_ready)) = pending.pop() {
            if is_ready {
                order.push(node);
            } else if !seen[node] {
                seen[node] = true;
                pending.push((node, true));
                pending.extend(operands(node, &need).into_iter().rev().map(|operand| (operand, false)));
            }
        }
    }
    order
}

/// The largest number of live values, those between their computation and their last use, in this order.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, as_traced, most_live, trace};
/// let (graph, results) = trace(Arithmetic::default(), &[2], |x| {
///     let squares = [x[0][0] * x[0][0], x[0][1] * x[0][1]];
///     vec![vec![squares[0] + squares[1]]]
/// });
/// assert_eq!(most_live(&graph, &as_traced(&graph, &results)), 2); // both squares
/// ```
pub fn most_live(graph: &Graph, order: &[usize]) -> usize {
    let mut reads = vec![0_usize; graph.nodes.len()];
    let computed = |node: usize| graph.nodes[node].reads().filter(|&read| !graph.nodes[read].is_input());
    for &node in order {
        computed(node).for_each(|read| reads[read] += 1);
    }
    let (mut live, mut most) = (0, 0);
    for &node in order {
        live += usize::from(reads[node] > 0);
        most = most.max(live);
        for read in computed(node) {
            reads[read] -= 1;
            live -= usize::from(reads[read] == 0);
        }
    }
    most
}

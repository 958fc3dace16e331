//! In which order operations are done, in how many functions, and what is kept between these.

use crate::graph::{Graph, Operand};

/// Operations of one function at most: compilers take longer than in proportion for long ones.
pub(crate) const MOST_STEPS: usize = 2000;

/// The operations of a program, in parts.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Operations in order, those of each function together; no inputs among them.
    pub(crate) parts: Vec<Vec<usize>>,
    /// By operation: where its value is kept, if a later part reads it.
    pub(crate) kept: Vec<Option<usize>>,
    /// By operation: the part that does it.
    pub(crate) part_of: Vec<usize>,
    /// By operation: when it is done.
    pub(crate) step_of: Vec<usize>,
    /// Places for kept values.
    pub(crate) places: usize,
    /// The most values that are computed and still to be read, at any time.
    pub(crate) live: usize,
}

impl Plan {
    /// The better of two orders: as traced, or depth first from the results.
    pub(crate) fn new(graph: &Graph, results: &[Vec<Operand>]) -> Self {
        let needed = graph.needed(results.iter().flatten().copied());
        let orders = [as_traced(graph, results), with_halves(graph, &needed, &depth_first(graph, results))];
        let [(live, order), other] = orders.map(|order| (most_live(graph, &order), order));
        let (live, order) = if other.0 < live { other } else { (live, order) };
        Self::divided(graph, &order, live)
    }

    /// Operations in all.
    pub(crate) fn steps(&self) -> usize {
        self.parts.iter().map(Vec::len).sum()
    }

    fn divided(graph: &Graph, order: &[usize], live: usize) -> Self {
        let count = order.len().div_ceil(MOST_STEPS).max(1);
        let length = order.len().div_ceil(count);
        let mut parts: Vec<Vec<usize>> = vec![Vec::new()];
        for &node in order {
            // A pair is nothing that can be kept: its halves stay with it.
            if parts.last().is_some_and(|part| part.len() >= length) && !graph.nodes[node].is_half() {
                parts.push(Vec::new());
            }
            parts.last_mut().expect("there is a first").push(node);
        }
        let mut part_of = vec![usize::MAX; graph.nodes.len()];
        let mut step_of = part_of.clone();
        order.iter().enumerate().for_each(|(step, &node)| step_of[node] = step);
        let mut last_read = vec![0; graph.nodes.len()];
        for (number, part) in parts.iter().enumerate() {
            for &node in part {
                part_of[node] = number;
                for read in graph.nodes[node].reads() {
                    last_read[read] = number;
                }
            }
        }
        let (kept, places) = keep(&parts, &last_read);
        // No array is empty.
        let places = if parts.len() > 1 { places.max(1) } else { 0 };
        Self { parts, kept, part_of, step_of, places, live }
    }
}

/// The operations that the results need, as the recursions do them; no inputs among them.
pub(crate) fn as_traced(graph: &Graph, results: &[Vec<Operand>]) -> Vec<usize> {
    let needed = graph.needed(results.iter().flatten().copied());
    let traced: Vec<usize> = (0..graph.nodes.len()).filter(|&node| needed[node]).collect();
    with_halves(graph, &needed, &traced)
}

/// A place for each value that a later part reads, free again after the last of these.
fn keep(parts: &[Vec<usize>], last_read: &[usize]) -> (Vec<Option<usize>>, usize) {
    let (mut kept, mut places) = (vec![None; last_read.len()], 0);
    let mut free = Vec::new();
    let mut freed_after: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    for (number, part) in parts.iter().enumerate() {
        for &node in part.iter().filter(|&&node| last_read[node] > number) {
            let place = free.pop().unwrap_or_else(|| {
                places += 1;
                places - 1
            });
            kept[node] = Some(place);
            freed_after[last_read[node]].push(place);
        }
        free.append(&mut freed_after[number]);
    }
    (kept, places)
}

/// An order without inputs, each pair followed by the halves that are needed.
fn with_halves(graph: &Graph, needed: &[bool], order: &[usize]) -> Vec<usize> {
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

/// Each result's operations after one another, of each operation's operands the one first that needs more values at
/// once (Sethi and Ullman, *The generation of optimal code for arithmetic expressions*, J. ACM 17, 1970).
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

/// The most values between their computation and their last use.
pub(crate) fn most_live(graph: &Graph, order: &[usize]) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precision;
    use crate::graph::Operation;

    /// x², x³, … x⁹ summed from the last: as traced all powers wait; the order found reads each result as it needs it.
    #[test]
    fn an_order_holds_each_operation_once_and_after_what_it_reads() {
        let mut graph = Graph::new(Precision::Double);
        let x = graph.push(Operation::Input { argument: 0, index: 0 });
        let (sine, cosine) = graph.sine_cosine(x);
        let mut power = graph.product(sine, cosine);
        let mut powers = vec![power];
        for _ in 0..3 * MOST_STEPS {
            power = graph.product(power, sine);
            powers.push(power);
        }
        let result = powers.iter().rev().fold(Operand::ZERO, |sum, &power| graph.sum(sum, power));
        let plan = Plan::new(&graph, &[vec![result]]);
        let mut done = vec![false; graph.nodes.len()];
        done[0] = true;
        for (number, part) in plan.parts.iter().enumerate() {
            assert!(part.len() <= MOST_STEPS + 2);
            for &node in part {
                for read in graph.nodes[node].reads() {
                    assert!(done[read], "{read} before {node}");
                    let is_here = plan.part_of[read] == number || graph.nodes[read].is_input();
                    assert!(is_here || plan.kept[read].is_some(), "{read} is read in part {number}");
                }
                assert!(!core::mem::replace(&mut done[node], true), "{node} twice");
            }
        }
        assert_eq!(plan.parts.len(), 7); // of 12 000 operations and a sine
        assert!(done.iter().all(|&done| done) && plan.live >= 3 * MOST_STEPS);
    }

    /// No two values that are read after each other's computation share a place.
    #[test]
    fn a_place_holds_one_value_at_a_time() {
        let parts = [vec![0, 1, 2], vec![3, 4], vec![5], vec![6]];
        let last_read = [1, 2, 0, 2, 3, 3, 3];
        let (kept, places) = keep(&parts, &last_read);
        // No array is empty.
        let places = if parts.len() > 1 { places.max(1) } else { 0 };
        assert_eq!(kept[2], None);
        let interval =
            |node: usize| (parts.iter().position(|part| part.contains(&node)).unwrap(), last_read[node]);
        for a in 0..6 {
            for b in a + 1..6 {
                if kept[a].is_some() && kept[a] == kept[b] {
                    assert!(interval(a).1 < interval(b).0, "{a} {b}");
                }
            }
        }
        assert_eq!(places, 4);
    }
}

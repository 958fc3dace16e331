//! The layout of a generated function: its operations in straight code or loops, its parts, and the values
//! that are stored in an array between these.

use robot_dynamics_expression::{Graph, Operand, Plan};

use crate::affine_index::AffineIndex;

/// The largest number of operations of one part: compile times grow faster than linearly.
pub(crate) const MAX_STEPS: usize = 2000;

/// The regions of a function, in parts.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// The regions of each part, in order.
    pub(crate) parts: Vec<Vec<Region>>,
    /// By operation: the array place of its value, if another part or a loop reads it there.
    pub(crate) stored_at: Vec<Option<usize>>,
    /// By operation: the part that computes it.
    pub(crate) part_of: Vec<usize>,
    /// By operation: its position in the order.
    pub(crate) step_of: Vec<usize>,
    /// By operation: whether a loop computes it.
    pub(crate) in_loop: Vec<bool>,
    /// The length of the array.
    pub(crate) array_length: usize,
    /// The largest number of live values.
    pub(crate) live: usize,
}

/// A region of a function: straight code (a basic block) or a loop.
#[derive(Clone, Debug)]
pub(crate) enum Region {
    /// Operations in order.
    Straight(Vec<usize>),
    /// Operations that are written once for all iterations.
    Loop(Loop),
}

/// A loop: operations that each iteration does on other numbers.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub(crate) iterations: usize,
    /// Copies to adjacent array places before the first iteration: to which place, which operation's value.
    pub(crate) copies: Vec<(usize, usize)>,
    /// The loop-carried variables.
    pub(crate) carried: Vec<CarriedVariable>,
    pub(crate) steps: Vec<LoopStep>,
}

/// A loop-carried variable: each iteration sets it for the next.
#[derive(Clone, Debug)]
pub(crate) struct CarriedVariable {
    /// Its number among all of the function.
    pub(crate) number: usize,
    /// The operation whose value it has in the first iteration.
    pub(crate) first: usize,
    /// The operation, of the first iteration, whose value it has in the next one.
    pub(crate) next: usize,
}

/// An operation of a loop.
#[derive(Clone, Debug)]
pub(crate) struct LoopStep {
    /// The operation of the first iteration, which determines the kind, the signs of the operands, and the
    /// name.
    pub(crate) node: usize,
    pub(crate) reads: Vec<LoopOperand>,
    /// The array index at which each iteration stores its value.
    pub(crate) stored_at: Option<AffineIndex>,
    /// The results that its value is stored in.
    pub(crate) stores: Vec<ResultStore>,
}

impl LoopStep {
    /// Whether it uses the number of the iteration as an index.
    pub(crate) fn uses_iteration(&self) -> bool {
        let is_indexed = |read: &LoopOperand| match read {
            LoopOperand::ConstantTable(_) => true,
            LoopOperand::Input { index, .. } | LoopOperand::Array(index) => index.step != 0,
            LoopOperand::Invariant(_) | LoopOperand::SameIteration(_) | LoopOperand::Carried(_) => false,
        };
        let stored = self.stores.iter().map(|store| store.index).chain(self.stored_at);
        self.reads.iter().any(is_indexed) || stored.into_iter().any(|index| index.step != 0)
    }
}

/// An operand of an operation in a loop, without its sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LoopOperand {
    /// A loop-invariant value.
    Invariant(Operand),
    /// A constant for each iteration, by its bits.
    ConstantTable(Vec<u64>),
    /// A number of an argument.
    Input { argument: usize, index: AffineIndex },
    /// The value of an operation of the same iteration, given by the operation of the first iteration.
    SameIteration(usize),
    /// A loop-carried variable, by its place in the list.
    Carried(usize),
    /// A value in the array.
    Array(AffineIndex),
}

/// A store of a value to a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ResultStore {
    pub(crate) result: usize,
    pub(crate) is_minus: bool,
    pub(crate) index: AffineIndex,
}

impl Layout {
    /// Straight code, in parts of about equal length.
    pub(crate) fn straight(graph: &Graph, plan: &Plan) -> Self {
        let Plan { order, live } = plan;
        let count = order.len().div_ceil(MAX_STEPS).max(1);
        let length = order.len().div_ceil(count);
        let mut parts: Vec<Vec<usize>> = vec![Vec::new()];
        for &node in order {
            // A pair cannot be stored, so its halves stay in the same part.
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
        let (stored_at, length) = assign_places(&parts, &last_read);
        // Arrays must not be empty.
        let array_length = if parts.len() > 1 { length.max(1) } else { 0 };
        let in_loop = vec![false; graph.nodes.len()];
        let parts = parts.into_iter().map(|part| vec![Region::Straight(part)]).collect();
        Self { parts, stored_at, part_of, step_of, in_loop, array_length, live: *live }
    }

    /// The loops.
    pub(crate) fn loops(&self) -> impl Iterator<Item = &Loop> {
        self.parts.iter().flatten().filter_map(|piece| match piece {
            Region::Straight(_) => None,
            Region::Loop(repeated) => Some(repeated),
        })
    }

    pub(crate) fn has_loops(&self) -> bool {
        self.loops().next().is_some()
    }

    /// The number of operations in the text.
    pub(crate) fn written_steps(&self) -> usize {
        let of = |piece: &Region| match piece {
            Region::Straight(nodes) => nodes.len(),
            Region::Loop(repeated) => repeated.steps.len(),
        };
        self.parts.iter().flatten().map(of).sum()
    }

    /// The number of lines: operations, stores to the array, copies, assignments of carried variables, and
    /// two for each loop.
    pub(crate) fn lines(&self) -> usize {
        let of = |piece: &Region| match piece {
            Region::Straight(nodes) => {
                nodes.len() + nodes.iter().filter(|&&node| self.stored_at[node].is_some()).count()
            }
            Region::Loop(repeated) => {
                let kept = repeated.steps.iter().filter(|step| step.stored_at.is_some()).count();
                2 + repeated.copies.len() + 2 * repeated.carried.len() + repeated.steps.len() + kept
            }
        };
        self.parts.iter().flatten().map(of).sum()
    }
}

/// Assigns an array place to each value that a later part reads. The place is free again after the last of
/// these parts.
fn assign_places(parts: &[Vec<usize>], last_read: &[usize]) -> (Vec<Option<usize>>, usize) {
    let (mut stored_at, mut places) = (vec![None; last_read.len()], 0);
    let mut free = Vec::new();
    let mut freed_after: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    for (number, part) in parts.iter().enumerate() {
        for &node in part.iter().filter(|&&node| last_read[node] > number) {
            let place = free.pop().unwrap_or_else(|| {
                places += 1;
                places - 1
            });
            stored_at[node] = Some(place);
            freed_after[last_read[node]].push(place);
        }
        free.append(&mut freed_after[number]);
    }
    (stored_at, places)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_expression::{Operation, Precision};

    use super::*;

    /// Powers of sin x, summed from the last: all of them are live in the order of the trace.
    #[test]
    fn an_order_holds_each_operation_once_and_after_what_it_reads() {
        let mut graph = Graph::new(Precision::Double);
        let x = graph.push(Operation::Input { argument: 0, index: 0 });
        let (sine, cosine) = graph.sine_cosine(x);
        let mut power = graph.product(sine, cosine);
        let mut powers = vec![power];
        for _ in 0..3 * MAX_STEPS {
            power = graph.product(power, sine);
            powers.push(power);
        }
        let result = powers.iter().rev().fold(Operand::ZERO, |sum, &power| graph.sum(sum, power));
        let layout = Layout::straight(&graph, &Plan::new(&graph, &[vec![result]]));
        let mut done = vec![false; graph.nodes.len()];
        done[0] = true;
        for (number, part) in layout.parts.iter().enumerate() {
            let [Region::Straight(part)] = &part[..] else { panic!("one stretch a part") };
            assert!(part.len() <= MAX_STEPS + 2);
            for &node in part {
                for read in graph.nodes[node].reads() {
                    assert!(done[read], "{read} before {node}");
                    let is_here = layout.part_of[read] == number || graph.nodes[read].is_input();
                    assert!(is_here || layout.stored_at[read].is_some(), "{read} is read in part {number}");
                }
                assert!(!core::mem::replace(&mut done[node], true), "{node} twice");
            }
        }
        assert_eq!(layout.parts.len(), 7); // 12 000 operations and a sine
        assert!(done.iter().all(|&done| done) && layout.live >= 3 * MAX_STEPS);
    }

    /// Values whose live ranges overlap have different places.
    #[test]
    fn a_place_holds_one_value_at_a_time() {
        let parts = [vec![0, 1, 2], vec![3, 4], vec![5], vec![6]];
        let last_read = [1, 2, 0, 2, 3, 3, 3];
        let (stored_at, length) = assign_places(&parts, &last_read);
        // Arrays must not be empty.
        let length = if parts.len() > 1 { length.max(1) } else { 0 };
        assert_eq!(stored_at[2], None);
        let interval =
            |node: usize| (parts.iter().position(|part| part.contains(&node)).unwrap(), last_read[node]);
        for a in 0..6 {
            for b in a + 1..6 {
                if stored_at[a].is_some() && stored_at[a] == stored_at[b] {
                    assert!(interval(a).1 < interval(b).0, "{a} {b}");
                }
            }
        }
        assert_eq!(length, 4);
    }
}

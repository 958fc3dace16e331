//! Loops give the same bits as the operations one after the other.

use robot_dynamics_expression::{Arithmetic, Plan, Precision};
use robot_dynamics_number::SplitMix64;

use super::*;
use crate::Function;
use crate::body::every_number;
use crate::layout::Layout;
use crate::program::Program;
use crate::testing::chain;

/// An evaluation of a layout like that of compiled code: a value is available in its part and iteration, or
/// in the array.
struct Evaluation<'a> {
    graph: &'a Graph,
    layout: &'a Layout,
    results: &'a [Vec<Operand>],
    arguments: &'a [Vec<f64>],
    array: Vec<f64>,
    found: Vec<Vec<f64>>,
    /// The current part, and its values by operation.
    part: usize,
    values: Vec<f64>,
}

/// Evaluates a layout.
fn run(graph: &Graph, layout: &Layout, results: &[Vec<Operand>], arguments: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let array = vec![f64::NAN; layout.array_length];
    let found = results.iter().map(|result| vec![f64::NAN; result.len()]).collect();
    let values = Vec::new();
    let mut evaluation = Evaluation { graph, layout, results, arguments, array, found, part: 0, values };
    evaluation.store_constants();
    for (number, part) in layout.parts.iter().enumerate() {
        evaluation.part = number;
        evaluation.values = vec![f64::NAN; graph.nodes.len()];
        for region in part {
            match region {
                Region::Straight(nodes) => nodes.iter().for_each(|&node| evaluation.straight(node)),
                Region::Loop(rolled) => evaluation.rolled(rolled),
            }
        }
    }
    evaluation.found
}

impl Evaluation<'_> {
    /// Stores the results that are constants or inputs.
    fn store_constants(&mut self) {
        for (result, entries) in self.results.iter().enumerate() {
            for (index, &entry) in entries.iter().enumerate() {
                match entry.node() {
                    None => self.found[result][index] = entry.known().unwrap(),
                    Some(node) if self.graph.nodes[node].is_input() => {
                        self.found[result][index] = signed(entry, self.value(node));
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// A value outside the loop that computes it.
    fn value(&self, node: usize) -> f64 {
        if let Operation::Input { argument, index } = self.graph.nodes[node] {
            self.arguments[argument as usize][index as usize]
        } else if self.layout.part_of[node] == self.part && !self.layout.in_loop[node] {
            self.values[node]
        } else {
            self.array[self.layout.stored_at[node].expect("a value that is read elsewhere is stored")]
        }
    }

    fn operand(&self, operand: Operand) -> f64 {
        match operand.node() {
            None => operand.known().unwrap(),
            Some(node) => signed(operand, self.value(node)),
        }
    }

    /// Evaluates an operation of straight code.
    fn straight(&mut self, node: usize) {
        let operation = self.graph.nodes[node];
        let operands: Vec<f64> = operation.operands().map(|operand| self.operand(operand)).collect();
        let x = apply(operation, &operands);
        self.values[node] = x;
        if let Some(place) = self.layout.stored_at[node] {
            self.array[place] = x;
        }
        for (result, entries) in self.results.iter().enumerate() {
            for (index, entry) in entries.iter().enumerate() {
                if entry.node() == Some(node) {
                    self.found[result][index] = signed(*entry, x);
                }
            }
        }
    }

    /// Evaluates all iterations of a loop.
    fn rolled(&mut self, rolled: &Loop) {
        for &(place, node) in &rolled.copies {
            self.array[place] = self.value(node);
        }
        let mut carried: Vec<f64> = rolled.carried.iter().map(|one| self.value(one.first)).collect();
        for iteration in 0..rolled.iterations {
            let mut local = vec![f64::NAN; self.graph.nodes.len()];
            for step in &rolled.steps {
                self.step(step, iteration, &carried, &mut local);
            }
            for (variable, one) in carried.iter_mut().zip(&rolled.carried) {
                *variable = local[one.next];
            }
        }
    }

    /// Evaluates an operation of a loop; `local` has the values of the iteration.
    fn step(&mut self, step: &LoopStep, iteration: usize, carried: &[f64], local: &mut [f64]) {
        let operation = self.graph.nodes[step.node];
        let read = |(read, operand): (&LoopOperand, Operand)| {
            let x = match read {
                LoopOperand::Invariant(Operand::Constant(bits)) => return f64::from_bits(*bits),
                LoopOperand::ConstantTable(bits) => return f64::from_bits(bits[iteration]),
                LoopOperand::Invariant(other) => self.value(other.node().unwrap()),
                LoopOperand::Input { argument, index } => {
                    self.arguments[*argument][index.at_iteration(iteration)]
                }
                LoopOperand::SameIteration(node) => local[*node],
                LoopOperand::Carried(number) => carried[*number],
                LoopOperand::Array(index) => self.array[index.at_iteration(iteration)],
            };
            signed(operand, x)
        };
        let operands: Vec<f64> = step.reads.iter().zip(operation.operands()).map(read).collect();
        let x = apply(operation, &operands);
        local[step.node] = x;
        if let Some(index) = step.stored_at {
            self.array[index.at_iteration(iteration)] = x;
        }
        for store in &step.stores {
            let sign = if store.is_minus { -1.0 } else { 1.0 };
            self.found[store.result][store.index.at_iteration(iteration)] = sign * x;
        }
    }
}

fn signed(operand: Operand, x: f64) -> f64 {
    if matches!(operand, Operand::Minus(_)) { -x } else { x }
}

fn apply(operation: Operation, operands: &[f64]) -> f64 {
    match (operation, operands) {
        (Operation::Sum(..), [a, b]) => a + b,
        (Operation::Difference(..), [a, b]) => a - b,
        (Operation::Product(..), [a, b]) => a * b,
        (Operation::Quotient(..), [a, b]) => a / b,
        (Operation::Fused(..), [a, b, c]) => a.mul_add(*b, *c),
        (Operation::FusedMinus(..), [a, b, c]) => (-a).mul_add(*b, *c),
        (Operation::Root(_), [a]) => a.sqrt(),
        (Operation::Sign(_), [a]) => a.signum(),
        (Operation::SineCosine(_), [a]) => *a,
        (Operation::Sine(_), [a]) => a.sin(),
        (Operation::Cosine(_), [a]) => a.cos(),
        _ => unreachable!("an operation reads what it reads"),
    }
}

fn bits(rows: &[Vec<f64>]) -> Vec<Vec<u64>> {
    rows.iter().map(|row| row.iter().map(|x| x.to_bits()).collect()).collect()
}

/// Compares loops with the operations one after the other, for random numbers up to `most`, and returns the
/// number of loops.
fn compare(
    graph: &Graph,
    results: &[Vec<Operand>],
    lengths: &[usize],
    most: f64,
    random: &mut SplitMix64,
) -> usize {
    let straight = Layout::straight(graph, &Plan::new(graph, results));
    let Some(layout) = reroll(graph, results, &every_number) else { return 0 };
    assert!(!layout.parts.is_empty());
    for _ in 0..2 {
        let numbers = |&length: &usize| (0..length).map(|_| random.uniform(-most, most)).collect();
        let arguments: Vec<Vec<f64>> = lengths.iter().map(numbers).collect();
        let expected = run(graph, &straight, results, &arguments);
        assert!(expected.iter().flatten().all(|x| !x.is_nan()));
        assert_eq!(bits(&run(graph, &layout, results, &arguments)), bits(&expected));
    }
    layout.loops().count()
}

/// An operation of a body on numbers of its inputs, of the body before, of another recursion, and on
/// constants.
#[derive(Clone, Copy)]
struct Rule {
    kind: usize,
    operands: [usize; 3],
}

/// An outward recursion over bodies, and an inward one that uses its values. Rules are random and the same
/// for all bodies, in half of the cases except one body; constants may differ from body to body.
fn random_recursions(random: &mut SplitMix64, bodies: usize) -> (Graph, Vec<Vec<Operand>>) {
    let mut below = |n: usize| usize::try_from(random.next_u64() % n as u64).unwrap();
    let odd = if below(2) == 0 { bodies / 2 } else { bodies };
    let mut graph = Graph::new(Precision::Double);
    let (count, state) = (8 + below(30), 1 + below(4));
    let is_even = below(3) > 0;
    let mut results = vec![Vec::new(), Vec::new()];
    let mut outward: Vec<Vec<Operand>> = Vec::new();
    for (result, is_inward) in [false, true].into_iter().enumerate() {
        let rules: Vec<Rule> = (0..count)
            .map(|_| Rule { kind: below(8), operands: [below(1000), below(1000), below(1000)] })
            .collect();
        let mut before = vec![Operand::constant(0.5); state];
        for k in 0..bodies {
            let body = if is_inward { bodies - 1 - k } else { k };
            let first = graph.input(0, body);
            let mut values = vec![first, graph.input(1, 2 * body + 1), graph.input(2, 0)];
            values.push(Operand::constant(if is_even { 1.5 } else { 1.5 + body as f64 }));
            values.extend(&before);
            if is_inward {
                values.extend(&outward[body]);
            }
            for rule in &rules {
                let [a, b, c] = rule.operands.map(|operand| values[operand % values.len()]);
                let kind = if body == odd { rule.kind + 1 } else { rule.kind };
                let value = match kind {
                    0 => graph.sum(a, b),
                    1 => graph.sum(a, b.negated()),
                    // Factors are at most two.
                    2 => graph.product(values[rule.operands[0] % 3], b),
                    3 => graph.fused(values[rule.operands[0] % 3].negated(), b, c),
                    4 => graph.fused(values[rule.operands[0] % 3], b, c),
                    5 if a.known().is_none() => graph.sine_cosine(a).0,
                    6 => graph.sum(a.negated(), b),
                    _ => {
                        let square = graph.product(a, a);
                        let sum = graph.sum(square, Operand::constant(1.0));
                        let root = graph.root(sum);
                        graph.quotient(b, root)
                    }
                };
                values.push(value);
            }
            let mut bounded = |x: Operand| if x.known().is_none() { graph.sine_cosine(x).0 } else { x };
            before = values[values.len() - state..].iter().map(|&x| bounded(x)).collect();
            if !is_inward {
                outward.push(values[values.len() - 6..].to_vec());
            }
            results[result].push(values[values.len() - 1]);
            results[result].push(values[values.len() - 2].negated());
        }
    }
    (graph, results)
}

/// Random recursions, some with one different body or different constants.
#[test]
fn loops_of_random_recursions_change_no_bit() {
    let random = &mut SplitMix64::new(7);
    let mut with_loops = 0;
    for _ in 0..300 {
        let bodies = 10 + usize::try_from(random.next_u64() % 30).unwrap();
        let (graph, results) = random_recursions(random, bodies);
        let loops = compare(&graph, &results, &[bodies, 2 * bodies, 1], 2.0, random);
        with_loops += usize::from(loops > 0);
    }
    assert!(with_loops > 200, "{with_loops}");
}

/// Random graphs, whose few kinds of operations repeat by chance.
#[test]
fn loops_of_random_graphs_change_no_bit() {
    let random = &mut SplitMix64::new(3);
    for _ in 0..200 {
        let mut graph = Graph::new(Precision::Double);
        let mut values: Vec<Operand> = (0..40).map(|index| graph.input(0, index)).collect();
        let kinds = 1 + random.next_u64() % 2;
        for _ in 0..400 {
            let near = |random: &mut SplitMix64, values: &[Operand]| {
                let back = 1 + usize::try_from(random.next_u64() % 3).unwrap();
                values[values.len() - back]
            };
            let (a, b) = (near(random, &values), near(random, &values));
            values.push(if random.next_u64().is_multiple_of(kinds) {
                graph.sum(a, b)
            } else {
                graph.product(a, b)
            });
        }
        let results = vec![values.iter().rev().step_by(7).copied().collect::<Vec<_>>()];
        assert_eq!(values.len(), 440);
        compare(&graph, &results, &[40], 0.01, random);
    }
}

/// Chains of equal links, and of two groups with others between, for functions whose recursions go outward,
/// inward and both.
#[test]
fn loops_of_chains_change_no_bit_and_are_shorter() {
    let equal = chain(&[1.0; 16]);
    let groups = chain(&[[1.0; 9].as_slice(), &[0.3, 2.0], &[0.5; 9]].concat());
    let own = Arithmetic::default();
    let inverse = Function::InverseDynamics;
    // The function, and the largest ratio of lines with loops to lines without.
    for (function, most) in [
        (inverse.clone(), 0.25),
        (Function::ForwardDynamics, 0.3),
        (Function::Gravity, 0.35),
        (inverse.clone().derivatives(), 0.66),
        (inverse.pullback(), 0.3),
    ] {
        for (model, arithmetic) in [(&equal, own), (&equal, own.with_fused()), (&groups, own)] {
            let program = Program::new(&function, model, arithmetic, 1).unwrap();
            let (graph, results) = (&program.graph, &program.results);
            let lengths: Vec<usize> = program.arguments.iter().map(|argument| argument.length).collect();
            let loops = compare(graph, results, &lengths, 2.0, &mut SplitMix64::new(1));
            let layout = shortest_layout(graph, &program.plan, results, &every_number);
            let rate = layout.lines() as f64 / program.plan.steps() as f64;
            assert!(loops > 2 && rate < most, "{function}: {loops} loops, {rate}");
        }
    }
}

/// A function without operations has one part and no loop.
#[test]
fn nothing_has_no_loop() {
    let (graph, results) = (Graph::new(Precision::Double), vec![vec![Operand::ZERO; 7]]);
    assert!(reroll(&graph, &results, &every_number).is_none());
    let layout = shortest_layout(&graph, &Plan::new(&graph, &results), &results, &every_number);
    assert_eq!((layout.parts.len(), layout.array_length), (1, 0));
}

/// Segments cover the order without gaps, loops are whole, pairs stay with their halves, and parts are within
/// the limit.
#[test]
fn segments_cover_the_order() {
    for links in [16, 64] {
        let (model, function) = (chain(&vec![1.0; links]), Function::ForwardDynamics.pullback());
        let program = Program::new(&function, &model, Arithmetic::default(), 1).unwrap();
        let (graph, results) = (&program.graph, &program.results);
        let sequence = Sequence::new(graph, as_traced(graph, results), results, &every_number);
        let repetitions = sequence.repetitions();
        let segments = divide(&sequence, &repetitions);
        let (mut at, mut part) = (0, 0);
        let mut written = vec![0; segments[segments.len() - 1].part + 1];
        for segment in &segments {
            assert!(segment.start == at && segment.end > at && (part..=part + 1).contains(&segment.part));
            assert!(segment.part == part || !sequence.operation(at).is_half());
            (at, part) = (segment.end, segment.part);
            let length = segment.repetition.map_or(segment.end - segment.start, |number| {
                let Repetition { start, period, .. } = repetitions[number];
                assert_eq!((segment.start, segment.end), (start, repetitions[number].end()));
                period
            });
            written[part] += length;
        }
        assert_eq!(at, sequence.order.len());
        assert!(written.iter().all(|&count| count <= MAX_STEPS + 2), "{written:?}");
    }
}

/// An outward recursion and an inward one that reads its values: every kind of operand occurs.
#[test]
fn operands_of_loops_are_classified() {
    let mut graph = Graph::new(Precision::Double);
    let (factor, mut sum) = (graph.input(1, 0), graph.input(0, 0));
    let mut squares = Vec::new();
    for body in 1..40 {
        let input = graph.input(0, body);
        let scaled = graph.product(input, Operand::constant(1.0 + 0.5 * body as f64));
        sum = graph.sum(sum, scaled);
        squares.push(graph.product(sum, sum));
    }
    let mut back = factor;
    for &square in squares.iter().rev() {
        let product = graph.product(square, factor);
        back = graph.sum(back, product);
    }
    let layout = reroll(&graph, &[vec![back]], &every_number).unwrap();
    let loops: Vec<&Loop> = layout.loops().collect();
    let has = |number: usize, is: fn(&LoopOperand) -> bool| {
        loops[number].steps.iter().flat_map(|step| &step.reads).any(is)
    };
    assert_eq!(loops.len(), 2);
    assert!(has(0, |read| matches!(read, LoopOperand::ConstantTable(_))));
    assert!(has(0, |read| matches!(read, LoopOperand::Input { index: AffineIndex { step: 1, .. }, .. })));
    assert!(has(0, |read| matches!(read, LoopOperand::SameIteration(_))));
    assert!(has(0, |read| matches!(read, LoopOperand::Carried(0))) && loops[0].carried.len() == 1);
    assert!(has(1, |read| matches!(read, LoopOperand::Invariant(Operand::Plus(_)))));
    assert!(has(1, |read| matches!(read, LoopOperand::Array(AffineIndex { step: -1, .. }))));
}

//! What is written in loops gives what the operations give one after the other, bit for bit.

use expression::{Arithmetic, Plan, Precision};
use number::SplitMix64;

use super::*;
use crate::Function;
use crate::body::every_number;
use crate::layout::Layout;
use crate::program::Program;
use crate::testing::chain;

/// What a layout computes, read as a compiler would read the code: a value is known where it is written, in its part and its turn, or kept.
fn run(graph: &Graph, layout: &Layout, results: &[Vec<Operand>], arguments: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut w = vec![f64::NAN; layout.places];
    let mut found: Vec<Vec<f64>> = results.iter().map(|result| vec![f64::NAN; result.len()]).collect();
    for (result, entries) in results.iter().enumerate() {
        for (index, &entry) in entries.iter().enumerate() {
            match entry.node().map(|node| graph.nodes[node]) {
                None => found[result][index] = entry.known().unwrap(),
                Some(Operation::Input { argument, index: number }) => {
                    found[result][index] = signed(entry, arguments[argument as usize][number as usize]);
                }
                Some(_) => {}
            }
        }
    }
    for (number, part) in layout.parts.iter().enumerate() {
        let mut here = vec![f64::NAN; graph.nodes.len()];
        for piece in part {
            let value = |node: usize, here: &[f64], w: &[f64]| {
                if let Operation::Input { argument, index } = graph.nodes[node] {
                    arguments[argument as usize][index as usize]
                } else if layout.part_of[node] == number && !layout.in_loop[node] {
                    here[node]
                } else {
                    w[layout.kept[node].expect("what is read elsewhere is kept")]
                }
            };
            match piece {
                Piece::Straight(nodes) => {
                    for &node in nodes {
                        let read = |operand: Operand| match operand.node() {
                            None => operand.known().unwrap(),
                            Some(node) => signed(operand, value(node, &here, &w)),
                        };
                        let operands: Vec<f64> = graph.nodes[node].operands().map(read).collect();
                        here[node] = apply(graph.nodes[node], &operands);
                        if let Some(place) = layout.kept[node] {
                            w[place] = here[node];
                        }
                        for (result, entries) in results.iter().enumerate() {
                            for (index, entry) in entries.iter().enumerate() {
                                if entry.node() == Some(node) {
                                    found[result][index] = signed(*entry, here[node]);
                                }
                            }
                        }
                    }
                }
                Piece::Loop(one) => {
                    for &(place, node) in &one.copies {
                        w[place] = value(node, &here, &w);
                    }
                    let mut carried: Vec<f64> =
                        one.carried.iter().map(|one| value(one.first, &here, &w)).collect();
                    for turn in 0..one.turns {
                        let mut local = vec![f64::NAN; graph.nodes.len()];
                        for step in &one.steps {
                            let operation = graph.nodes[step.node];
                            let read = |(read, operand): (&Read, Operand)| {
                                let x = match read {
                                    Read::Same(Operand::Constant(bits)) => return f64::from_bits(*bits),
                                    Read::Constants(bits) => return f64::from_bits(bits[turn]),
                                    Read::Same(other) => value(other.node().unwrap(), &here, &w),
                                    Read::Input { argument, index } => {
                                        arguments[*argument][index.of_turn(turn)]
                                    }
                                    Read::Here(node) => local[*node],
                                    Read::Carried(number) => carried[*number],
                                    Read::Kept(index) => w[index.of_turn(turn)],
                                };
                                signed(operand, x)
                            };
                            let operands: Vec<f64> =
                                step.reads.iter().zip(operation.operands()).map(read).collect();
                            local[step.node] = apply(operation, &operands);
                            if let Some(index) = step.kept {
                                w[index.of_turn(turn)] = local[step.node];
                            }
                            for store in &step.stores {
                                let sign = if store.is_minus { -1.0 } else { 1.0 };
                                found[store.result][store.index.of_turn(turn)] = sign * local[step.node];
                            }
                        }
                        for (variable, one) in carried.iter_mut().zip(&one.carried) {
                            *variable = local[one.next];
                        }
                    }
                }
            }
        }
    }
    found
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

/// Holds loops to the operations one after the other, of random numbers up to `most`; how many loops there are.
fn compare(
    graph: &Graph,
    results: &[Vec<Operand>],
    lengths: &[usize],
    most: f64,
    random: &mut SplitMix64,
) -> usize {
    let straight = Layout::straight(graph, &Plan::new(graph, results));
    let Some(layout) = in_loops(graph, results, &every_number) else { return 0 };
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

/// What a body does: with numbers of this body's inputs, of the body before, of another recursion, and of constants.
#[derive(Clone, Copy)]
struct Rule {
    kind: usize,
    operands: [usize; 3],
}

/// A recursion over bodies, outward, and inward with what the outward one found. Rules are random, the same for all bodies but for
/// one, in half of the cases; constants may differ from body to body.
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
                    // By numbers that are at most two.
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

/// Random recursions, among them with a body that is another, and with constants that differ.
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

/// Graphs in which nothing follows a rule: the few operations are repeated by chance.
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

/// Of chains: equal links, two groups with others between, none alike; for functions whose recursions go outward, inward and both.
#[test]
fn loops_of_chains_change_no_bit_and_are_shorter() {
    let equal = chain(&[1.0; 16]);
    let groups = chain(&[[1.0; 9].as_slice(), &[0.3, 2.0], &[0.5; 9]].concat());
    let own = Arithmetic::default();
    let inverse = Function::InverseDynamics;
    // Lines with loops, of lines without.
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
            let layout = Layout::new(graph, &program.plan, results, &every_number);
            let rate = layout.lines() as f64 / program.plan.steps() as f64;
            assert!(loops > 2 && rate < most, "{function}: {loops} loops, {rate}");
        }
    }
}

/// A function that computes nothing has one part, and no loop.
#[test]
fn nothing_has_no_loop() {
    let (graph, results) = (Graph::new(Precision::Double), vec![vec![Operand::ZERO; 7]]);
    assert!(in_loops(&graph, &results, &every_number).is_none());
    let layout = Layout::new(&graph, &Plan::new(&graph, &results), &results, &every_number);
    assert_eq!((layout.parts.len(), layout.places), (1, 0));
}

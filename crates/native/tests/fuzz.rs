//! Random graphs: machine code has the same bits as the operations done one by one.

use robot_dynamics_expression::{
    Arithmetic, Graph, Operand, Operation, Plan, Precision, as_traced, interpret,
};
use robot_dynamics_native::{CompileError, Float, Kernel, Width, best_instructions};
use robot_dynamics_number::sine::{RANGE, SHORT_RANGE};
use robot_dynamics_number::{InstructionSet, SplitMix64};

/// The environment variable with the number of graphs.
const COUNT: &str = "NATIVE_FUZZ_GRAPHS";

/// A graph with results and the lengths of its arguments.
struct Case {
    arithmetic: Arithmetic,
    graph: Graph,
    results: Vec<Vec<Operand>>,
    lengths: Vec<usize>,
    /// Operands whose sines are computed.
    angles: Vec<Operand>,
}

struct Random(SplitMix64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        usize::try_from(self.0.next_u64() % limit as u64).unwrap()
    }

    fn chance(&mut self, one_in: usize) -> bool {
        self.below(one_in) == 0
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        self.0.uniform(from, to)
    }

    fn number(&mut self) -> f64 {
        match self.below(40) {
            0 => 0.0,
            1 => -0.0,
            2 => self.uniform(-1e6, 1e6),
            3 => self.uniform(-1e-300, 1e-300),
            _ => self.uniform(-3.0, 3.0),
        }
    }

    /// An operand among the nodes so far, a recent one where live ranges are short.
    fn operand(&mut self, graph: &Graph, nodes: &[u32], is_short: bool) -> Operand {
        if nodes.is_empty() || self.chance(8) {
            let x = if self.chance(3) { [0.5, 1.0, -2.0][self.below(3)] } else { self.number() };
            return graph.constant(x);
        }
        let reach = if is_short { nodes.len().min(6) } else { nodes.len() };
        let node = nodes[nodes.len() - 1 - self.below(reach)];
        if self.chance(6) { Operand::Minus(node) } else { Operand::Plus(node) }
    }

    fn case(&mut self, precision: Precision) -> Case {
        let mut arithmetic = Arithmetic::new(precision);
        if self.chance(2) {
            arithmetic = arithmetic.with_fused();
        }
        let mut graph = Graph::new(precision);
        let is_short = self.chance(2);
        let (lengths, mut nodes) = self.inputs(&mut graph, is_short);
        if self.chance(3) {
            // Sines of adjacent numbers of an argument.
            for input in nodes.clone() {
                if !self.chance(3) {
                    push_sine(&mut graph, &mut nodes, Operand::Plus(input));
                }
            }
        }
        self.operations(&mut graph, &mut nodes, is_short);
        let count = 1 + self.below(4);
        let results: Vec<Vec<Operand>> = (0..count).map(|_| self.result(&graph, &nodes, is_short)).collect();
        // Only angles of sines that the results depend on.
        let needed = graph.needed(results.iter().flatten().copied());
        let angles = (graph.nodes.iter().zip(needed))
            .filter_map(|(&node, is_needed)| match node {
                Operation::SineCosine(angle) if is_needed => Some(angle),
                _ => None,
            })
            .collect();
        Case { arithmetic, graph, results, lengths, angles }
    }

    /// Arguments: their lengths, and the nodes of most of their numbers.
    fn inputs(&mut self, graph: &mut Graph, is_short: bool) -> (Vec<usize>, Vec<u32>) {
        let arguments = 1 + self.below(5);
        let lengths: Vec<usize> = (0..arguments).map(|_| self.below(if is_short { 4 } else { 20 })).collect();
        let mut nodes = Vec::new();
        for (argument, &length) in lengths.iter().enumerate() {
            for index in 0..length {
                if !self.chance(8) {
                    nodes.push(node_of(graph.input(argument, index)));
                }
            }
        }
        (lengths, nodes)
    }

    /// Adds random operations on the nodes so far.
    fn operations(&mut self, graph: &mut Graph, nodes: &mut Vec<u32>, is_short: bool) {
        let most = [5, 30, 120, 400][self.below(4)];
        let end = graph.nodes.len() + 1 + self.below(most);
        while graph.nodes.len() < end {
            let mut read = || self.operand(graph, nodes, is_short);
            let [a, b, c] = [read(), read(), read()];
            let operation = match self.below(20) {
                0..4 => Operation::Sum(a, b),
                4..7 => Operation::Difference(a, b),
                7..11 => Operation::Product(a, b),
                11..14 => Operation::Fused(a, b, c),
                14..17 => Operation::FusedMinus(a, b, c),
                17 if self.chance(4) => Operation::Quotient(a, b),
                18 if self.chance(4) => Operation::Root(a),
                19 if self.chance(3) => Operation::Sign(a),
                19 if self.chance(3) => {
                    push_sine(graph, nodes, a);
                    continue;
                }
                _ => continue,
            };
            nodes.push(node_of(graph.push(operation)));
        }
    }

    fn result(&mut self, graph: &Graph, nodes: &[u32], is_short: bool) -> Vec<Operand> {
        let length = self.below(if is_short { 5 } else { 24 });
        let mut numbers: Vec<Operand> = (0..length).map(|_| self.operand(graph, nodes, is_short)).collect();
        if self.chance(2) {
            // Adjacent equal constants, like the zeros of a matrix.
            let (begin, end) = (self.below(length + 1), self.below(length + 1));
            numbers[begin.min(end)..begin.max(end)].fill(graph.constant([0.0, -2.5][self.below(2)]));
        }
        numbers
    }
}

fn node_of(operand: Operand) -> u32 {
    u32::try_from(operand.node().unwrap()).unwrap()
}

/// Adds sine and cosine of an angle, which may be a constant.
fn push_sine(graph: &mut Graph, nodes: &mut Vec<u32>, angle: Operand) {
    let pair = graph.push(Operation::SineCosine(angle));
    for half in [Operation::Sine(pair), Operation::Cosine(pair)] {
        nodes.push(node_of(graph.push(half)));
    }
}

/// Numbers followed by guard numbers, which no kernel may change.
struct Guarded<T> {
    numbers: Vec<T>,
    length: usize,
}

const GUARD: usize = 64;

impl<T: Float> Guarded<T> {
    fn new(length: usize) -> Self {
        Self { numbers: vec![T::nearest(-77.25); length + GUARD], length }
    }

    fn slice(&mut self) -> &mut [T] {
        &mut self.numbers[..self.length]
    }

    fn check(&self) {
        let behind = &self.numbers[self.length..];
        assert!(behind.iter().all(|&x| x == T::nearest(-77.25)), "numbers behind a slice were changed");
    }
}

fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// The results of some rows, and the rows with an angle out of range.
fn run<T: Float>(
    kernel: &Kernel<T>,
    case: &Case,
    rows: usize,
    inputs: &[Vec<T>],
) -> (Vec<Vec<T>>, Vec<usize>) {
    let mut outputs: Vec<Guarded<T>> =
        case.results.iter().map(|result| Guarded::new(rows * result.len())).collect();
    let mut scratch = Guarded::new(kernel.scratch_len());
    let mut far = Vec::new();
    {
        let inputs: Vec<&[T]> = inputs.iter().map(|input| &input[..]).collect();
        let mut outputs: Vec<&mut [T]> = outputs.iter_mut().map(Guarded::slice).collect();
        let is_finite = kernel.call_rows(rows, &inputs, &mut outputs, scratch.slice(), |row| far.push(row));
        let mut numbers = outputs.iter().flat_map(|output| output.iter());
        assert_eq!(is_finite, numbers.all(|&x| x.into().is_finite()));
    }
    scratch.check();
    outputs.iter().for_each(Guarded::check);
    (outputs.into_iter().map(|output| output.numbers[..output.length].to_vec()).collect(), far)
}

/// Compares a row of all results with the graph.
fn compare_row<T: Float>(case: &Case, found: &[Vec<T>], row: usize, expected: &[Vec<f64>], what: &str) {
    for (result, (found, entries)) in found.iter().zip(&case.results).enumerate() {
        let found = &found[row * entries.len()..][..entries.len()];
        for (index, ((&x, &y), entry)) in found.iter().zip(&expected[result]).zip(entries).enumerate() {
            let x: f64 = x.into();
            assert!(
                is_same(x, y),
                "{what}: result {result}[{index}], {entry:?} is {x:e}, not {y:e}: {:?}",
                entry.node().map(|node| case.graph.nodes[node])
            );
        }
    }
}

/// Compares all results of two kernels.
fn compare_kernels<T: Float>(
    case: &Case,
    found: &[Vec<T>],
    expected: &[Vec<T>],
    what: &dyn Fn(usize) -> String,
) {
    for (result, (found, expected)) in found.iter().zip(expected).enumerate() {
        for (index, (&x, &y)) in found.iter().zip(expected).enumerate() {
            assert!(
                is_same(x.into(), y.into()),
                "{}: result {result}, number {index} is {x:?}, not {y:?}",
                what(index / case.results[result].len())
            );
        }
    }
}

/// Compares one graph on every instruction set of this machine, for one state and for several at once.
fn check<T: Float>(random: &mut Random, number: usize) {
    let case = random.case(T::PRECISION);
    let Case { arithmetic, graph, results, lengths, .. } = &case;
    let rows = 1 + random.below(40);
    let inputs: Vec<Vec<T>> = (lengths.iter())
        .map(|length| (0..rows * length).map(|_| T::nearest(random.number())).collect())
        .collect();
    // The first rows are compared with the graph, the others with the first kernel.
    let plan = Plan { order: as_traced(graph, results), live: 0 };
    let with_angles: Vec<Vec<Operand>> = results.iter().cloned().chain([case.angles.clone()]).collect();
    let interpreted: Vec<Vec<Vec<f64>>> = (0..rows.min(2))
        .map(|row| {
            let arguments: Vec<Vec<f64>> = (inputs.iter().zip(lengths))
                .map(|(input, length)| input[row * length..][..*length].iter().map(|&x| x.into()).collect())
                .collect();
            interpret(graph, &plan, &with_angles, *arithmetic, &arguments).0
        })
        .collect();
    let range = if T::PRECISION == Precision::Double { RANGE } else { SHORT_RANGE };
    let mut first: Option<(Vec<Vec<T>>, Vec<usize>)> = None;
    for &instructions in InstructionSet::ALL {
        for width in [Width::One, Width::Lanes] {
            let kernel = match Kernel::<T>::compile(graph, results, lengths, *arithmetic, instructions, width)
            {
                Ok(kernel) => kernel,
                Err(CompileError::NoEncoder { .. } | CompileError::NotOnThisProcessor { .. }) => continue,
                Err(error) => panic!("graph {number}: {error}"),
            };
            let (found, far) = run(&kernel, &case, rows, &inputs);
            let what =
                |row: usize| format!("graph {number}, {instructions:?}, {width:?}, row {row} of {rows}");
            for (row, expected) in interpreted.iter().enumerate() {
                compare_row(&case, &found, row, expected, &what(row));
                let is_far = expected[results.len()].iter().any(|angle| angle.abs() >= range);
                assert_eq!(far.contains(&row), is_far, "{}: angles", what(row));
            }
            match &first {
                None => first = Some((found, far)),
                Some((expected, rows_far)) => {
                    assert_eq!(&far, rows_far, "{}", what(0));
                    compare_kernels(&case, &found, expected, &what);
                }
            }
        }
    }
    assert!(first.is_some() || best_instructions() == InstructionSet::Portable, "no kernel was run");
}

fn count() -> usize {
    std::env::var(COUNT).ok().and_then(|text| text.parse().ok()).unwrap_or(400)
}

#[test]
fn random_graphs_of_doubles_have_the_bits_of_the_graph() {
    let mut random = Random(SplitMix64::new(1));
    (0..count()).for_each(|number| check::<f64>(&mut random, number));
}

#[test]
fn random_graphs_of_singles_have_the_bits_of_the_graph() {
    let mut random = Random(SplitMix64::new(2));
    (0..count()).for_each(|number| check::<f32>(&mut random, number));
}

//! Instruction selection: from a graph to a list of operations that a machine has.

use std::collections::{HashMap, HashSet};

use robot_dynamics_expression::{Graph, Operand, Operation as Node, Precision};
use robot_dynamics_number::InstructionSet;

use crate::list::{Address, Base, Binary, List, LoadExtent, NONE, Operation, Value};
use crate::pool::Pool;
use crate::target::{Target, Width};

/// The state of instruction selection: a list and its constants.
pub(crate) struct Lowering<'a> {
    pub(crate) target: Target,
    pub(crate) list: List,
    pub(crate) pool: &'a mut Pool,
    /// The largest magnitude of an angle whose sine was taken.
    pub(crate) largest_angle: Option<Value>,
    constants: HashMap<(u64, bool), Value>,
}

/// A graph with its results, and the order of its operations.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) results: &'a [Vec<Operand>],
    pub(crate) order: &'a [usize],
}

/// Values that the vector prelude computes and stores.
#[derive(Debug, Default)]
pub(crate) struct PreludeValues {
    /// The locations of the sine and cosine of a pair, by the pair's node.
    pub(crate) sines: HashMap<usize, (Address, Address)>,
    /// Constants that are stored already, by result and index.
    pub(crate) constants: HashSet<(usize, usize)>,
}

/// A callback for each number of a result, with its position (result and index) and value.
pub(crate) type OnResult<'a> = dyn FnMut(&mut List, (usize, usize), Value) + 'a;

impl<'a> Lowering<'a> {
    pub(crate) fn new(target: Target, pool: &'a mut Pool) -> Self {
        Self { target, list: List::default(), pool, largest_angle: None, constants: HashMap::new() }
    }

    /// Bits of a number.
    pub(crate) fn number_bits(&self) -> u8 {
        match self.target.arithmetic.precision {
            Precision::Double => 64,
            Precision::Single => 32,
        }
    }

    pub(crate) fn sign_bit(&self) -> u64 {
        1 << (self.number_bits() - 1)
    }

    /// The bits of a number in the graph's precision.
    #[allow(clippy::cast_possible_truncation)] // constants of a graph in single precision are singles
    pub(crate) fn bits_of(&self, x: f64) -> u64 {
        match self.target.arithmetic.precision {
            Precision::Double => x.to_bits(),
            Precision::Single => u64::from((x as f32).to_bits()),
        }
    }

    /// A constant operand of arithmetic.
    pub(crate) fn constant(&mut self, x: f64) -> Value {
        let bits = self.bits_of(x);
        self.place_constant(bits, self.target.width == Width::Lanes)
    }

    /// A constant operand of bitwise operations, which work on whole registers.
    pub(crate) fn bits(&mut self, bits: u64) -> Value {
        self.place_constant(bits, true)
    }

    fn place_constant(&mut self, bits: u64, is_wide: bool) -> Value {
        if let Some(&value) = self.constants.get(&(bits, is_wide)) {
            return value;
        }
        let size = usize::from(self.number_bits() / 8);
        let (count, extent) = match (is_wide, self.target.width, self.target.instructions) {
            (false, ..) => (1, LoadExtent::Number),
            (true, Width::One, _) => (16 / size, LoadExtent::Register),
            (true, Width::Lanes, InstructionSet::Avx512) => (1, LoadExtent::Broadcast),
            (true, Width::Lanes, InstructionSet::Neon) => (16 / size, LoadExtent::Broadcast),
            (true, Width::Lanes, _) => (self.target.lanes(), LoadExtent::Register),
        };
        let home = self.pool.repeated(bits, size, count, extent);
        let value = self.list.value(Some(home));
        self.constants.insert((bits, is_wide), value);
        value
    }

    /// An operand with its sign.
    pub(crate) fn operand(&mut self, values: &[Value], operand: Operand) -> Value {
        match operand {
            Operand::Constant(bits) => self.constant(f64::from_bits(bits)),
            Operand::Plus(node) => values[node as usize],
            Operand::Minus(node) => self.negated(values[node as usize]),
        }
    }

    fn negated(&mut self, value: Value) -> Value {
        let sign = self.bits(self.sign_bit());
        self.list.binary(Binary::Xor, value, sign)
    }

    /// The value of an operation that is neither an input nor a part of a sine.
    pub(crate) fn operation(&mut self, values: &[Value], node: Node) -> Value {
        let mut read = |operand| self.operand(values, operand);
        match node {
            Node::Sum(a, b) => {
                let (a, b) = (read(a), read(b));
                self.list.binary(Binary::Add, a, b)
            }
            Node::Difference(a, b) => {
                let (a, b) = (read(a), read(b));
                self.list.binary(Binary::Subtract, a, b)
            }
            Node::Product(a, b) => {
                let (a, b) = (read(a), read(b));
                self.list.binary(Binary::Multiply, a, b)
            }
            Node::Quotient(a, b) => {
                let (a, b) = (read(a), read(b));
                self.list.binary(Binary::Divide, a, b)
            }
            Node::Fused(a, b, c) => {
                let fused = Operation::Fused { a: read(a), b: read(b), c: read(c), is_minus: false };
                self.list.push(fused)
            }
            Node::FusedMinus(a, b, c) => {
                let fused = Operation::Fused { a: read(a), b: read(b), c: read(c), is_minus: true };
                self.list.push(fused)
            }
            Node::Root(a) => {
                let root = Operation::Root(read(a));
                self.list.push(root)
            }
            Node::Sign(a) => {
                let x = read(a);
                self.sign(x)
            }
            Node::Input { .. } | Node::SineCosine(_) | Node::Sine(_) | Node::Cosine(_) => {
                unreachable!("inputs and sines are placed by the caller")
            }
        }
    }

    /// −1 or 1; 0 where x is ±0, and NaN where it is.
    fn sign(&mut self, x: Value) -> Value {
        let (sign, one) = (self.bits(self.sign_bit()), self.bits(self.bits_of(1.0)));
        let zero = self.bits(0);
        let unit = self.list.binary(Binary::And, x, sign);
        let unit = self.list.binary(Binary::Or, unit, one);
        let mask = self.list.binary(Binary::EqualOrUnordered, x, zero);
        // −0 + 0 = 0.
        let zero = self.constant(0.0);
        let zero_or_nan = self.list.binary(Binary::Add, x, zero);
        self.list.push(Operation::Blend { otherwise: unit, negative: zero_or_nan, mask })
    }

    /// Selects all operations of a graph. `input` returns the value of a number of an argument. `finished` is
    /// called with a result's position and value once it is computed.
    pub(crate) fn graph(
        &mut self,
        source: Source<'_>,
        input: &mut dyn FnMut(&mut List, usize, usize) -> Value,
        given: &PreludeValues,
        finished: &mut OnResult<'_>,
    ) {
        let Source { graph, results, order } = source;
        let mut values = vec![NONE; graph.nodes.len()];
        let stored = ResultPositions::new(graph.nodes.len(), results);
        for &(place, bits) in &stored.constants {
            if given.constants.contains(&place) {
                continue;
            }
            let value = self.constant(f64::from_bits(bits));
            finished(&mut self.list, place, value);
        }
        for (node, operation) in graph.nodes.iter().enumerate() {
            if let Node::Input { argument, index } = *operation {
                values[node] = input(&mut self.list, argument as usize, index as usize);
                self.finish(&stored, node, values[node], finished);
            }
        }
        let mut pairs: HashMap<usize, (Value, Value)> = HashMap::new();
        for &node in order {
            values[node] = match graph.nodes[node] {
                Node::SineCosine(angle) => {
                    let pair = if let Some(&(sine, cosine)) = given.sines.get(&node) {
                        (self.list.value(Some(sine)), self.list.value(Some(cosine)))
                    } else {
                        let angle = self.operand(&values, angle);
                        let magnitude = self.bits(self.sign_bit() - 1);
                        self.sine_and_cosine(angle, magnitude)
                    };
                    pairs.insert(node, pair);
                    continue;
                }
                Node::Sine(pair) => pairs[&pair.node().expect("a half reads a pair")].0,
                Node::Cosine(pair) => pairs[&pair.node().expect("a half reads a pair")].1,
                operation => self.operation(&values, operation),
            };
            self.finish(&stored, node, values[node], finished);
        }
    }

    /// Reports the results whose value is this node, with their signs.
    fn finish(&mut self, stored: &ResultPositions, node: usize, value: Value, finished: &mut OnResult<'_>) {
        let mut negative = None;
        for &(place, is_minus) in stored.of(node) {
            let value = if is_minus { *negative.get_or_insert_with(|| self.negated(value)) } else { value };
            finished(&mut self.list, place, value);
        }
    }

    /// The address of a number in a table of one state.
    pub(crate) fn number_at(table: usize, index: usize, size: i32) -> Address {
        let table = u8::try_from(table).expect("the number of tables was checked");
        let index = i32::try_from(index).expect("lengths were checked");
        Address::new(Base::Table(table), index * size, LoadExtent::Number)
    }
}

/// The positions in the results at which each node's value occurs.
struct ResultPositions {
    /// Result and index, and whether the value is negated, sorted by node.
    places: Vec<((usize, usize), bool)>,
    /// The first entry of each node in `places`.
    first: Vec<usize>,
    constants: Vec<((usize, usize), u64)>,
}

impl ResultPositions {
    fn new(nodes: usize, results: &[Vec<Operand>]) -> Self {
        let (mut first, mut constants) = (vec![0; nodes + 1], Vec::new());
        let entries = || {
            results.iter().enumerate().flat_map(|(result, entries)| {
                entries.iter().enumerate().map(move |(index, &operand)| ((result, index), operand))
            })
        };
        for (place, operand) in entries() {
            match operand {
                Operand::Constant(bits) => constants.push((place, bits)),
                Operand::Plus(node) | Operand::Minus(node) => first[node as usize + 1] += 1,
            }
        }
        for node in 0..nodes {
            first[node + 1] += first[node];
        }
        let (mut at, mut places) = (first.clone(), vec![((0, 0), false); first[nodes]]);
        for (place, operand) in entries() {
            if let Operand::Plus(node) | Operand::Minus(node) = operand {
                let at = &mut at[node as usize];
                places[*at] = (place, matches!(operand, Operand::Minus(_)));
                *at += 1;
            }
        }
        Self { places, first, constants }
    }

    fn of(&self, node: usize) -> &[((usize, usize), bool)] {
        &self.places[self.first[node]..self.first[node + 1]]
    }
}

//! An expression as a graph: each operation once, after its operands.

use std::collections::hash_map::Entry;

use crate::Precision;
use crate::hash::Map;

/// An operand of an operation: a constant, or another operation's value or its negative.
///
/// A sign costs nothing here: the next sum or difference absorbs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Operand {
    /// A constant, by its bits.
    Constant(u64),
    /// The value of an operation.
    Plus(u32),
    /// The negative of the value of an operation.
    Minus(u32),
}

impl Operand {
    /// The constant 0.
    pub const ZERO: Self = Self::constant(0.0);

    /// A constant, which must be representable in the graph's precision.
    pub const fn constant(x: f64) -> Self {
        Self::Constant(x.to_bits())
    }

    /// The value, if it is a constant.
    pub fn known(self) -> Option<f64> {
        match self {
            Self::Constant(bits) => Some(f64::from_bits(bits)),
            Self::Plus(_) | Self::Minus(_) => None,
        }
    }

    /// The operation whose value it is.
    pub fn node(self) -> Option<usize> {
        match self {
            Self::Constant(_) => None,
            Self::Plus(node) | Self::Minus(node) => Some(node as usize),
        }
    }

    /// Whether the operand has a minus sign, and the operand without it.
    pub fn split_sign(self) -> (bool, Self) {
        match self {
            Self::Constant(bits) => {
                let x = f64::from_bits(bits);
                if x.is_sign_negative() && !x.is_nan() { (true, Self::constant(-x)) } else { (false, self) }
            }
            Self::Plus(_) => (false, self),
            Self::Minus(node) => (true, Self::Plus(node)),
        }
    }

    /// The operand without its sign; a constant keeps its own.
    pub fn unsigned(self) -> Self {
        match self {
            Self::Minus(node) => Self::Plus(node),
            Self::Constant(_) | Self::Plus(_) => self,
        }
    }

    /// The operand with the other sign.
    pub fn negated(self) -> Self {
        match self {
            Self::Constant(bits) => Self::constant(-f64::from_bits(bits)),
            Self::Plus(node) => Self::Minus(node),
            Self::Minus(node) => Self::Plus(node),
        }
    }

    /// The operand with the other sign if `negative` is true.
    pub fn negated_if(self, negative: bool) -> Self {
        if negative { self.negated() } else { self }
    }
}

/// An operation on operands. Signs are outside wherever that changes no bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// A number of an argument.
    Input {
        /// The number of the argument.
        argument: u32,
        /// The index within the argument.
        index: u32,
    },
    /// a + b.
    Sum(Operand, Operand),
    /// a − b.
    Difference(Operand, Operand),
    /// a b.
    Product(Operand, Operand),
    /// a b + c, rounded once.
    Fused(Operand, Operand, Operand),
    /// c − a b, rounded once.
    FusedMinus(Operand, Operand, Operand),
    /// a / b.
    Quotient(Operand, Operand),
    /// √a.
    Root(Operand),
    /// −1, 0 or 1.
    Sign(Operand),
    /// Sine and cosine of a, as a pair; only the next two operations read it.
    SineCosine(Operand),
    /// The sine of a pair.
    Sine(Operand),
    /// The cosine of a pair.
    Cosine(Operand),
}

impl Operation {
    /// The operands.
    pub fn operands(&self) -> impl Iterator<Item = Operand> + use<> {
        let none = (None, None, None);
        let (a, b, c) = match *self {
            Self::Input { .. } => none,
            Self::Sum(a, b) | Self::Difference(a, b) | Self::Product(a, b) | Self::Quotient(a, b) => {
                (Some(a), Some(b), None)
            }
            Self::Fused(a, b, c) | Self::FusedMinus(a, b, c) => (Some(a), Some(b), Some(c)),
            Self::Root(a) | Self::Sign(a) | Self::SineCosine(a) | Self::Sine(a) | Self::Cosine(a) => {
                (Some(a), None, None)
            }
        };
        [a, b, c].into_iter().flatten()
    }

    /// The operations whose values it reads.
    pub fn reads(&self) -> impl Iterator<Item = usize> + use<> {
        self.operands().filter_map(Operand::node)
    }

    /// Whether the operation is an input.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Input { .. })
    }

    /// Whether the operation selects the sine or the cosine of a pair.
    pub fn is_half(&self) -> bool {
        matches!(self, Self::Sine(_) | Self::Cosine(_))
    }
}

/// Operations in topological order, without duplicates.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The precision that constants are rounded to.
    pub precision: Precision,
    /// The operations.
    pub nodes: Vec<Operation>,
    index: Map<Operation, u32>,
}

impl Graph {
    /// An empty graph.
    pub fn new(precision: Precision) -> Self {
        Self { precision, nodes: Vec::new(), index: Map::default() }
    }

    /// The value of an operation, which is added if the graph does not have it.
    ///
    /// # Panics
    /// Beyond 2³² operations.
    pub fn push(&mut self, operation: Operation) -> Operand {
        let next = u32::try_from(self.nodes.len()).expect("fewer than 2³² operations fit into memory");
        match self.index.entry(operation) {
            Entry::Occupied(there) => Operand::Plus(*there.get()),
            Entry::Vacant(free) => {
                free.insert(next);
                self.nodes.push(operation);
                Operand::Plus(next)
            }
        }
    }

    /// Number `index` of an argument.
    ///
    /// # Panics
    /// Beyond 2³² arguments or numbers of one.
    pub fn input(&mut self, argument: usize, index: usize) -> Operand {
        let small = |x: usize| u32::try_from(x).expect("fewer than 2³² numbers");
        self.push(Operation::Input { argument: small(argument), index: small(index) })
    }

    /// The value of an operation that the graph already has.
    pub fn find(&self, operation: Operation) -> Option<Operand> {
        self.index.get(&operation).map(|&node| Operand::Plus(node))
    }

    /// For each operation, whether the results depend on it.
    pub fn needed(&self, results: impl Iterator<Item = Operand>) -> Vec<bool> {
        let mut needed = vec![false; self.nodes.len()];
        for node in results.filter_map(Operand::node) {
            needed[node] = true;
        }
        for node in (0..needed.len()).rev() {
            if needed[node] {
                for read in self.nodes[node].reads() {
                    needed[read] = true;
                }
            }
        }
        needed
    }
}

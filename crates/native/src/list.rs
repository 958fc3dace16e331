//! A program as a list of operations on values, before it has registers.

/// A value of the list, by its number.
pub(crate) type Value = u32;

/// No value: the result of a store.
pub(crate) const NONE: Value = Value::MAX;

/// The pointer that an address starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Base {
    /// The constants behind the code.
    Constants,
    /// The caller's scratch memory.
    Scratch,
    /// An argument's or a result's numbers, by its place in the table of pointers.
    Table(u8),
}

/// How much can be read at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Extent {
    /// One number, for the lowest lane.
    Number,
    /// One number, for all lanes.
    Broadcast,
    /// A whole register.
    Register,
}

/// Where a value is in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Address {
    pub(crate) base: Base,
    /// Bytes from the base.
    pub(crate) offset: i32,
    pub(crate) extent: Extent,
}

impl Address {
    pub(crate) fn new(base: Base, offset: i32, extent: Extent) -> Self {
        Self { base, offset, extent }
    }
}

/// Operations of two values that each machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// The larger; the second where either is NaN.
    Maximum,
    And,
    Or,
    Xor,
    /// All bits set where both are equal or one is NaN, else none.
    EqualOrUnordered,
    /// In each 128 bits: pieces of so many bytes in turn from the lower halves of both.
    InterleaveLow(u8),
    /// From the upper halves.
    InterleaveHigh(u8),
    /// Blocks of 128 bits with even numbers, first all of one register, then of the other.
    EvenBlocks,
    /// Those with odd numbers.
    OddBlocks,
}

/// How much of an operand an operation reads, so that it can be in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reads {
    /// A number for each lane in use.
    Numbers,
    /// A whole register, also for one state.
    Bits,
    /// A whole register, whose numbers need not be what the instruction takes for one.
    Register,
}

impl Binary {
    pub(crate) fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply) || self.is_bitwise()
    }

    fn is_bitwise(self) -> bool {
        matches!(self, Self::And | Self::Or | Self::Xor)
    }

    /// How much of its operands it reads.
    pub(crate) fn reads(self) -> Reads {
        match self {
            Self::And | Self::Or | Self::Xor => Reads::Bits,
            Self::InterleaveLow(_) | Self::InterleaveHigh(_) | Self::EvenBlocks | Self::OddBlocks => {
                Reads::Register
            }
            _ => Reads::Numbers,
        }
    }
}

/// An operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    Binary(Binary, Value, Value),
    /// a b + c, or c − a b, rounded once.
    Fused {
        a: Value,
        b: Value,
        c: Value,
        is_minus: bool,
    },
    Root(Value),
    /// Bits of each lane shifted to the left.
    Shift(Value, u8),
    /// `negative` where the mask has its sign bit set, `otherwise` elsewhere.
    Blend {
        otherwise: Value,
        negative: Value,
        mask: Value,
    },
    Store(Value, Address),
}

impl Operation {
    /// The values that it reads, and how many.
    pub(crate) fn reads(&self) -> ([Value; 3], usize) {
        match *self {
            Self::Binary(_, a, b) => ([a, b, NONE], 2),
            Self::Fused { a, b, c, .. } => ([a, b, c], 3),
            Self::Blend { otherwise, negative, mask } => ([otherwise, negative, mask], 3),
            Self::Root(a) | Self::Shift(a, _) | Self::Store(a, _) => ([a, NONE, NONE], 1),
        }
    }
}

/// An operation and the value that it computes, [`NONE`] for a store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    pub(crate) operation: Operation,
    pub(crate) result: Value,
}

/// Operations in order, and where in memory each value is before they are done.
#[derive(Clone, Debug, Default)]
pub(crate) struct List {
    pub(crate) steps: Vec<Step>,
    pub(crate) homes: Vec<Option<Address>>,
}

impl List {
    /// A value that is in memory, or that an operation computes.
    pub(crate) fn value(&mut self, home: Option<Address>) -> Value {
        self.homes.push(home);
        Value::try_from(self.homes.len() - 1).expect("fewer than 2³² values fit into memory")
    }

    /// The value of an operation.
    pub(crate) fn push(&mut self, operation: Operation) -> Value {
        let result = self.value(None);
        self.steps.push(Step { operation, result });
        result
    }

    pub(crate) fn binary(&mut self, kind: Binary, a: Value, b: Value) -> Value {
        self.push(Operation::Binary(kind, a, b))
    }

    pub(crate) fn store(&mut self, value: Value, to: Address) {
        self.steps.push(Step { operation: Operation::Store(value, to), result: NONE });
    }

    /// Without operations whose values no store needs.
    pub(crate) fn swept(mut self) -> Self {
        let mut is_needed = vec![false; self.homes.len()];
        for step in self.steps.iter().rev() {
            if step.result == NONE || is_needed[step.result as usize] {
                let (reads, count) = step.operation.reads();
                reads[..count].iter().for_each(|&read| is_needed[read as usize] = true);
            }
        }
        self.steps.retain(|step| step.result == NONE || is_needed[step.result as usize]);
        self
    }
}

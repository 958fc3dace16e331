//! A program as a list of operations on values (virtual registers), before register allocation.

/// A value of the list, by its number.
pub(crate) type Value = u32;

/// The result of a store: no value.
pub(crate) const NONE: Value = Value::MAX;

/// The base pointer of an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Base {
    /// The constants behind the code.
    Constants,
    /// The caller's scratch memory.
    Scratch,
    /// The numbers of an argument or a result, by its index in the table of pointers.
    Table(u8),
}

/// The extent of memory that can be read at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LoadExtent {
    /// One number, for the lowest lane.
    Number,
    /// One number, for all lanes.
    Broadcast,
    /// A whole register.
    Register,
}

/// The location of a value in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Address {
    pub(crate) base: Base,
    /// Bytes from the base.
    pub(crate) offset: i32,
    pub(crate) extent: LoadExtent,
}

impl Address {
    pub(crate) fn new(base: Base, offset: i32, extent: LoadExtent) -> Self {
        Self { base, offset, extent }
    }
}

/// Operations of two values that every machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// The larger value; the second if either is NaN.
    Maximum,
    And,
    Or,
    Xor,
    /// All bits set where both are equal or one is NaN, all clear elsewhere.
    EqualOrUnordered,
    /// In each block of 128 bits: pieces of this many bytes alternately from the lower halves of both.
    InterleaveLow(u8),
    /// The same from the upper halves.
    InterleaveHigh(u8),
    /// The even-numbered blocks of 128 bits, first those of one register, then those of the other.
    EvenBlocks,
    /// The odd-numbered blocks.
    OddBlocks,
}

/// The part of an operand that an operation reads, which determines whether it can be in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OperandAccess {
    /// One number for each lane in use.
    Numbers,
    /// The bits of a whole register, also for one state.
    Bits,
    /// A whole register, whose element size may differ from that of the instruction.
    Register,
}

impl Binary {
    pub(crate) fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply) || self.is_bitwise()
    }

    fn is_bitwise(self) -> bool {
        matches!(self, Self::And | Self::Or | Self::Xor)
    }

    /// The part of its operands that it reads.
    pub(crate) fn reads(self) -> OperandAccess {
        match self {
            Self::And | Self::Or | Self::Xor => OperandAccess::Bits,
            Self::InterleaveLow(_) | Self::InterleaveHigh(_) | Self::EvenBlocks | Self::OddBlocks => {
                OperandAccess::Register
            }
            _ => OperandAccess::Numbers,
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
    /// The values that it reads, and their count.
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

/// Operations in order, and the location in memory of each value that is there from the start.
#[derive(Clone, Debug, Default)]
pub(crate) struct List {
    pub(crate) steps: Vec<Step>,
    pub(crate) homes: Vec<Option<Address>>,
}

impl List {
    /// A value in memory, or one that an operation computes.
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

    /// Removes dead code: operations whose values no store depends on.
    pub(crate) fn remove_dead_code(mut self) -> Self {
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

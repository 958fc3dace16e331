//! Instructions on registers, common to all machines.

use crate::list::{Address, Binary};

/// A vector register.
pub(crate) type Register = u8;

/// A register or memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    Register(Register),
    Memory(Address),
}

/// The operand of a fused multiply-add that is overwritten. `a` is in a register, `b` in a register or in memory; the product is subtracted
/// where the instruction says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// to = to b + a.
    Factor,
    /// to = a to + b.
    FactorAndMemoryAddend,
    /// to = a b + to.
    Addend,
}

/// An instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instruction {
    /// Loads a pointer of the table, where no register holds it all the time.
    Pointer(u8),
    Load {
        to: Register,
        from: Address,
    },
    Store {
        from: Register,
        to: Address,
    },
    Copy {
        to: Register,
        from: Register,
    },
    Binary {
        kind: Binary,
        to: Register,
        a: Register,
        b: Source,
    },
    Fused {
        form: Form,
        is_minus: bool,
        to: Register,
        a: Register,
        b: Source,
    },
    /// a b + c, or c − a b, where no operand is overwritten.
    FusedApart {
        is_minus: bool,
        to: Register,
        a: Register,
        b: Register,
        c: Register,
    },
    Root {
        to: Register,
        a: Source,
    },
    Shift {
        to: Register,
        a: Register,
        by: u8,
    },
    Blend {
        to: Register,
        otherwise: Register,
        negative: Source,
        mask: Register,
    },
}

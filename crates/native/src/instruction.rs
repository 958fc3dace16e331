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

/// The operand of a fused multiply-add that the result overwrites. `a` is in a register, `b` in a register or
/// in memory. The product is subtracted if `is_minus` is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FusedForm {
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
    /// Loads a pointer of the table that has no register of its own.
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
        form: FusedForm,
        is_minus: bool,
        to: Register,
        a: Register,
        b: Source,
    },
    /// a b + c, or c − a b, without overwriting an operand.
    FusedWithDestination {
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

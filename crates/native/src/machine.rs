//! Properties of a machine that the allocation of registers needs, and its counts.

use number::InstructionSet;

use crate::arm;
use crate::list::Extent;
use crate::target::{Target, Width};

/// The most registers that a machine has.
pub(crate) const MOST_REGISTERS: usize = 32;

/// Counts of what the allocation added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) spills: usize,
    pub(crate) loads: usize,
    pub(crate) copies: usize,
}

impl Counts {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            spills: self.spills + other.spills,
            loads: self.loads + other.loads,
            copies: self.copies + other.copies,
        }
    }
}

/// Properties of a machine that the allocation of registers needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Machine {
    pub(crate) registers: u8,
    /// Whether operands can be in memory, and each of three operands of a multiply-add be overwritten.
    pub(crate) has_memory_operands: bool,
    /// Whether a multiply-add overwrites none of its operands.
    pub(crate) has_fused_apart: bool,
    /// Whether one number in memory can be an operand for all lanes.
    pub(crate) has_broadcast: bool,
    /// Pointers of the table that have a register of their own.
    pub(crate) fixed_pointers: u8,
    /// Bytes of a spilled value, and how much of it can be read.
    pub(crate) slot_bytes: i32,
    pub(crate) slot_extent: Extent,
}

impl Machine {
    pub(crate) fn of(target: Target) -> Self {
        let (registers, has_memory_operands, fixed_pointers) = match (target.instructions, target.width) {
            (InstructionSet::Avx512, _) => (32, true, 5),
            // One register, or a pair, is kept for sequences of instructions.
            (InstructionSet::Neon, Width::One) => (31, false, arm::FIXED_POINTERS),
            (InstructionSet::Neon, Width::Lanes) => (15, false, arm::FIXED_POINTERS),
            _ => (16, true, 5),
        };
        Self {
            registers,
            has_memory_operands,
            has_fused_apart: target.instructions == InstructionSet::Neon && target.width == Width::One,
            has_broadcast: target.instructions == InstructionSet::Avx512,
            fixed_pointers,
            slot_bytes: target.value_bytes(),
            slot_extent: match target.width {
                Width::One => Extent::Number,
                Width::Lanes => Extent::Register,
            },
        }
    }
}

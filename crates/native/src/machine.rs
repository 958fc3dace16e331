//! Properties of a machine that register allocation needs, and its counts.

use robot_dynamics_number::InstructionSet;

use crate::arm;
use crate::list::LoadExtent;
use crate::target::{Target, Width};

/// The largest number of registers of any machine.
pub(crate) const MAX_REGISTERS: usize = 32;

/// Counts of the instructions that register allocation added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SpillCounts {
    pub(crate) spills: usize,
    pub(crate) loads: usize,
    pub(crate) copies: usize,
}

impl SpillCounts {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            spills: self.spills + other.spills,
            loads: self.loads + other.loads,
            copies: self.copies + other.copies,
        }
    }
}

/// Properties of a machine that register allocation needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Machine {
    pub(crate) registers: u8,
    /// Whether operands can be in memory, and a multiply-add can overwrite any of its three operands.
    pub(crate) has_memory_operands: bool,
    /// Whether a multiply-add has a separate destination register.
    pub(crate) has_fused_destination: bool,
    /// Whether a number in memory can be broadcast to all lanes as an operand.
    pub(crate) has_broadcast: bool,
    /// The number of pointers of the table with a register of their own.
    pub(crate) fixed_pointers: u8,
    /// Bytes of a spill slot, and the extent that can be read from it.
    pub(crate) slot_bytes: i32,
    pub(crate) slot_extent: LoadExtent,
}

impl Machine {
    pub(crate) fn of(target: Target) -> Self {
        let (registers, has_memory_operands, fixed_pointers) = match (target.instructions, target.width) {
            (InstructionSet::Avx512, _) => (32, true, 5),
            // One register, or a pair, is reserved for sequences of instructions.
            (InstructionSet::Neon, Width::One) => (31, false, arm::FIXED_POINTERS),
            (InstructionSet::Neon, Width::Lanes) => (15, false, arm::FIXED_POINTERS),
            _ => (16, true, 5),
        };
        Self {
            registers,
            has_memory_operands,
            has_fused_destination: target.instructions == InstructionSet::Neon && target.width == Width::One,
            has_broadcast: target.instructions == InstructionSet::Avx512,
            fixed_pointers,
            slot_bytes: target.value_bytes(),
            slot_extent: match target.width {
                Width::One => LoadExtent::Number,
                Width::Lanes => LoadExtent::Register,
            },
        }
    }
}

//! VEX and EVEX prefixes (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, sections
//! 2.3 and 2.7).

use super::encoder::{Encoder, Lanes};
use crate::instruction::Register;

/// An opcode and those fields of its prefix that do not depend on operands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opcode {
    pub(super) map: u8,
    pub(super) prefix: u8,
    pub(super) byte: u8,
    pub(super) vex_w: bool,
    pub(super) evex_w: bool,
    /// Whether one number is read from memory, not a whole register.
    pub(super) is_scalar: bool,
}

impl Opcode {
    /// The opcode without the W bit in the VEX encoding.
    pub(super) fn without_vex_w(self) -> Self {
        Self { vex_w: false, ..self }
    }
}

/// The last operand.
#[derive(Clone, Copy, Debug)]
pub(super) enum LastOperand {
    Register(Register),
    Memory {
        /// A general register.
        base: u8,
        offset: i32,
        /// Whether one number is read for all lanes.
        is_broadcast: bool,
    },
}

impl LastOperand {
    pub(super) fn without_broadcast(self) -> Self {
        match self {
            Self::Memory { base, offset, .. } => Self::Memory { base, offset, is_broadcast: false },
            Self::Register(_) => self,
        }
    }
}

impl Encoder {
    /// Encodes an instruction with a register, a second one (0 if it has none) and a last operand.
    pub(super) fn emit(&mut self, opcode: Opcode, register: Register, second: Register, place: LastOperand) {
        if self.is_evex(&[register, second], place) {
            self.emit_evex(opcode, register, second, place, 0);
        } else {
            self.emit_vex(opcode, register, second, place);
        }
    }

    /// Whether the instruction needs an EVEX prefix.
    pub(super) fn is_evex(&self, registers: &[Register], place: LastOperand) -> bool {
        if !self.has_evex {
            return false;
        }
        let is_high = |&register: &Register| register >= 16;
        let needs_it = match place {
            LastOperand::Register(register) => is_high(&register),
            LastOperand::Memory { is_broadcast, .. } => is_broadcast,
        };
        self.lanes == Lanes::All || needs_it || registers.iter().any(is_high)
    }

    pub(super) fn emit_vex(
        &mut self,
        opcode: Opcode,
        register: Register,
        second: Register,
        place: LastOperand,
    ) {
        let Opcode { map, prefix, byte, vex_w, .. } = opcode;
        let last = match place {
            LastOperand::Register(register) => register,
            LastOperand::Memory { base, .. } => base,
        };
        let low = (second ^ 15) << 3 | self.lanes.length() << 2 | prefix;
        if last < 8 && map == 1 && !vex_w {
            self.code.extend_from_slice(&[0xC5, inverted_bit(register, 3) << 7 | low, byte]);
        } else {
            let high = inverted_bit(register, 3) << 7 | 0x40 | inverted_bit(last, 3) << 5 | map;
            self.code.extend_from_slice(&[0xC4, high, u8::from(vex_w) << 7 | low, byte]);
        }
        self.operands(register, place, 1);
    }

    /// Encodes with an EVEX prefix; `mask` is the mask register, or 0 for none.
    pub(super) fn emit_evex(
        &mut self,
        opcode: Opcode,
        register: Register,
        second: Register,
        place: LastOperand,
        mask: u8,
    ) {
        let Opcode { map, prefix, byte, evex_w, is_scalar, .. } = opcode;
        let (last_high, last_middle, is_broadcast) = match place {
            LastOperand::Register(last) => (inverted_bit(last, 4), inverted_bit(last, 3), false),
            LastOperand::Memory { base, is_broadcast, .. } => (1, inverted_bit(base, 3), is_broadcast),
        };
        let first = inverted_bit(register, 3) << 7
            | last_high << 6
            | last_middle << 5
            | inverted_bit(register, 4) << 4
            | map;
        let middle = u8::from(evex_w) << 7 | (second & 15 ^ 15) << 3 | 0x4 | prefix;
        let last =
            self.lanes.length() << 5 | u8::from(is_broadcast) << 4 | inverted_bit(second, 4) << 3 | mask;
        self.code.extend_from_slice(&[0x62, first, middle, last, byte]);
        // One-byte displacements are scaled by the size of the memory operand.
        let step = if is_scalar || is_broadcast { self.number_bytes() } else { 16 << self.lanes.length() };
        self.operands(register, place, step);
    }

    /// The ModRM byte and the displacement: none, one byte scaled by `step`, or four bytes.
    fn operands(&mut self, register: Register, place: LastOperand, step: i32) {
        let field = (register & 7) << 3;
        match place {
            LastOperand::Register(last) => self.code.push(0xC0 | field | last & 7),
            LastOperand::Memory { base, offset, .. } => {
                let base = base & 7;
                debug_assert!(base != 4, "rsp and r12 are not bases");
                let short = if offset % step == 0 { i8::try_from(offset / step).ok() } else { None };
                match short {
                    // A base of rbp or r13 always has a displacement.
                    Some(0) if base != 5 => self.code.push(field | base),
                    Some(short) => self.code.extend_from_slice(&[0x40 | field | base, short.cast_unsigned()]),
                    None => {
                        self.code.push(0x80 | field | base);
                        self.code.extend_from_slice(&offset.to_le_bytes());
                    }
                }
            }
        }
    }
}

/// A bit of a register's number, inverted as in prefixes.
fn inverted_bit(register: Register, bit: u8) -> u8 {
    register >> bit & 1 ^ 1
}

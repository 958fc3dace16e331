//! Instructions of x86-64 in bytes: AVX2 and FMA by VEX, AVX-512 by EVEX prefixes.
//!
//! A function takes two pointers in `rdi` and `rsi` (the System V convention, on every system): the table of arguments and results, and
//! scratch memory. It changes `rax`, `rcx`, `rdx`, `rsi`, `r8` to `r11` and vector registers alone, all of which that convention lets it
//! change, and has no stack frame.

mod listing;
mod prefix;

pub(crate) use listing::assembly;

use number::InstructionSet;

use crate::instruction::{Form, Instruction, Register, Source};
use crate::list::{Address, Base, Binary, Extent};
use crate::target::{Target, Width};
use prefix::{Opcode, Place};

/// Pointers to constants and scratch memory are this many bytes further on, so that more of both is within one byte's reach.
const BIAS: i32 = 128;

const RAX: u8 = 0;
const RSI: u8 = 6;
const RDI: u8 = 7;
const R11: u8 = 11;
/// The registers of the first pointers of the table: `rdx`, `rcx`, `r8`, `r9`, `r10`.
const TABLE: [u8; 5] = [2, 1, 8, 9, 10];

/// How many lanes of a register instructions work on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lanes {
    Lowest,
    /// All of 256 bits.
    Half,
    /// All of 512 bits.
    All,
}

impl Lanes {
    fn of(target: Target) -> Self {
        match (target.width, target.instructions) {
            (Width::One, _) => Self::Lowest,
            (Width::Lanes, InstructionSet::Avx512) => Self::All,
            (Width::Lanes, _) => Self::Half,
        }
    }

    /// The length as prefixes have it.
    fn length(self) -> u8 {
        match self {
            Self::Lowest => 0,
            Self::Half => 1,
            Self::All => 2,
        }
    }
}

/// Instructions in bytes with the constants behind them, and how many bytes of these are instructions.
pub(crate) fn encoded(
    target: Target,
    parts: &[(Target, Vec<Instruction>)],
    tables: usize,
    constants: &[u8],
) -> (Vec<u8>, usize) {
    let mut encoder = Encoder::new(target, parts.iter().map(|part| part.1.len()).sum());
    encoder.begin(tables);
    for (target, instructions) in parts {
        encoder.instructions(Lanes::of(*target), instructions);
    }
    encoder.finish(constants)
}

/// Code that is being written.
#[derive(Clone, Debug)]
struct Encoder {
    code: Vec<u8>,
    lanes: Lanes,
    is_double: bool,
    has_evex: bool,
    /// Where the distance to the constants is written at the end.
    constants: usize,
    changes_upper_halves: bool,
}

impl Encoder {
    fn new(target: Target, steps: usize) -> Self {
        Self {
            code: Vec::with_capacity(8 * steps + 64),
            lanes: Lanes::Lowest,
            is_double: target.size() == 8,
            has_evex: target.instructions == InstructionSet::Avx512,
            constants: 0,
            changes_upper_halves: false,
        }
    }

    /// The beginning of the function: pointers into registers.
    fn begin(&mut self, tables: usize) {
        // lea rax, [rip + constants]
        self.code.extend_from_slice(&[0x48, 0x8D, 0x05, 0, 0, 0, 0]);
        self.constants = self.code.len();
        for (&register, number) in TABLE.iter().zip(0..tables) {
            self.pointer(register, number);
        }
        // sub rsi, -128
        self.code.extend_from_slice(&[0x48, 0x83, 0xEE, 0x80]);
    }

    /// mov register, [rdi + 8 number]
    fn pointer(&mut self, register: u8, number: usize) {
        let offset = i8::try_from(8 * number).expect("a table has at most 16 pointers");
        let modrm = 0x40 | (register & 7) << 3 | RDI;
        self.code.extend_from_slice(&[0x48 | (register >> 3) << 2, 0x8B, modrm, offset.cast_unsigned()]);
    }

    /// Instructions on so many lanes.
    fn instructions(&mut self, lanes: Lanes, instructions: &[Instruction]) {
        self.lanes = lanes;
        self.changes_upper_halves |= lanes != Lanes::Lowest;
        for &instruction in instructions {
            self.instruction(instruction);
        }
    }

    /// The whole code, with the constants behind it.
    fn finish(mut self, constants: &[u8]) -> (Vec<u8>, usize) {
        if self.changes_upper_halves {
            // vzeroupper
            self.code.extend_from_slice(&[0xC5, 0xF8, 0x77]);
        }
        // ret
        self.code.push(0xC3);
        let length = self.code.len();
        // int3 up to a cache line
        self.code.resize(length.next_multiple_of(64), 0xCC);
        let distance = i32::try_from(self.code.len() - self.constants).expect("the size was checked") + BIAS;
        self.code[self.constants - 4..self.constants].copy_from_slice(&distance.to_le_bytes());
        self.code.extend_from_slice(constants);
        (self.code, length)
    }

    fn instruction(&mut self, instruction: Instruction) {
        match instruction {
            Instruction::Pointer(number) => self.pointer(R11, usize::from(number)),
            Instruction::Load { to, from } if from.extent == Extent::Broadcast => {
                let opcode = Opcode { is_scalar: true, ..self.typed(2, 1, [0x19, 0x18]).of_vex_without_w() };
                self.put(opcode, to, 0, Self::place(Source::Memory(from)).without_broadcast());
            }
            Instruction::Load { to, from } => {
                let opcode = self.moved(0x10, from.extent);
                self.put(opcode, to, 0, Self::place(Source::Memory(from)));
            }
            Instruction::Store { from, to } => {
                let opcode = self.moved(0x11, to.extent);
                self.put(opcode, from, 0, Self::place(Source::Memory(to)));
            }
            Instruction::Copy { to, from } => self.put(self.packed(0x28), to, 0, Place::Register(from)),
            Instruction::Binary { kind: Binary::EqualOrUnordered, to, a, b } => self.compare(to, a, b),
            Instruction::Binary { kind: Binary::EvenBlocks, to, a, b } => self.blocks(to, a, b, [0x20, 0x88]),
            Instruction::Binary { kind: Binary::OddBlocks, to, a, b } => self.blocks(to, a, b, [0x31, 0xDD]),
            Instruction::Binary { kind, to, a, b } => {
                let opcode = match kind {
                    Binary::Add => self.arithmetic(0x58),
                    Binary::Multiply => self.arithmetic(0x59),
                    Binary::Subtract => self.arithmetic(0x5C),
                    Binary::Divide => self.arithmetic(0x5E),
                    Binary::Maximum => self.arithmetic(0x5F),
                    Binary::And => self.packed(0x54),
                    Binary::Or => self.packed(0x56),
                    Binary::Xor => self.packed(0x57),
                    Binary::InterleaveLow(bytes) => interleaved(0x14, bytes),
                    Binary::InterleaveHigh(bytes) => interleaved(0x15, bytes),
                    Binary::EqualOrUnordered | Binary::EvenBlocks | Binary::OddBlocks => {
                        unreachable!("matched above")
                    }
                };
                self.put(opcode, to, a, Self::place(b));
            }
            Instruction::Fused { form, is_minus, to, a, b } => {
                let row = match form {
                    Form::Factor => 0x90,
                    Form::FactorAndMemoryAddend => 0xA0,
                    Form::Addend => 0xB0,
                };
                let column = 0x8 + u8::from(self.lanes == Lanes::Lowest) + if is_minus { 0x4 } else { 0x0 };
                let opcode = Opcode {
                    map: 2,
                    prefix: 1,
                    byte: row | column,
                    vex_w: self.is_double,
                    evex_w: self.is_double,
                    is_scalar: self.lanes == Lanes::Lowest,
                };
                self.put(opcode, to, a, Self::place(b));
            }
            Instruction::FusedApart { .. } => unreachable!("multiply-adds overwrite an operand"),
            Instruction::Root { to, a } => {
                // One state's upper lanes come from the second register; its own avoids waiting for another.
                let upper = match (self.lanes, a) {
                    (Lanes::Lowest, Source::Register(a)) => a,
                    (Lanes::Lowest, Source::Memory(_)) => to,
                    _ => 0,
                };
                self.put(self.arithmetic(0x51), to, upper, Self::place(a));
            }
            Instruction::Shift { to, a, by } => {
                let opcode = self.typed(1, 1, [0x73, 0x72]).of_vex_without_w();
                // The register field extends the opcode; the result takes the place of the first operand.
                self.put(opcode, 6, to, Place::Register(a));
                self.code.push(by);
            }
            Instruction::Blend { to, otherwise, negative, mask } => {
                self.blend(to, otherwise, negative, mask);
            }
        }
    }

    fn compare(&mut self, to: Register, a: Register, b: Source) {
        /// Equal or unordered, quiet.
        const PREDICATE: u8 = 0x08;
        let b = Self::place(b);
        let opcode = self.arithmetic(0xC2);
        if self.is_evex(&[to, a], b) {
            // vcmp k1, a, b; vpmovm2q to, k1
            self.put_evex(opcode, 1, a, b, 0);
            self.code.push(PREDICATE);
            self.put_evex(self.typed(2, 2, [0x38, 0x38]), to, 0, Place::Register(1), 0);
        } else {
            self.put_vex(opcode, to, a, b);
            self.code.push(PREDICATE);
        }
    }

    /// Blocks of 128 bits in the order of an immediate, of 256 and of 512 bits.
    fn blocks(&mut self, to: Register, a: Register, b: Source, [half, all]: [u8; 2]) {
        let b = Self::place(b);
        if self.lanes == Lanes::All {
            // vshuff64x2
            self.put_evex(
                Opcode { map: 3, prefix: 1, byte: 0x23, vex_w: false, evex_w: true, is_scalar: false },
                to,
                a,
                b,
                0,
            );
            self.code.push(all);
        } else {
            // vperm2f128
            self.put_vex(
                Opcode { map: 3, prefix: 1, byte: 0x06, vex_w: false, evex_w: false, is_scalar: false },
                to,
                a,
                b,
            );
            self.code.push(half);
        }
    }

    fn blend(&mut self, to: Register, otherwise: Register, negative: Source, mask: Register) {
        let negative = Self::place(negative);
        if self.is_evex(&[to, otherwise, mask], negative) {
            // vpmovq2m k1, mask; vblendmpd to {k1}, otherwise, negative
            self.put_evex(self.typed(2, 2, [0x39, 0x39]), 1, 0, Place::Register(mask), 0);
            self.put_evex(self.typed(2, 1, [0x65, 0x65]), to, otherwise, negative, 1);
        } else {
            let opcode = Opcode {
                map: 3,
                prefix: 1,
                byte: if self.is_double { 0x4B } else { 0x4A },
                vex_w: false,
                evex_w: false,
                is_scalar: false,
            };
            self.put_vex(opcode, to, otherwise, negative);
            self.code.push(mask << 4);
        }
    }

    fn number_bytes(&self) -> i32 {
        if self.is_double { 8 } else { 4 }
    }

    /// An instruction on numbers of the lanes in use.
    fn arithmetic(&self, byte: u8) -> Opcode {
        let prefix = match (self.lanes, self.is_double) {
            (Lanes::Lowest, true) => 3,
            (Lanes::Lowest, false) => 2,
            (_, true) => 1,
            (_, false) => 0,
        };
        Opcode {
            map: 1,
            prefix,
            byte,
            vex_w: false,
            evex_w: self.is_double,
            is_scalar: self.lanes == Lanes::Lowest,
        }
    }

    /// An instruction on whole registers.
    fn packed(&self, byte: u8) -> Opcode {
        Opcode {
            map: 1,
            prefix: u8::from(self.is_double),
            byte,
            vex_w: false,
            evex_w: self.is_double,
            is_scalar: false,
        }
    }

    /// A load or store of one number or of a whole register.
    fn moved(&self, byte: u8, extent: Extent) -> Opcode {
        if extent == Extent::Register { self.packed(byte) } else { self.arithmetic(byte) }
    }

    /// An instruction with opcodes for doubles and singles.
    fn typed(&self, map: u8, prefix: u8, [double, single]: [u8; 2]) -> Opcode {
        let byte = if self.is_double { double } else { single };
        Opcode { map, prefix, byte, vex_w: self.is_double, evex_w: self.is_double, is_scalar: false }
    }

    /// An operand with the general register that its address starts from.
    fn place(source: Source) -> Place {
        match source {
            Source::Register(register) => Place::Register(register),
            Source::Memory(address) => {
                let (base, bias) = base(address);
                let is_broadcast = address.extent == Extent::Broadcast;
                Place::Memory { base, offset: address.offset - bias, is_broadcast }
            }
        }
    }
}

/// Pieces of two registers in turn.
fn interleaved(byte: u8, bytes: u8) -> Opcode {
    Opcode { map: 1, prefix: u8::from(bytes == 8), byte, vex_w: false, evex_w: bytes == 8, is_scalar: false }
}

/// The general register of an address's base, and how far on that is.
fn base(address: Address) -> (u8, i32) {
    match address.base {
        Base::Constants => (RAX, BIAS),
        Base::Scratch => (RSI, BIAS),
        Base::Table(number) => (TABLE.get(usize::from(number)).copied().unwrap_or(R11), 0),
    }
}

#[cfg(test)]
mod tests;

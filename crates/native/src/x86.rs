//! Encoding of x86-64 instructions: AVX2 and FMA with VEX prefixes, AVX-512 with EVEX prefixes.
//!
//! A function takes two pointers in `rdi` and `rsi` (the System V convention, on every system): the table of
//! arguments and results, and scratch memory. It changes only `rax`, `rcx`, `rdx`, `rsi`, `r8` to `r11` and
//! vector registers, all of which that convention leaves to the callee. It has no stack frame.

mod encoder;
mod listing;
mod prefix;

pub(crate) use listing::assembly;

use self::encoder::{Encoder, Lanes};
use self::prefix::{LastOperand, Opcode};

use crate::instruction::{FusedForm, Instruction, Register, Source};
use crate::list::{Address, Base, Binary, LoadExtent};
use crate::target::Target;

/// The offset of the pointers to constants and scratch memory, so that more of both is within the reach of a
/// one-byte displacement.
const BIAS: i32 = 128;

const RAX: u8 = 0;
const RSI: u8 = 6;
const RDI: u8 = 7;
const R11: u8 = 11;
/// The registers of the first pointers of the table: `rdx`, `rcx`, `r8`, `r9`, `r10`.
const TABLE: [u8; 5] = [2, 1, 8, 9, 10];

/// Encodes instructions, followed by their constants, and returns how many bytes are instructions.
pub(crate) fn encode(
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

impl Encoder {
    /// The prologue: loads pointers.
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

    /// Encodes instructions on these lanes.
    fn instructions(&mut self, lanes: Lanes, instructions: &[Instruction]) {
        self.lanes = lanes;
        self.changes_upper_halves |= lanes != Lanes::Lowest;
        for &instruction in instructions {
            self.instruction(instruction);
        }
    }

    /// Completes the code, followed by its constants.
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
            Instruction::Load { to, from } if from.extent == LoadExtent::Broadcast => {
                let opcode =
                    Opcode { is_scalar: true, ..self.opcode_by_type(2, 1, [0x19, 0x18]).without_vex_w() };
                self.emit(opcode, to, 0, Self::place(Source::Memory(from)).without_broadcast());
            }
            Instruction::Load { to, from } => {
                let opcode = self.move_opcode(0x10, from.extent);
                self.emit(opcode, to, 0, Self::place(Source::Memory(from)));
            }
            Instruction::Store { from, to } => {
                let opcode = self.move_opcode(0x11, to.extent);
                self.emit(opcode, from, 0, Self::place(Source::Memory(to)));
            }
            Instruction::Copy { to, from } => {
                self.emit(self.packed(0x28), to, 0, LastOperand::Register(from));
            }
            Instruction::Binary { kind: Binary::EqualOrUnordered, to, a, b } => self.compare(to, a, b),
            Instruction::Binary { kind: Binary::EvenBlocks, to, a, b } => self.blocks(to, a, b, [0x20, 0x88]),
            Instruction::Binary { kind: Binary::OddBlocks, to, a, b } => self.blocks(to, a, b, [0x31, 0xDD]),
            Instruction::Binary { kind, to, a, b } => {
                self.emit(self.binary_opcode(kind), to, a, Self::place(b));
            }
            Instruction::Fused { form, is_minus, to, a, b } => {
                self.emit(self.fused_opcode(form, is_minus), to, a, Self::place(b));
            }
            Instruction::FusedWithDestination { .. } => unreachable!("multiply-adds overwrite an operand"),
            Instruction::Root { to, a } => {
                // For one state, the upper lanes come from the second register. Using the source register
                // avoids a false dependency.
                let upper = match (self.lanes, a) {
                    (Lanes::Lowest, Source::Register(a)) => a,
                    (Lanes::Lowest, Source::Memory(_)) => to,
                    _ => 0,
                };
                self.emit(self.arithmetic(0x51), to, upper, Self::place(a));
            }
            Instruction::Shift { to, a, by } => {
                let opcode = self.opcode_by_type(1, 1, [0x73, 0x72]).without_vex_w();
                // The register field extends the opcode; the result is the second register.
                self.emit(opcode, 6, to, LastOperand::Register(a));
                self.code.push(by);
            }
            Instruction::Blend { to, otherwise, negative, mask } => {
                self.blend(to, otherwise, negative, mask);
            }
        }
    }

    /// The opcode of an operation of two values, except comparisons and permutations of blocks.
    fn binary_opcode(&self, kind: Binary) -> Opcode {
        match kind {
            Binary::Add => self.arithmetic(0x58),
            Binary::Multiply => self.arithmetic(0x59),
            Binary::Subtract => self.arithmetic(0x5C),
            Binary::Divide => self.arithmetic(0x5E),
            Binary::Maximum => self.arithmetic(0x5F),
            Binary::And => self.packed(0x54),
            Binary::Or => self.packed(0x56),
            Binary::Xor => self.packed(0x57),
            Binary::InterleaveLow(bytes) => interleave(0x14, bytes),
            Binary::InterleaveHigh(bytes) => interleave(0x15, bytes),
            Binary::EqualOrUnordered | Binary::EvenBlocks | Binary::OddBlocks => {
                unreachable!("these have several instructions or an immediate")
            }
        }
    }

    /// The opcode of a fused multiply-add.
    fn fused_opcode(&self, form: FusedForm, is_minus: bool) -> Opcode {
        let row = match form {
            FusedForm::Factor => 0x90,
            FusedForm::FactorAndMemoryAddend => 0xA0,
            FusedForm::Addend => 0xB0,
        };
        let column = 0x8 + u8::from(self.lanes == Lanes::Lowest) + if is_minus { 0x4 } else { 0x0 };
        Opcode {
            map: 2,
            prefix: 1,
            byte: row | column,
            vex_w: self.is_double,
            evex_w: self.is_double,
            is_scalar: self.lanes == Lanes::Lowest,
        }
    }

    fn compare(&mut self, to: Register, a: Register, b: Source) {
        /// Equal or unordered, quiet.
        const PREDICATE: u8 = 0x08;
        let b = Self::place(b);
        let opcode = self.arithmetic(0xC2);
        if self.is_evex(&[to, a], b) {
            // vcmp k1, a, b; vpmovm2q to, k1
            self.emit_evex(opcode, 1, a, b, 0);
            self.code.push(PREDICATE);
            self.emit_evex(self.opcode_by_type(2, 2, [0x38, 0x38]), to, 0, LastOperand::Register(1), 0);
        } else {
            self.emit_vex(opcode, to, a, b);
            self.code.push(PREDICATE);
        }
    }

    /// Permutes blocks of 128 bits by an immediate, for 256 and for 512 bits.
    fn blocks(&mut self, to: Register, a: Register, b: Source, [half, all]: [u8; 2]) {
        let b = Self::place(b);
        if self.lanes == Lanes::All {
            // vshuff64x2
            self.emit_evex(
                Opcode { map: 3, prefix: 1, byte: 0x23, vex_w: false, evex_w: true, is_scalar: false },
                to,
                a,
                b,
                0,
            );
            self.code.push(all);
        } else {
            // vperm2f128
            self.emit_vex(
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
            self.emit_evex(self.opcode_by_type(2, 2, [0x39, 0x39]), 1, 0, LastOperand::Register(mask), 0);
            self.emit_evex(self.opcode_by_type(2, 1, [0x65, 0x65]), to, otherwise, negative, 1);
        } else {
            let opcode = Opcode {
                map: 3,
                prefix: 1,
                byte: if self.is_double { 0x4B } else { 0x4A },
                vex_w: false,
                evex_w: false,
                is_scalar: false,
            };
            self.emit_vex(opcode, to, otherwise, negative);
            self.code.push(mask << 4);
        }
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
    fn move_opcode(&self, byte: u8, extent: LoadExtent) -> Opcode {
        if extent == LoadExtent::Register { self.packed(byte) } else { self.arithmetic(byte) }
    }

    /// An instruction with opcodes for doubles and singles.
    fn opcode_by_type(&self, map: u8, prefix: u8, [double, single]: [u8; 2]) -> Opcode {
        let byte = if self.is_double { double } else { single };
        Opcode { map, prefix, byte, vex_w: self.is_double, evex_w: self.is_double, is_scalar: false }
    }

    /// An operand, with the general register of its base if it is in memory.
    fn place(source: Source) -> LastOperand {
        match source {
            Source::Register(register) => LastOperand::Register(register),
            Source::Memory(address) => {
                let (base, bias) = base(address);
                let is_broadcast = address.extent == LoadExtent::Broadcast;
                LastOperand::Memory { base, offset: address.offset - bias, is_broadcast }
            }
        }
    }
}

/// Alternating pieces of two registers.
fn interleave(byte: u8, bytes: u8) -> Opcode {
    Opcode { map: 1, prefix: u8::from(bytes == 8), byte, vex_w: false, evex_w: bytes == 8, is_scalar: false }
}

/// The general register of an address's base, and its bias.
fn base(address: Address) -> (u8, i32) {
    match address.base {
        Base::Constants => (RAX, BIAS),
        Base::Scratch => (RSI, BIAS),
        Base::Table(number) => (TABLE.get(usize::from(number)).copied().unwrap_or(R11), 0),
    }
}

#[cfg(test)]
mod tests;

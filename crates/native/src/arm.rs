//! Encoding of 64-bit ARM instructions: NEON, with one state in the lowest lane of a register, or with states
//! in the lanes of two registers.
//!
//! A function takes two pointers in `x0` and `x1` (AAPCS64, the architecture's convention): the table of
//! arguments and results, and scratch memory. It changes `x2` to `x15`, `x17` and vector registers. The
//! convention preserves the lower halves of `v8` to `v15`: they are saved in the last 64 bytes of the scratch
//! memory. There is no stack frame.

mod writer;

use writer::{ADDRESS, General, Shape, Unit, Writer};

use crate::instruction::{FusedForm, Instruction, Register, Source};
use crate::list::{Address, Base, Binary, LoadExtent};
use crate::target::{Target, Width};

/// Bytes of scratch memory for the preserved registers.
pub(crate) const PRESERVED_BYTES: i32 = 64;

const TABLES: General = 0;
const SCRATCH: General = 1;
const CONSTANTS: General = 2;
/// The register of the first pointer of the table; the others follow.
const FIRST_POINTER: General = 3;
/// The number of pointers of the table with a register of their own.
pub(crate) const FIXED_POINTERS: u8 = 12;
/// The register that the other pointers share.
const OTHER_POINTER: General = 15;
/// A vector register that is not allocated to values.
const SPARE: Register = 31;

/// Encodes instructions, followed by their constants, and returns how many bytes are instructions. The
/// scratch memory for values ends at `scratch_end`.
pub(crate) fn encode(
    target: Target,
    parts: &[(Target, Vec<Instruction>)],
    tables: usize,
    scratch_end: i32,
    constants: &[u8],
) -> (Vec<u8>, usize) {
    let mut encoder = Encoder::new(target, scratch_end);
    encoder.program(parts, tables, 0);
    let mut code = encoder.writer.code;
    let length = code.len();
    code.resize(length.next_multiple_of(64), 0);
    let distance = u32::try_from(code.len()).expect("the size was checked");
    // The second and third instruction contain the halves of the distance.
    for (at, half) in [(4, distance & 0xFFFF), (8, distance >> 16)] {
        let word = u32::from_le_bytes(code[at..at + 4].try_into().expect("four bytes")) | half << 5;
        code[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    code.extend_from_slice(constants);
    (code, length)
}

/// All instructions as text, one a line. `distance` is the distance from the first instruction to the
/// constants.
pub(crate) fn assembly(
    target: Target,
    parts: &[(Target, Vec<Instruction>)],
    tables: usize,
    scratch_end: i32,
    distance: usize,
) -> String {
    let mut encoder = Encoder::new(target, scratch_end);
    encoder.writer.text = Some(String::new());
    encoder.program(parts, tables, u32::try_from(distance).expect("the size was checked"));
    encoder.writer.text.unwrap_or_default()
}

/// The state of the encoder.
#[derive(Clone, Debug)]
struct Encoder {
    writer: Writer,
    width: Width,
    is_double: bool,
    /// The offset of the preserved registers in scratch memory.
    preserved_at: u32,
}

impl Encoder {
    /// `scratch_end` is the end of the scratch memory for values.
    fn new(target: Target, scratch_end: i32) -> Self {
        let (is_double, preserved_at) = (target.size() == 8, offset(scratch_end));
        Self { writer: Writer::default(), width: target.width, is_double, preserved_at }
    }

    /// Encodes a whole program. The distance to the constants is known only afterwards.
    fn program(&mut self, parts: &[(Target, Vec<Instruction>)], tables: usize, distance: u32) {
        self.begin(tables, distance);
        for (target, instructions) in parts {
            self.width = target.width;
            for &instruction in instructions {
                self.instruction(instruction);
            }
        }
        self.move_preserved(true);
        self.writer.ret();
    }

    /// The prologue: saves registers and loads pointers.
    fn begin(&mut self, tables: usize, distance: u32) {
        self.writer.load_own_address(CONSTANTS);
        self.writer.constant(distance);
        self.writer.add(CONSTANTS, CONSTANTS);
        for number in 0..tables.min(usize::from(FIXED_POINTERS)) {
            let number = u32::try_from(number).expect("a few tables");
            self.writer.load_pointer(FIRST_POINTER + number, TABLES, number);
        }
        self.move_preserved(false);
    }

    fn move_preserved(&mut self, is_load: bool) {
        self.writer.address(SCRATCH, self.preserved_at);
        for pair in 0..4_u8 {
            self.writer.move_halves(is_load, 8 + 2 * pair, ADDRESS, 16 * u32::from(pair));
        }
    }

    fn instruction(&mut self, instruction: Instruction) {
        match instruction {
            Instruction::Pointer(number) => {
                self.writer.load_pointer(OTHER_POINTER, TABLES, number.into());
            }
            Instruction::Load { to, from } => self.load(to, from),
            Instruction::Store { from, to } => self.store(from, to),
            Instruction::Copy { to, from } => self.on_whole_registers("orr", 0x4EA0_1C00, &[to, from, from]),
            Instruction::Binary { kind, to, a, b } => self.binary(kind, to, a, register(b)),
            Instruction::Fused { form, is_minus, to, a, b } => {
                debug_assert!(form == FusedForm::Addend, "only the addend can be overwritten");
                let (name, word) = if is_minus { ("fmls", 0x4EA0_CC00) } else { ("fmla", 0x4E20_CC00) };
                self.on_lanes(name, word, &[to, a, register(b)]);
            }
            Instruction::FusedWithDestination { is_minus, to, a, b, c } => {
                let (name, word) = if is_minus { ("fmsub", 0x1F00_8000) } else { ("fmadd", 0x1F00_0000) };
                self.writer.registers(name, word | self.type_bit(), self.scalar(), &[to, a, b, c]);
            }
            Instruction::Root { to, a } => match self.width {
                Width::One => {
                    let word = 0x1E21_C000 | self.type_bit();
                    self.writer.registers("fsqrt", word, self.scalar(), &[to, register(a)]);
                }
                Width::Lanes => self.on_lanes("fsqrt", 0x6EA1_F800, &[to, register(a)]),
            },
            Instruction::Shift { to, a, by } => {
                let lane = if self.is_double { 64 } else { 32 };
                self.shift("shl", 0x4F00_5400 | (lane + u32::from(by)) << 16, [to, a], by);
            }
            Instruction::Blend { to, otherwise, negative, mask } => {
                self.blend(to, otherwise, register(negative), mask);
            }
        }
    }

    fn binary(&mut self, kind: Binary, to: Register, a: Register, b: Register) {
        let (name, scalar, vector) = match kind {
            Binary::Add => ("fadd", 0x1E20_2800, 0x4E20_D400),
            Binary::Subtract => ("fsub", 0x1E20_3800, 0x4EA0_D400),
            Binary::Multiply => ("fmul", 0x1E20_0800, 0x6E20_DC00),
            Binary::Divide => ("fdiv", 0x1E20_1800, 0x6E20_FC00),
            Binary::Maximum => ("fmaxnm", 0x1E20_6800, 0x4E20_C400),
            Binary::And => return self.on_whole_registers("and", 0x4E20_1C00, &[to, a, b]),
            Binary::Or => return self.on_whole_registers("orr", 0x4EA0_1C00, &[to, a, b]),
            Binary::Xor => return self.on_whole_registers("eor", 0x6E20_1C00, &[to, a, b]),
            Binary::EqualOrUnordered => return self.equal_or_unordered(to, a, b),
            Binary::InterleaveLow(bytes) => return self.interleave("zip1", 0x4E80_3800, bytes, [to, a, b]),
            Binary::InterleaveHigh(bytes) => return self.interleave("zip2", 0x4E80_7800, bytes, [to, a, b]),
            Binary::EvenBlocks => return self.blocks(to, [2 * a, 2 * b]),
            Binary::OddBlocks => return self.blocks(to, [2 * a + 1, 2 * b + 1]),
        };
        match self.width {
            Width::One => {
                let word = scalar | self.type_bit();
                self.writer.registers(name, word, self.scalar(), &[to, a, b]);
            }
            Width::Lanes => self.on_lanes(name, vector, &[to, a, b]),
        }
    }

    /// Computes not (a > b) and not (b > a).
    fn equal_or_unordered(&mut self, to: Register, a: Register, b: Register) {
        let (word, shape) = (0x6EA0_E400 | self.type_bit(), self.vector());
        for half in self.halves() {
            let [to, a, b] = [to, a, b].map(|value| self.half(value, half));
            self.writer.registers("fcmgt", word, shape, &[SPARE, a, b]);
            self.writer.registers("fcmgt", word, shape, &[to, b, a]);
            self.writer.registers("orr", 0x4EA0_1C00, Shape::Bytes, &[to, to, SPARE]);
            self.writer.registers("mvn", 0x6E20_5800, Shape::Bytes, &[to, to]);
        }
    }

    /// Extends the sign of the mask to all bits of each lane, then selects by bits.
    fn blend(&mut self, to: Register, otherwise: Register, negative: Register, mask: Register) {
        let (twice, by) = if self.is_double { (128, 63) } else { (64, 31) };
        let word = 0x4F00_0400 | (twice - u32::from(by)) << 16;
        let shape = self.vector();
        for half in self.halves() {
            let [to, otherwise, negative, mask] =
                [to, otherwise, negative, mask].map(|value| self.half(value, half));
            self.writer.shift("sshr", word, shape, [SPARE, mask], by);
            self.writer.registers("bsl", 0x6E60_1C00, Shape::Bytes, &[SPARE, negative, otherwise]);
            self.writer.registers("orr", 0x4EA0_1C00, Shape::Bytes, &[to, SPARE, SPARE]);
        }
    }

    fn interleave(&mut self, name: &str, word: u32, bytes: u8, operands: [Register; 3]) {
        let (of_size, shape) = if bytes == 8 { (0x40_0000, Shape::Doubles) } else { (0, Shape::Singles) };
        for half in self.halves() {
            let operands = operands.map(|value| self.half(value, half));
            self.writer.registers(name, word | of_size, shape, &operands);
        }
    }

    /// Moves two registers to the two registers of a value, which may overlap.
    fn blocks(&mut self, to: Register, [low, high]: [Register; 2]) {
        let mut copy = |to: Register, from: Register| {
            if to != from {
                self.writer.registers("orr", 0x4EA0_1C00, Shape::Bytes, &[to, from, from]);
            }
        };
        if high == 2 * to {
            copy(SPARE, high);
            copy(2 * to, low);
            copy(2 * to + 1, SPARE);
        } else {
            copy(2 * to, low);
            copy(2 * to + 1, high);
        }
    }

    fn shift(&mut self, name: &str, word: u32, operands: [Register; 2], by: u8) {
        let shape = self.vector();
        for half in self.halves() {
            let operands = operands.map(|value| self.half(value, half));
            self.writer.shift(name, word, shape, operands, by);
        }
    }

    /// An operation on lanes of numbers.
    fn on_lanes(&mut self, name: &str, word: u32, operands: &[Register]) {
        self.emit(name, word | self.type_bit(), self.vector(), operands);
    }

    /// An operation on whole registers.
    fn on_whole_registers(&mut self, name: &str, word: u32, operands: &[Register]) {
        self.emit(name, word, Shape::Bytes, operands);
    }

    fn emit(&mut self, name: &str, word: u32, shape: Shape, operands: &[Register]) {
        for half in self.halves() {
            let mut registers = [0; 4];
            for (register, &value) in registers.iter_mut().zip(operands) {
                *register = self.half(value, half);
            }
            self.writer.registers(name, word, shape, &registers[..operands.len()]);
        }
    }

    fn load(&mut self, to: Register, from: Address) {
        let (base, offset) = place(from);
        match (self.width, from.extent) {
            (Width::One, LoadExtent::Number) => self.writer.load(self.number(), to, base, offset),
            (Width::One, _) => self.writer.load(Unit::Quad, to, base, offset),
            (Width::Lanes, LoadExtent::Register) => self.writer.load_pair([2 * to, 2 * to + 1], base, offset),
            (Width::Lanes, _) => {
                self.writer.load(Unit::Quad, 2 * to, base, offset);
                self.writer.registers("orr", 0x4EA0_1C00, Shape::Bytes, &[2 * to + 1, 2 * to, 2 * to]);
            }
        }
    }

    fn store(&mut self, from: Register, to: Address) {
        let (base, offset) = place(to);
        match (self.width, to.extent) {
            (Width::One, LoadExtent::Number) => self.writer.store(self.number(), from, base, offset),
            (Width::One, _) => self.writer.store(Unit::Quad, from, base, offset),
            (Width::Lanes, _) => self.writer.store_pair([2 * from, 2 * from + 1], base, offset),
        }
    }

    /// The indices of the registers of one value.
    fn halves(&self) -> core::ops::Range<u8> {
        match self.width {
            Width::One => 0..1,
            Width::Lanes => 0..2,
        }
    }

    fn half(&self, value: Register, half: u8) -> Register {
        match self.width {
            Width::One => value,
            Width::Lanes => 2 * value + half,
        }
    }

    fn number(&self) -> Unit {
        if self.is_double { Unit::Double } else { Unit::Single }
    }

    fn scalar(&self) -> Shape {
        if self.is_double { Shape::Double } else { Shape::Single }
    }

    fn vector(&self) -> Shape {
        if self.is_double { Shape::Doubles } else { Shape::Singles }
    }

    /// The bit that distinguishes doubles from singles.
    fn type_bit(&self) -> u32 {
        if self.is_double { 1 << 22 } else { 0 }
    }
}

/// The general register of an address's base, and the offset.
fn place(address: Address) -> (General, u32) {
    let base = match address.base {
        Base::Constants => CONSTANTS,
        Base::Scratch => SCRATCH,
        Base::Table(number) if number < FIXED_POINTERS => FIRST_POINTER + u32::from(number),
        Base::Table(_) => OTHER_POINTER,
    };
    (base, offset(address.offset))
}

fn offset(bytes: i32) -> u32 {
    u32::try_from(bytes).expect("offsets are counted upwards")
}

/// The register of an operand, which is never in memory.
fn register(source: Source) -> Register {
    match source {
        Source::Register(register) => register,
        Source::Memory(_) => unreachable!("this machine has no operands in memory"),
    }
}

#[cfg(test)]
mod tests;

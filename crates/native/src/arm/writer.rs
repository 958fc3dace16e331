//! Words of 64-bit ARM instructions, and optionally their text (Arm Architecture Reference Manual for
//! A-profile, chapter C).

use std::fmt::Write;

use crate::instruction::Register;

/// A general register.
pub(super) type General = u32;

/// The register for addresses that do not fit into an instruction.
pub(super) const ADDRESS: General = 17;

/// The output: words, and optionally text.
#[derive(Clone, Debug, Default)]
pub(super) struct Writer {
    pub(super) code: Vec<u8>,
    /// The text, one instruction a line.
    pub(super) text: Option<String>,
}

/// The unit that a load or store moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Single,
    Double,
    Quad,
}

impl Unit {
    fn bytes(self) -> u32 {
        match self {
            Self::Single => 4,
            Self::Double => 8,
            Self::Quad => 16,
        }
    }

    fn letter(self) -> char {
        match self {
            Self::Single => 's',
            Self::Double => 'd',
            Self::Quad => 'q',
        }
    }

    /// The words of a load with an offset in units, and of one with an offset in bytes; for a store, bit 22
    /// is clear.
    fn load(self) -> [u32; 2] {
        match self {
            Self::Single => [0xBD40_0000, 0xBC40_0000],
            Self::Double => [0xFD40_0000, 0xFC40_0000],
            Self::Quad => [0x3DC0_0000, 0x3CC0_0000],
        }
    }
}

/// The arrangement of a register's lanes in assembly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// The lowest lane.
    Single,
    Double,
    /// All lanes.
    Singles,
    Doubles,
    Bytes,
}

impl Shape {
    fn register(self, number: Register) -> String {
        match self {
            Self::Single => format!("s{number}"),
            Self::Double => format!("d{number}"),
            Self::Singles => format!("v{number}.4s"),
            Self::Doubles => format!("v{number}.2d"),
            Self::Bytes => format!("v{number}.16b"),
        }
    }
}

impl Writer {
    fn put(&mut self, word: u32, text: impl FnOnce() -> String) {
        self.code.extend_from_slice(&word.to_le_bytes());
        if let Some(lines) = &mut self.text {
            lines.push_str(&text());
            lines.push('\n');
        }
    }

    /// An instruction with a result and up to three operands: the second register at bit 5, the third at bit
    /// 16, the fourth at bit 10.
    pub(super) fn registers(&mut self, name: &str, word: u32, shape: Shape, operands: &[Register]) {
        let places = [0, 5, 16, 10];
        let fields =
            operands.iter().zip(places).fold(0, |fields, (&number, at)| fields | u32::from(number) << at);
        self.put(word | fields, || {
            let operands: Vec<String> = operands.iter().map(|&number| shape.register(number)).collect();
            format!("{name} {}", operands.join(", "))
        });
    }

    /// A shift by a constant, which is part of the word together with the size of a lane.
    pub(super) fn shift(&mut self, name: &str, word: u32, shape: Shape, [to, a]: [Register; 2], by: u8) {
        let word = word | u32::from(a) << 5 | u32::from(to);
        self.put(word, || format!("{name} {}, {}, #{by}", shape.register(to), shape.register(a)));
    }

    pub(super) fn load(&mut self, piece: Unit, register: Register, base: General, offset: u32) {
        self.move_unit("ld", piece, register, base, offset);
    }

    pub(super) fn store(&mut self, piece: Unit, register: Register, base: General, offset: u32) {
        self.move_unit("st", piece, register, base, offset);
    }

    fn move_unit(&mut self, name: &str, piece: Unit, register: Register, base: General, offset: u32) {
        let kind = if name == "ld" { 0 } else { 1 << 22 };
        let [scaled, unscaled] = piece.load().map(|word| word ^ kind | u32::from(register));
        let (bytes, letter) = (piece.bytes(), piece.letter());
        if offset.is_multiple_of(bytes) && offset / bytes < 1 << 12 {
            let word = scaled | (offset / bytes) << 10 | base << 5;
            self.put(word, || format!("{name}r {letter}{register}, {}", memory(base, offset)));
        } else if offset < 1 << 8 {
            let word = unscaled | offset << 12 | base << 5;
            self.put(word, || format!("{name}ur {letter}{register}, {}", memory(base, offset)));
        } else {
            self.address(base, offset);
            self.move_unit(name, piece, register, ADDRESS, 0);
        }
    }

    /// Two registers, adjacent in memory.
    pub(super) fn load_pair(&mut self, registers: [Register; 2], base: General, offset: u32) {
        self.move_pair("ldp", 0xAD40_0000, registers, base, offset);
    }

    pub(super) fn store_pair(&mut self, registers: [Register; 2], base: General, offset: u32) {
        self.move_pair("stp", 0xAD00_0000, registers, base, offset);
    }

    fn move_pair(
        &mut self,
        name: &str,
        word: u32,
        [first, second]: [Register; 2],
        base: General,
        offset: u32,
    ) {
        if offset.is_multiple_of(16) && offset / 16 < 1 << 6 {
            let word = word | (offset / 16) << 15 | u32::from(second) << 10 | base << 5 | u32::from(first);
            self.put(word, || format!("{name} q{first}, q{second}, {}", memory(base, offset)));
        } else {
            self.address(base, offset);
            self.move_pair(name, word, [first, second], ADDRESS, 0);
        }
    }

    /// A pair of doubles, each the lower half of a register.
    pub(super) fn move_halves(&mut self, is_load: bool, first: Register, base: General, offset: u32) {
        let second = first + 1;
        let (name, word) = if is_load { ("ldp", 0x6D40_0000) } else { ("stp", 0x6D00_0000) };
        let word = word | (offset / 8) << 15 | u32::from(second) << 10 | base << 5 | u32::from(first);
        self.put(word, || format!("{name} d{first}, d{second}, {}", memory(base, offset)));
    }

    /// Computes the sum of a register and an offset in the address register.
    pub(super) fn address(&mut self, base: General, offset: u32) {
        if offset < 1 << 24 {
            let (low, high) = (offset & 0xFFF, offset >> 12);
            let mut from = base;
            if high > 0 {
                let word = 0x9140_0000 | high << 10 | from << 5 | ADDRESS;
                self.put(word, || format!("add x{ADDRESS}, x{from}, #{high}, lsl #12"));
                from = ADDRESS;
            }
            if low > 0 || high == 0 {
                let word = 0x9100_0000 | low << 10 | from << 5 | ADDRESS;
                self.put(word, || format!("add x{ADDRESS}, x{from}, #{low}"));
            }
        } else {
            self.constant(offset);
            self.add(ADDRESS, base);
        }
    }

    /// Loads a constant into the address register.
    pub(super) fn constant(&mut self, x: u32) {
        let (low, high) = (x & 0xFFFF, x >> 16);
        self.put(0xD280_0000 | low << 5 | ADDRESS, || format!("movz x{ADDRESS}, #{low}"));
        self.put(0xF2A0_0000 | high << 5 | ADDRESS, || format!("movk x{ADDRESS}, #{high}, lsl #16"));
    }

    /// Adds the address register to a register.
    pub(super) fn add(&mut self, to: General, a: General) {
        let word = 0x8B00_0000 | ADDRESS << 16 | a << 5 | to;
        self.put(word, || format!("add x{to}, x{a}, x{ADDRESS}"));
    }

    /// Loads the address of this instruction.
    pub(super) fn load_own_address(&mut self, to: General) {
        self.put(0x1000_0000 | to, || format!("adr x{to}, #0"));
    }

    pub(super) fn load_pointer(&mut self, to: General, base: General, number: u32) {
        let word = 0xF940_0000 | number << 10 | base << 5 | to;
        self.put(word, || format!("ldr x{to}, {}", memory(base, 8 * number)));
    }

    pub(super) fn ret(&mut self) {
        self.put(0xD65F_03C0, || "ret".into());
    }
}

/// An address as text.
fn memory(base: General, offset: u32) -> String {
    let mut text = format!("[x{base}");
    if offset > 0 {
        let _ = write!(text, ", #{offset}");
    }
    text + "]"
}

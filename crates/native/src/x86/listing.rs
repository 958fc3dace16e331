//! Instructions of x86-64 as text, in Intel's syntax.

use std::fmt::Write;

use super::{Lanes, R11, TABLE, base};
use crate::instruction::{FusedForm, Instruction, Register, Source};
use crate::list::{Address, Binary, LoadExtent};
use crate::target::Target;

/// Names of the general registers.
const GENERAL: [&str; 12] =
    ["rax", "rcx", "rdx", "rbx", "rsp", "rbp", "rsi", "rdi", "r8", "r9", "r10", "r11"];

/// All instructions, one a line. The label `constants` denotes the address of the constants.
pub(crate) fn assembly(parts: &[(Target, Vec<Instruction>)], tables: usize) -> String {
    let mut text = String::from("lea rax, [rip+constants+128]\n");
    for (&register, number) in TABLE.iter().zip(0..tables) {
        let _ = writeln!(text, "{}", pointer(register, number));
    }
    text += "sub rsi, -128\n";
    for (target, instructions) in parts {
        let lister = Lister { lanes: Lanes::of(*target), is_double: target.size() == 8 };
        for &instruction in instructions {
            text += &lister.lines(instruction);
            text.push('\n');
        }
    }
    if parts.iter().any(|(target, _)| Lanes::of(*target) != Lanes::Lowest) {
        text += "vzeroupper\n";
    }
    text + "ret\n"
}

fn pointer(register: u8, number: usize) -> String {
    format!("mov {}, [rdi+{}]", GENERAL[usize::from(register)], 8 * number).replace("+0]", "]")
}

struct Lister {
    lanes: Lanes,
    is_double: bool,
}

impl Lister {
    fn register(&self, number: Register) -> String {
        let kind = match self.lanes {
            Lanes::Lowest => "xmm",
            Lanes::Half => "ymm",
            Lanes::All => "zmm",
        };
        format!("{kind}{number}")
    }

    fn source(&self, source: Source) -> String {
        match source {
            Source::Register(number) => self.register(number),
            Source::Memory(address) if address.extent == LoadExtent::Broadcast => {
                format!("{}{{1to{}}}", memory(address), if self.is_double { 8 } else { 16 })
            }
            Source::Memory(address) => memory(address),
        }
    }

    /// The suffix of a mnemonic: scalar or packed, double or single.
    fn suffix(&self) -> &'static str {
        match (self.lanes, self.is_double) {
            (Lanes::Lowest, true) => "sd",
            (Lanes::Lowest, false) => "ss",
            (_, true) => "pd",
            (_, false) => "ps",
        }
    }

    fn packed(&self) -> &'static str {
        if self.is_double { "pd" } else { "ps" }
    }

    /// The suffix of a mnemonic for integers.
    fn whole(&self) -> char {
        if self.is_double { 'q' } else { 'd' }
    }

    /// Whether the instruction has no VEX encoding.
    fn is_evex(&self, registers: &[Register], source: Source) -> bool {
        let is_high = |&register: &Register| register >= 16;
        self.lanes == Lanes::All
            || registers.iter().any(is_high)
            || matches!(source, Source::Register(register) if register >= 16)
            || matches!(source, Source::Memory(Address { extent: LoadExtent::Broadcast, .. }))
    }

    fn lines(&self, instruction: Instruction) -> String {
        let (suffix, packed) = (self.suffix(), self.packed());
        match instruction {
            Instruction::Pointer(number) => pointer(R11, usize::from(number)),
            Instruction::Load { to, from } => {
                let mnemonic = match from.extent {
                    LoadExtent::Broadcast => format!("vbroadcasts{}", &packed[1..]),
                    LoadExtent::Register => format!("vmovu{packed}"),
                    LoadExtent::Number => format!("vmov{suffix}"),
                };
                format!("{mnemonic} {}, {}", self.register(to), memory(from))
            }
            Instruction::Store { from, to } => {
                let mnemonic = if to.extent == LoadExtent::Number {
                    format!("vmov{suffix}")
                } else {
                    format!("vmovu{packed}")
                };
                format!("{mnemonic} {}, {}", memory(to), self.register(from))
            }
            Instruction::Copy { to, from } => {
                format!("vmova{packed} {}, {}", self.register(to), self.register(from))
            }
            Instruction::Binary { kind, to, a, b } => self.binary(kind, to, a, b),
            Instruction::Fused { form, is_minus, to, a, b } => {
                let sign = if is_minus { "n" } else { "" };
                let order = match form {
                    FusedForm::Factor => 132,
                    FusedForm::FactorAndMemoryAddend => 213,
                    FusedForm::Addend => 231,
                };
                let [to, a, b] = [self.register(to), self.register(a), self.source(b)];
                format!("vf{sign}madd{order}{suffix} {to}, {a}, {b}")
            }
            Instruction::FusedWithDestination { .. } => unreachable!("multiply-adds overwrite an operand"),
            Instruction::Root { to, a } => self.root(to, a),
            Instruction::Shift { to, a, by } => {
                format!("vpsll{} {}, {}, {by}", self.whole(), self.register(to), self.register(a))
            }
            Instruction::Blend { to, otherwise, negative, mask } => self.blend(to, otherwise, negative, mask),
        }
    }

    fn root(&self, to: Register, a: Source) -> String {
        let (suffix, to, from) = (self.suffix(), self.register(to), self.source(a));
        match (self.lanes, a) {
            (Lanes::Lowest, Source::Register(_)) => format!("vsqrt{suffix} {to}, {from}, {from}"),
            (Lanes::Lowest, Source::Memory(_)) => format!("vsqrt{suffix} {to}, {to}, {from}"),
            _ => format!("vsqrt{suffix} {to}, {from}"),
        }
    }

    fn blend(&self, to: Register, otherwise: Register, negative: Source, mask: Register) -> String {
        let (packed, whole) = (self.packed(), self.whole());
        let [to_text, otherwise_text, mask_text] = [to, otherwise, mask].map(|number| self.register(number));
        let source = self.source(negative);
        if self.is_evex(&[to, otherwise, mask], negative) {
            format!(
                "vpmov{whole}2m k1, {mask_text}\nvblendm{packed} {to_text}{{k1}}, {otherwise_text}, {source}"
            )
        } else {
            format!("vblendv{packed} {to_text}, {otherwise_text}, {source}, {mask_text}")
        }
    }

    fn binary(&self, kind: Binary, to: Register, a: Register, b: Source) -> String {
        let (suffix, packed) = (self.suffix(), self.packed());
        let [to_text, a_text, b_text] = [self.register(to), self.register(a), self.source(b)];
        let operands = format!("{to_text}, {a_text}, {b_text}");
        let piece = |bytes| if bytes == 8 { "pd" } else { "ps" };
        match kind {
            Binary::Add => format!("vadd{suffix} {operands}"),
            Binary::Subtract => format!("vsub{suffix} {operands}"),
            Binary::Multiply => format!("vmul{suffix} {operands}"),
            Binary::Divide => format!("vdiv{suffix} {operands}"),
            Binary::Maximum => format!("vmax{suffix} {operands}"),
            Binary::And => format!("vand{packed} {operands}"),
            Binary::Or => format!("vor{packed} {operands}"),
            Binary::Xor => format!("vxor{packed} {operands}"),
            Binary::EqualOrUnordered if self.is_evex(&[to, a], b) => {
                let whole = self.whole();
                format!("vcmp{suffix} k1, {a_text}, {b_text}, 8\nvpmovm2{whole} {to_text}, k1")
            }
            Binary::EqualOrUnordered => format!("vcmp{suffix} {operands}, 8"),
            Binary::InterleaveLow(bytes) => format!("vunpckl{} {operands}", piece(bytes)),
            Binary::InterleaveHigh(bytes) => format!("vunpckh{} {operands}", piece(bytes)),
            Binary::EvenBlocks if self.lanes == Lanes::All => format!("vshuff64x2 {operands}, 136"),
            Binary::OddBlocks if self.lanes == Lanes::All => format!("vshuff64x2 {operands}, 221"),
            Binary::EvenBlocks => format!("vperm2f128 {operands}, 32"),
            Binary::OddBlocks => format!("vperm2f128 {operands}, 49"),
        }
    }
}

/// An address, with its offset in decimal.
fn memory(address: Address) -> String {
    let (register, bias) = base(address);
    let name = GENERAL[usize::from(register)];
    match address.offset - bias {
        0 => format!("[{name}]"),
        offset => format!("[{name}{offset:+}]"),
    }
}

//! `iced-x86` decodes the bytes of every instruction to the text of the listing and encodes them to the same
//! bytes.

use iced_x86::{
    Decoder, DecoderOptions, Encoder as Iced, Formatter, Instruction as Read, IntelFormatter,
    MemorySizeOptions, NumberBase,
};
use robot_dynamics_expression::{Arithmetic, Precision};
use robot_dynamics_number::InstructionSet;

use super::listing::assembly;
use super::{Encoder, Lanes};
use crate::instruction::{FusedForm, Instruction, Source};
use crate::list::{Address, Base, Binary, LoadExtent};
use crate::target::{Target, Width};

/// The operand of `lea` in the listing.
const CONSTANTS: &str = "constants+128";

/// The text of each instruction; compares the bytes that `iced-x86` encodes it to.
fn read(code: &[u8]) -> Vec<String> {
    let mut formatter = IntelFormatter::new();
    let options = formatter.options_mut();
    options.set_number_base(NumberBase::Decimal);
    options.set_memory_size_options(MemorySizeOptions::Never);
    options.set_space_after_operand_separator(true);
    options.set_rip_relative_addresses(true);
    options.set_use_pseudo_ops(false);
    let mut lines = Vec::new();
    for instruction in Decoder::with_ip(64, code, 0, DecoderOptions::NONE) {
        assert!(!instruction.is_invalid(), "invalid bytes at {:#x}", instruction.ip());
        let begin = usize::try_from(instruction.ip()).unwrap();
        let bytes = &code[begin..begin + instruction.len()];
        assert_eq!(encode(&instruction), bytes, "{}", formatted(&mut formatter, &instruction));
        // A sign-extended immediate of one byte.
        lines.push(formatted(&mut formatter, &instruction).replace("18446744073709551488", "-128"));
    }
    lines
}

fn formatted(formatter: &mut IntelFormatter, instruction: &Read) -> String {
    let mut text = String::new();
    formatter.format(instruction, &mut text);
    text
}

fn encode(instruction: &Read) -> Vec<u8> {
    let mut encoder = Iced::new(64);
    encoder.encode(instruction, instruction.ip()).unwrap();
    encoder.take_buffer()
}

/// Compares the encoder's bytes with the listing.
fn check(target: Target, instructions: &[Instruction]) {
    let mut encoder = Encoder::new(target, instructions.len());
    encoder.begin(7);
    encoder.instructions(Lanes::of(target), instructions);
    let (bytes, length) = encoder.finish(&[1, 2, 3, 4]);
    assert!(bytes.len().is_multiple_of(4) && bytes.ends_with(&[1, 2, 3, 4]) && (bytes.len() - 4) % 64 == 0);
    let read = read(&bytes[..length]);
    let listed = assembly(&[(target, instructions.to_vec())], 7);
    let mut listed = listed.lines();
    for (number, read) in read.iter().enumerate() {
        let listed = listed.next().expect("the listing has as many lines");
        if listed.contains(CONSTANTS) {
            // The constants follow the code, whose first instruction has seven bytes.
            assert_eq!(*read, format!("lea rax, [rip+{}]", bytes.len() - 4 - 7 + 128));
            continue;
        }
        assert_eq!(read, listed, "instruction {number} for {target:?}");
    }
    assert_eq!(listed.next(), None);
}

fn targets() -> Vec<Target> {
    let mut targets = Vec::new();
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512] {
        for width in [Width::One, Width::Lanes] {
            for precision in [Precision::Double, Precision::Single] {
                targets.push(Target { instructions, width, arithmetic: Arithmetic::new(precision) });
            }
        }
    }
    targets
}

/// Addresses with displacements of zero, one and four bytes, with and without EVEX's scaling.
fn addresses(target: Target, extent: LoadExtent) -> Vec<Address> {
    let offsets = [0, 8, 120, 128, 132, 136, 192, 256, 1144, 1152, 4096, 8256, 8320, 100_000];
    let bases =
        [Base::Constants, Base::Scratch, Base::Table(0), Base::Table(1), Base::Table(3), Base::Table(6)];
    let is_whole = |offset: &i32| offset % target.size() == 0;
    (bases.into_iter())
        .flat_map(|base| {
            offsets.iter().filter(|offset| is_whole(offset)).map(move |&offset| Address {
                base,
                offset,
                extent,
            })
        })
        .collect()
}

/// Registers that the encodings treat differently.
fn registers(target: Target) -> &'static [u8] {
    match target.instructions {
        InstructionSet::Avx512 => &[0, 3, 7, 8, 15, 16, 21, 31],
        _ => &[0, 3, 7, 8, 15],
    }
}

/// Memory operands for numbers of the lanes in use.
fn numbers_in_memory(target: Target) -> Vec<Source> {
    let extents: &[LoadExtent] = match (target.width, target.instructions) {
        (Width::One, _) => &[LoadExtent::Number, LoadExtent::Register],
        (_, InstructionSet::Avx512) => &[LoadExtent::Register, LoadExtent::Broadcast],
        _ => &[LoadExtent::Register],
    };
    extents.iter().flat_map(|&extent| addresses(target, extent)).map(Source::Memory).collect()
}

fn whole_in_memory(target: Target) -> Vec<Source> {
    let is_number =
        |source: &Source| matches!(source, Source::Memory(address) if address.extent == LoadExtent::Number);
    numbers_in_memory(target).into_iter().filter(|source| !is_number(source)).collect()
}

const BINARIES: [Binary; 9] = [
    Binary::Add,
    Binary::Subtract,
    Binary::Multiply,
    Binary::Divide,
    Binary::Maximum,
    Binary::And,
    Binary::Or,
    Binary::Xor,
    Binary::EqualOrUnordered,
];

#[test]
fn loads_stores_copies_and_shifts_are_those_of_another_encoder() {
    for target in targets() {
        let mut instructions = vec![Instruction::Pointer(5), Instruction::Pointer(15)];
        let extents: &[LoadExtent] = match (target.width, target.instructions) {
            (Width::One, _) => &[LoadExtent::Number, LoadExtent::Register],
            (_, InstructionSet::Avx512) => &[LoadExtent::Register, LoadExtent::Broadcast],
            _ => &[LoadExtent::Register],
        };
        for &register in registers(target) {
            for &extent in extents {
                for address in addresses(target, extent) {
                    instructions.push(Instruction::Load { to: register, from: address });
                    if extent != LoadExtent::Broadcast {
                        instructions.push(Instruction::Store { from: register, to: address });
                    }
                }
            }
            for &other in registers(target) {
                instructions.push(Instruction::Copy { to: register, from: other });
                let by = if target.size() == 8 { 63 } else { 30 };
                instructions.push(Instruction::Shift { to: register, a: other, by });
                instructions.push(Instruction::Root { to: register, a: Source::Register(other) });
            }
            let sources = numbers_in_memory(target);
            instructions.extend(sources.iter().map(|&a| Instruction::Root { to: register, a }));
        }
        check(target, &instructions);
    }
}

#[test]
fn operations_of_two_values_are_those_of_another_encoder() {
    for target in targets() {
        let mut instructions = Vec::new();
        let mut kinds = BINARIES.to_vec();
        if target.width == Width::Lanes {
            let bytes: &[u8] = if target.size() == 8 { &[8] } else { &[4, 8] };
            kinds.extend(
                bytes.iter().flat_map(|&bytes| [Binary::InterleaveLow(bytes), Binary::InterleaveHigh(bytes)]),
            );
            kinds.extend([Binary::EvenBlocks, Binary::OddBlocks]);
        }
        for kind in kinds {
            let in_memory = match kind.reads() {
                crate::list::OperandAccess::Numbers => numbers_in_memory(target),
                crate::list::OperandAccess::Bits => whole_in_memory(target),
                crate::list::OperandAccess::Register => {
                    addresses(target, LoadExtent::Register).into_iter().map(Source::Memory).collect()
                }
            };
            for &to in registers(target) {
                for &a in registers(target) {
                    let in_registers = registers(target).iter().map(|&b| Source::Register(b));
                    let sources = in_registers.chain(in_memory.iter().copied());
                    instructions.extend(sources.map(|b| Instruction::Binary { kind, to, a, b }));
                }
            }
        }
        check(target, &instructions);
    }
}

#[test]
fn operations_of_three_values_are_those_of_another_encoder() {
    for target in targets() {
        let mut instructions = Vec::new();
        for &to in registers(target) {
            for &a in registers(target) {
                let in_registers = || registers(target).iter().map(|&b| Source::Register(b));
                for form in [FusedForm::Factor, FusedForm::FactorAndMemoryAddend, FusedForm::Addend] {
                    for is_minus in [false, true] {
                        let sources = in_registers().chain(numbers_in_memory(target));
                        instructions.extend(sources.map(|b| Instruction::Fused { form, is_minus, to, a, b }));
                    }
                }
                for &mask in registers(target) {
                    let sources = in_registers().chain(whole_in_memory(target).into_iter().step_by(7));
                    instructions.extend(sources.map(|negative| Instruction::Blend {
                        to,
                        otherwise: a,
                        negative,
                        mask,
                    }));
                }
            }
        }
        check(target, &instructions);
    }
}

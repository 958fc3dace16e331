//! LLVM's assembler makes the same bytes from the listing of every instruction.

use std::io::Write;
use std::process::{Command, Stdio};

use robot_dynamics_expression::{Arithmetic, Precision};
use robot_dynamics_number::InstructionSet;

use super::{assembly, encode};
use crate::instruction::{FusedForm, Instruction, Source};
use crate::list::{Address, Base, Binary, LoadExtent};
use crate::target::{Target, Width};

/// LLVM's assembler, of Debian's package `llvm`.
const ASSEMBLER: &str = "llvm-mc";

/// The bytes of a listing, or `None` without an assembler.
fn assembled(text: String) -> Option<Vec<u8>> {
    let child = Command::new(ASSEMBLER)
        .args(["--triple=aarch64", "--show-encoding"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn();
    let Ok(mut child) = child else {
        println!("left out: {ASSEMBLER} is not installed");
        return None;
    };
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "{ASSEMBLER} refuses the listing");
    let output = String::from_utf8(output.stdout).unwrap();
    let encodings = output.lines().filter_map(|line| line.split("encoding: [").nth(1));
    let bytes = encodings.flat_map(|list| list.trim_end_matches(']').split(','));
    Some(bytes.map(|byte| u8::from_str_radix(byte.trim_start_matches("0x"), 16).unwrap()).collect())
}

fn check(target: Target, instructions: Vec<Instruction>) {
    let few = instructions[..2].to_vec();
    for (scratch_end, instructions) in [(64, instructions), (123_456, few.clone()), (1 << 25, few)] {
        let parts = [(target, instructions)];
        let (bytes, length) = encode(target, &parts, 16, scratch_end, &[1, 2, 3]);
        let text = assembly(target, &parts, 16, scratch_end, bytes.len() - 3);
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let Some(expected) = assembled(text) else { return };
        assert_eq!(length, expected.len(), "{target:?}");
        for (number, (found, expected)) in bytes.chunks(4).zip(expected.chunks(4)).enumerate() {
            assert_eq!(found, expected, "{}, {target:?}", lines[number]);
        }
    }
}

fn targets() -> Vec<Target> {
    let mut targets = Vec::new();
    for width in [Width::One, Width::Lanes] {
        for precision in [Precision::Double, Precision::Single] {
            let arithmetic = Arithmetic::new(precision);
            targets.push(Target { instructions: InstructionSet::Neon, width, arithmetic });
        }
    }
    targets
}

/// The first and last registers, and some between.
fn registers(target: Target) -> &'static [u8] {
    match target.width {
        Width::One => &[0, 7, 15, 16, 30],
        Width::Lanes => &[0, 3, 7, 8, 14],
    }
}

fn addresses(extent: LoadExtent) -> impl Iterator<Item = Address> {
    let offsets =
        [0, 4, 8, 16, 24, 248, 256, 260, 1008, 1016, 1024, 4096, 16_380, 16_384, 32_760, 32_768, 65_520];
    let offsets = offsets.into_iter().chain([65_536, 65_540, (1 << 24) - 8, 1 << 24, (1 << 27) + 40]);
    let bases = [Base::Constants, Base::Scratch, Base::Table(0), Base::Table(11), Base::Table(12)];
    offsets.flat_map(move |offset| bases.map(|base| Address { base, offset, extent }))
}

#[test]
fn loads_and_stores_are_those_of_llvm() {
    for target in targets() {
        let mut instructions = vec![Instruction::Pointer(12), Instruction::Pointer(15)];
        let extents = match target.width {
            Width::One => [LoadExtent::Number, LoadExtent::Register],
            Width::Lanes => [LoadExtent::Broadcast, LoadExtent::Register],
        };
        for &register in registers(target) {
            for address in extents.into_iter().flat_map(addresses) {
                instructions.push(Instruction::Load { to: register, from: address });
                if address.extent != LoadExtent::Broadcast {
                    instructions.push(Instruction::Store { from: register, to: address });
                }
            }
        }
        check(target, instructions);
    }
}

#[test]
fn operations_are_those_of_llvm() {
    for target in targets() {
        let mut instructions = Vec::new();
        let mut kinds = vec![
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
        if target.width == Width::Lanes {
            kinds.extend(
                [4, 8].into_iter().flat_map(|n| [Binary::InterleaveLow(n), Binary::InterleaveHigh(n)]),
            );
            kinds.extend([Binary::EvenBlocks, Binary::OddBlocks]);
        }
        let highest_shift = if target.size() == 8 { 63 } else { 31 };
        for &to in registers(target) {
            for &a in registers(target) {
                instructions.push(Instruction::Copy { to, from: a });
                instructions.push(Instruction::Root { to, a: Source::Register(a) });
                instructions.extend([0, 1, 30, highest_shift].map(|by| Instruction::Shift { to, a, by }));
                for &b in registers(target) {
                    let source = Source::Register(b);
                    instructions.extend(kinds.iter().map(|&kind| Instruction::Binary {
                        kind,
                        to,
                        a,
                        b: source,
                    }));
                    for is_minus in [false, true] {
                        match target.width {
                            Width::One => {
                                let apart =
                                    |&c: &u8| Instruction::FusedWithDestination { is_minus, to, a, b, c };
                                instructions.extend(registers(target).iter().map(apart));
                            }
                            Width::Lanes => {
                                let form = FusedForm::Addend;
                                instructions.push(Instruction::Fused { form, is_minus, to, a, b: source });
                            }
                        }
                    }
                    let mask = registers(target)[1];
                    instructions.push(Instruction::Blend { to, otherwise: a, negative: source, mask });
                }
            }
        }
        check(target, instructions);
    }
}

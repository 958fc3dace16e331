//! Changes of USD files: each file is read or refused, without a panic, in bounded time, and every robot that
//! is read compiles.
//!
//! Text is changed by its structure: lines and bodies are removed, copied and moved, and words exchanged.
//! Binary files are changed by bytes. By default 300 files of each kind are made from fixed seeds.
//! `MUTANTS=100000 cargo test -p robot-dynamics-usd --test mutants` makes that many.

use std::time::Instant;

use robot_dynamics_core::model::Model;
use robot_dynamics_number::SplitMix64;
use robot_dynamics_usd::{LoadOptions, parse_with_files};

const PARTS: &str = include_str!("../../../testdata/usd/parts.usda");
const ARM: &[u8] = include_bytes!("../../../testdata/usd/arm_xml.usdc");

const WORDS: [&str; 26] = [
    "0",
    "-1",
    "1e30",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "true",
    "None",
    "\"\"",
    "\"X\"",
    "()",
    "[]",
    "(0, 0, 0)",
    "(1, 0, 0, 0)",
    "</>",
    "</machine>",
    "</machine/arm>",
    "<../frame>",
    "</machine/turn>",
    "def",
    "over",
    "class",
    "references",
    "@./parts.usda@",
    "@@",
];

fn below(random: &mut SplitMix64, count: usize) -> usize {
    usize::try_from(random.next_u64() % count.max(1) as u64).expect("an index")
}

fn of_seed(seed: u64) -> SplitMix64 {
    SplitMix64::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
}

fn count() -> usize {
    std::env::var("MUTANTS").map_or(300, |count| count.parse().expect("a number"))
}

/// The line after the body that follows a line, or the next line.
fn end_of_part(lines: &[String], start: usize) -> usize {
    let is_open = |line: &str| line.trim_end().ends_with('{') || line.trim_end().ends_with('(');
    let is_header =
        lines[start].trim_start().starts_with("def ") || lines[start].trim_start().starts_with("class ");
    if !is_header {
        return start + 1;
    }
    let mut depth = 0_usize;
    for (at, line) in lines.iter().enumerate().skip(start) {
        if is_open(line) {
            depth += 1;
        } else if line.trim() == "}" || line.trim() == ")" {
            depth = depth.saturating_sub(1);
            if depth == 0 && line.trim() == "}" {
                return at + 1;
            }
        }
    }
    start + 1
}

fn changed(random: &mut SplitMix64) -> String {
    let mut lines: Vec<String> = PARTS.lines().map(str::to_owned).collect();
    for _ in 0..=below(random, 4) {
        let start = below(random, lines.len());
        let end = end_of_part(&lines, start);
        let part: Vec<String> = lines[start..end].to_vec();
        match below(random, 6) {
            0 => drop(lines.drain(start..end)),
            1 => {
                let at = below(random, lines.len());
                lines.splice(at..at, part);
            }
            2 => {
                lines.drain(start..end);
                let at = below(random, lines.len() + 1);
                lines.splice(at..at, part);
            }
            3 => {
                let other = below(random, lines.len());
                lines.swap(start, other);
            }
            _ => {
                let words: Vec<&str> = lines[start].split_whitespace().collect();
                if words.is_empty() {
                    continue;
                }
                let at = below(random, words.len());
                let own: Vec<&str> = PARTS.split_whitespace().collect();
                let new = if below(random, 2) == 0 {
                    WORDS[below(random, WORDS.len())]
                } else {
                    own[below(random, own.len())]
                };
                let words: Vec<&str> =
                    words.iter().enumerate().map(|(i, word)| if i == at { new } else { word }).collect();
                lines[start] = words.join(" ");
            }
        }
        if lines.is_empty() {
            break;
        }
    }
    lines.join("\n")
}

fn changed_bytes(random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = ARM.to_vec();
    for _ in 0..=below(random, 5) {
        let at = below(random, bytes.len());
        match below(random, 6) {
            0 => bytes[at] ^= 1 << below(random, 8),
            1 => bytes[at] = 0xff,
            2 => bytes[at] = 0,
            3 => {
                let (from, length) = (below(random, bytes.len()), 1 + below(random, 16));
                let chunk: Vec<u8> = bytes.iter().skip(from).take(length).copied().collect();
                for (place, byte) in bytes[at..].iter_mut().zip(chunk) {
                    *place = byte;
                }
            }
            4 => bytes[at] = u8::try_from(below(random, 256)).expect("a byte"),
            _ if below(random, 20) == 0 => bytes.truncate(at.max(8)),
            _ => bytes[at] = bytes[at].wrapping_add(1),
        }
    }
    bytes
}

/// Reads all files. Returns the number of those that are not refused.
fn read_all(name: &str, mut make: impl FnMut(&mut SplitMix64) -> Vec<u8>) -> usize {
    let first: u64 = std::env::var("SEED").map_or(0, |seed| seed.parse().expect("a number"));
    let (mut read, mut contained) = (0, 0);
    let mut slowest = (0.0, 0);
    for seed in first..first + count() as u64 {
        let content = make(&mut of_seed(seed));
        if let Ok(path) = std::env::var("WRITE") {
            std::fs::write(path, &content).expect("the file");
        }
        let start = Instant::now();
        let robot = parse_with_files(&content, name, [], &LoadOptions::default());
        read += usize::from(robot.is_ok());
        if let Ok(robot) = &robot {
            let compiled = Model::new(robot.description.clone());
            assert!(compiled.is_ok(), "{name}, seed {seed}: {:?}", compiled.err());
        }
        let time = start.elapsed().as_secs_f64();
        if time > slowest.0 {
            slowest = (time, seed);
        }
        // A panic of openusd is an error of the file.
        contained += usize::from(robot.is_err_and(|error| error.to_string().contains("the parser failed")));
    }
    println!("{name}: {read} of {} read, {contained} panics of openusd, the slowest in {slowest:?}", count());
    assert!(slowest.0 < 20.0, "{slowest:?}");
    read
}

/// openusd composes without end, or until its stack overflows, if a path does not lead to the root.
#[test]
fn names_and_paths_without_end_are_refused_at_once() {
    let names = ["a}", "", "."].map(|name| format!("#usda 1.0\ndef Xform \"{name}\" {{}}").into_bytes());
    let path = |arc: &str| format!("#usda 1.0\ndef \"a\" ({arc} = </b}}>) {{}}\ndef \"b\" {{}}").into_bytes();
    let paths = ["references", "inherits", "specializes"].map(path);
    // In this mutant the name of a property in a table ends with a brace.
    let binary = [changed_bytes(&mut of_seed(14_396))];
    for content in names.iter().chain(&paths).chain(&binary) {
        let start = Instant::now();
        let refused = parse_with_files(content, "robot.usd", [], &LoadOptions::default()).unwrap_err();
        assert!(refused.to_string().contains("is invalid"), "{refused}");
        assert!(start.elapsed().as_secs_f64() < 20.0);
    }
}

#[test]
fn changed_text_is_read_or_refused() {
    let read = read_all("parts.usda", |random| changed(random).into_bytes());
    assert!(read > 0 && read < count());
}

#[test]
fn changed_binary_is_read_or_refused() {
    let read = read_all("arm.usdc", changed_bytes);
    assert!(read > 0 && read < count());
}

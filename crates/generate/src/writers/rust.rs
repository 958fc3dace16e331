//! A Rust crate without the standard library, whose module can be included anywhere.

use std::fmt::Write;

use robot_dynamics_expression::{Arithmetic, Precision, Sine};

use super::context::Context;
use super::lanes;
use super::sine::sine_statements;
use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::generated_files::GeneratedFile;
use crate::heading::{self, about, commented, doc_text, lines};
use crate::layout::Layout;
use crate::program::Program;
use crate::syntax::{Helpers, Language, Syntax, mentions};

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    let name = context.name;
    vec![
        GeneratedFile::new("Cargo.toml", manifest(context)),
        GeneratedFile::new("src/lib.rs", root(context)),
        GeneratedFile::new(format!("src/{name}.rs"), module(context)),
        GeneratedFile::new("tests/golden.rs", test(context)),
    ]
}

fn syntax<'a>(context: &Context<'_>) -> Syntax<'a> {
    Syntax { language: Language::Rust, arithmetic: context.arithmetic(), prefix: "" }
}

fn first_line(context: &Context<'_>) -> String {
    heading::first_line(context.request)
}

fn manifest(context: &Context<'_>) -> String {
    let (rust_version, dependencies) = if context.request.lanes {
        let registers =
            format!("\n[dependencies]\nrobot-dynamics-number = \"={}\"\n", env!("CARGO_PKG_VERSION"));
        (env!("CARGO_PKG_RUST_VERSION"), registers)
    } else {
        ("1.84", String::new())
    };
    format!(
        "# {}\n[package]\nname = \"{}\"\nversion = \"0.1.0\"\nedition = \"2021\"\nrust-version = \"{rust_version}\"\n{dependencies}\n\
         # Not part of the workspace that its folder may lie in.\n[workspace]\n",
        first_line(context),
        context.name
    )
}

/// Whether the code needs the standard library.
fn needs_std(arithmetic: Arithmetic) -> bool {
    arithmetic.fused || arithmetic.sine == Sine::Platform
}

fn root(context: &Context<'_>) -> String {
    let name = context.name;
    let no_std = if needs_std(context.arithmetic()) { "" } else { "#![no_std]\n" };
    let kind = if context.has_loops() { "code of its own" } else { "straight-line code" };
    format!(
        "//! {}\n//!\n//! The dynamics of one robot as {kind}: see the functions of [`{name}`].\n{no_std}// Frames' names with several marks have several underscores.\n#![allow(non_snake_case)]\n\npub mod {name};\n",
        doc_text(&[first_line(context)]).concat()
    )
}

/// The code, without inner attributes, so that it can be included.
pub(crate) fn module(context: &Context<'_>) -> String {
    let syntax = syntax(context);
    let mut text = commented("//", &lines(context.model, context.request));
    let _ = write!(
        text,
        "\n/// Numbers of q.\npub const NQ: usize = {};\n/// Numbers of v, a and tau.\npub const NV: usize = {};\n",
        context.model.nq(),
        context.model.nv()
    );
    text += &prelude(syntax, context.helpers());
    for (program, layout) in context.functions() {
        text += &function(syntax, program, layout);
    }
    if context.request.lanes {
        text += &lanes::module(context);
    }
    text
}

fn prelude(syntax: Syntax<'_>, helpers: Helpers) -> String {
    let number = syntax.number();
    let mut text = String::new();
    if helpers.sign {
        let _ = write!(
            text,
            "\n/// -1, 0 or 1.\nfn sign(x: {number}) -> {number} {{\n    \
             if x > 0.0 {{\n        1.0\n    }} else if x < 0.0 {{\n        -1.0\n    }} else {{\n        x\n    }}\n}}\n"
        );
    }
    if helpers.root {
        text += &if needs_std(syntax.arithmetic) {
            format!("\nfn square_root(x: {number}) -> {number} {{\n    x.sqrt()\n}}\n")
        } else {
            own_root(syntax.arithmetic.precision)
        };
    }
    if helpers.sine {
        text += &match syntax.arithmetic.sine {
            Sine::Own => format!(
                "\n/// Sine and cosine: x less n quarter turns, Cody and Waite's reduction; then polynomials on [-pi/4, pi/4].\n\
                 #[allow(clippy::all, clippy::pedantic)]\n\
                 fn sin_cos(x: {number}) -> ({number}, {number}) {{\n{}    let n = shifted.to_bits();\n    \
                 let (sine, cosine) = if n & 1 == 1 {{ (cosine, sine) }} else {{ (sine, cosine) }};\n    \
                 let sine = if n & 2 != 0 {{ -sine }} else {{ sine }};\n    \
                 let cosine = if (n + 1) & 2 != 0 {{ -cosine }} else {{ cosine }};\n    (sine, cosine)\n}}\n",
                sine_statements(syntax, "    ")
            ),
            Sine::Platform => {
                format!("\nfn sin_cos(x: {number}) -> ({number}, {number}) {{\n    x.sin_cos()\n}}\n")
            }
        };
    }
    text
}

/// The root of the mantissa as an integer with one bit more than the result. That bit rounds the root, as no
/// root of a float is halfway between two floats.
fn own_root(precision: Precision) -> String {
    // For f64: m 2^e, m of 53 or 54 bits, e even; √(m 2⁵⁴) has 54 bits.
    let (number, bits, wide, digits, least, scale, back) = match precision {
        Precision::Double => (
            "f64",
            "u64",
            "u128",
            52,
            "2.2250738585072014e-308",
            "18014398509481984.0",
            "7.450580596923828e-9",
        ),
        Precision::Single => ("f32", "u32", "u64", 23, "1.1754944e-38", "67108864.0", "0.0001220703125"),
    };
    let (bias, shift) = if digits == 52 { (1023, 54) } else { (127, 25) };
    let mask = if digits == 52 { "0x000f_ffff_ffff_ffff" } else { "0x007f_ffff" };
    let one = if digits == 52 { "1 << 52" } else { "1 << 23" };
    format!(
        "\n/// The square root, rounded to nearest, without the standard library.\n\
         #[allow(clippy::all, clippy::pedantic)]\n\
         fn square_root(x: {number}) -> {number} {{\n    \
         if !(x > 0.0) || x == {number}::INFINITY {{\n        \
         return if x < 0.0 {{ {number}::NAN }} else {{ x }};\n    }}\n    \
         if x < {least} {{\n        return square_root(x * ({scale})) * {back};\n    }}\n    \
         let exponent = (x.to_bits() >> {digits}) as i32 - {bias};\n    \
         let mantissa = (x.to_bits() & {mask}) | ({one});\n    \
         let is_odd = exponent & 1;\n    \
         let root = ((mantissa as {wide}) << ({shift} + is_odd)).isqrt() as {bits};\n    \
         // As a float it has one more in the exponent for the leading bit.\n    \
         let rounded = (root + 1) >> 1;\n    \
         {number}::from_bits(rounded + ((((exponent - is_odd) / 2 + {bias} - 1) as {bits}) << {digits}))\n}}\n"
    )
}

/// The table of a matrix without its zeros.
fn entries(program: &Program) -> String {
    if program.entries.is_empty() {
        return String::new();
    }
    format!(
        "\n/// Row and column of each number of [`{}`].\npub const {}_ENTRIES: [(usize, usize); {}] = {:?};\n",
        program.symbol,
        program.symbol.to_ascii_uppercase(),
        program.entries.len(),
        program.entries
    )
}

fn function(syntax: Syntax<'_>, program: &Program, layout: &Layout) -> String {
    let (number, name) = (syntax.number(), &program.symbol);
    let arguments = program.arguments.iter().map(|x| format!("{}: &[{number}; {}]", x.name, x.length));
    let outcomes = program.outcomes.iter().map(|x| format!("{}: &mut [{number}; {}]", x.name, x.length()));
    let mut parameters: Vec<String> = arguments.chain(outcomes).collect();
    let whole = parameters.join(", ");
    let mut names: Vec<&str> = program
        .arguments
        .iter()
        .map(|x| x.name)
        .chain(program.outcomes.iter().map(|x| x.name.as_str()))
        .collect();
    let call = names.join(", ");
    let input =
        |argument: usize, index: AffineIndex| format!("{}[{index}]", program.arguments[argument].name);
    let store = |result: usize, index: AffineIndex, text: &str| {
        format!("{}[{index}] = {text};", program.outcomes[result].name)
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        format!("{}[..].fill(0.0);", outcome.name)
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let ignored = |statements: &str, names: &[&str]| -> String {
        let unused = names.iter().filter(|name| !mentions(statements, name));
        unused.map(|name| format!("    let _ = {name};\n")).collect()
    };
    let mut text = entries(program);
    let _ = write!(text, "\n{}", commented("///", &doc_text(&about(program))));
    text += "#[allow(non_snake_case, clippy::all, clippy::pedantic)]\n";
    let memory = format!("    let w = &mut [0.0; {}];\n", layout.array_length);
    if layout.parts.len() == 1 {
        let statements = body.part(0, "    ");
        let ignored = ignored(&statements, &names);
        let memory = if layout.array_length > 0 { memory } else { String::new() };
        let _ = write!(text, "pub fn {name}({whole}) {{\n{memory}{ignored}{statements}}}\n");
        return text;
    }
    let _ = write!(text, "pub fn {name}({whole}) {{\n{memory}");
    for part in 0..layout.parts.len() {
        let _ = writeln!(text, "    {name}_{part}({call}, w);");
    }
    text += "}\n";
    parameters.push(format!("w: &mut [{number}; {}]", layout.array_length));
    names.push("w");
    for part in 0..layout.parts.len() {
        let statements = body.part(part, "    ");
        let ignored = ignored(&statements, &names);
        let _ = write!(
            text,
            "\n#[inline(never)]\n#[allow(non_snake_case, clippy::all, clippy::pedantic)]\nfn {name}_{part}({}) {{\n{ignored}{statements}}}\n",
            parameters.join(", ")
        );
    }
    text
}

fn test(context: &Context<'_>) -> String {
    let (name, syntax) = (context.name, syntax(context));
    let number = syntax.number();
    let mut text = format!(
        "//! {}\n//!\n//! Holds the generated functions to the library's values in random states.\n#![allow(non_snake_case, clippy::all, clippy::pedantic)]\n\n\
         use {name}::{name} as robot;\n\n\
         #[track_caller]\nfn check(what: &str, found: &[{number}], expected: &[{number}], tolerance: {number}) {{\n    \
         for (i, (x, y)) in found.iter().zip(expected).enumerate() {{\n        \
         assert!((x - y).abs() <= tolerance, \"{{what}}, number {{i}}: {{x:e}}, not {{y:e}}\");\n    }}\n}}\n",
        doc_text(&[first_line(context)]).concat()
    );
    for program in context.programs {
        let symbol = &program.symbol;
        let _ = write!(text, "\n#[test]\nfn {symbol}_is_the_librarys() {{\n");
        for (k, case) in program.cases.iter().enumerate() {
            let list = |row: &[f64]| row.iter().map(|&x| syntax.literal(x)).collect::<Vec<_>>().join(", ");
            let arguments: Vec<String> =
                case.arguments.iter().map(|row| format!("&[{}]", list(row))).collect();
            let mut all = arguments;
            for outcome in &program.outcomes {
                let _ = writeln!(text, "    let mut {} = [0.0; {}];", outcome.name, outcome.length());
                all.push(format!("&mut {}", outcome.name));
            }
            let _ = writeln!(text, "    robot::{symbol}({});", all.join(", "));
            for (outcome, expected) in program.outcomes.iter().zip(&case.results) {
                let _ = writeln!(
                    text,
                    "    check(\"state {k}, {0}\", &{0}, &[{1}], {2});",
                    outcome.name,
                    list(expected),
                    syntax.literal(program.tolerance)
                );
            }
        }
        text += "}\n";
    }
    if context.request.lanes {
        text += &lanes::test(context);
    }
    text
}

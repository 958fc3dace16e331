//! WGSL: a compute shader for each function, a thread for each state.

use std::fmt::Write;

use super::context::Context;
use super::sine::sine_statements;
use super::wgsl_stages::{staged_calls, staged_parts};
use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::generated_files::GeneratedFile;
use crate::heading::{about, commented, first_line, lines};
use crate::layout::Layout;
use crate::program::Program;
use crate::syntax::{Helpers, Language, Syntax};

/// Threads of a workgroup of generated WGSL, one for each state. It determines the number of workgroups of a
/// batch.
pub const WGSL_WORKGROUP: usize = 64;

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    let name = context.name;
    let shaders = context.functions().map(|(program, layout)| {
        GeneratedFile::new(format!("{name}_{}.wgsl", program.symbol), shader(context, program, layout))
    });
    shaders.chain([GeneratedFile::new("golden.json", golden(context))]).collect()
}

fn shader(context: &Context<'_>, program: &Program, layout: &Layout) -> String {
    let syntax = Syntax { language: Language::Wgsl, arithmetic: context.arithmetic(), prefix: "" };
    let stages = program.stages.iter().flat_map(|stages| &stages.stages).map(|stage| &stage.program);
    let expressions = stages.chain([program]).map(|one| (&one.graph, &one.plan));
    let helpers = Helpers::of(expressions, context.arithmetic());
    let mut text = commented("//", &lines(context.model, context.request));
    text += "//\n";
    text += &commented("//", &about(program));
    let _ = write!(
        text,
        "//\n// One state after the other in each array; {WGSL_WORKGROUP} states in a workgroup.\n// Results are within rounding, as a device may fuse a product with a sum.\n\n"
    );
    let buffers = program
        .arguments
        .iter()
        .map(|x| (x.name, "read"))
        .chain(program.outcomes.iter().map(|x| (x.name.as_str(), "read_write")));
    for (binding, (name, access)) in buffers.enumerate() {
        let _ = writeln!(text, "@group(0) @binding({binding}) var<storage, {access}> {name}: array<f32>;");
    }
    if layout.array_length > 0 {
        let _ = writeln!(text, "\nvar<private> w: array<f32, {}>;", layout.array_length);
    }
    if helpers.sine {
        text += &sine_function(syntax);
    }
    let calls = match &program.stages {
        None => {
            text += &parts(syntax, program, layout);
            (0..layout.parts.len()).map(|part| format!("    part_{part}(state);\n")).collect()
        }
        Some(stages) => {
            text += &staged_parts(syntax, stages);
            staged_calls(program, stages)
        }
    };
    let first = &program.arguments[0];
    let _ = write!(
        text,
        "\n@compute @workgroup_size({WGSL_WORKGROUP})\nfn main(@builtin(global_invocation_id) id: vec3<u32>) {{\n    \
         let state = id.x;\n    if (state >= arrayLength(&{}) / {}u) {{\n        return;\n    }}\n",
        first.name, first.length
    );
    text + &calls + "}\n"
}

fn sine_function(syntax: Syntax<'_>) -> String {
    format!(
        "\n// Sine and cosine: x less n quarter turns, Cody and Waite's reduction; then polynomials on [-pi/4, pi/4].\n\
         fn sin_cos(x: f32) -> vec2<f32> {{\n    let n = round(x * {}f);\n{}    let k = bitcast<u32>(i32(shifted));\n    \
         let s = select(sine, cosine, (k & 1u) == 1u);\n    let c = select(cosine, sine, (k & 1u) == 1u);\n    \
         return vec2<f32>(select(s, -s, (k & 2u) == 2u), select(c, -c, ((k + 1u) & 2u) == 2u));\n}}\n",
        core::f32::consts::FRAC_2_PI,
        sine_statements(syntax, "    ")
    )
}

/// The parts of a function. The numbers of a state begin at its number times the width of the array.
fn parts(syntax: Syntax<'_>, program: &Program, layout: &Layout) -> String {
    let input = |argument: usize, index: AffineIndex| {
        let argument = &program.arguments[argument];
        format!("{0}[state * {1}u + {index}u]", argument.name, argument.length)
    };
    let store = |result: usize, index: AffineIndex, text: &str| {
        let outcome = &program.outcomes[result];
        format!("{0}[state * {1}u + {index}u] = {text};", outcome.name, outcome.length())
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        format!(
            "for (var i = 0u; i < {1}u; i++) {{ {0}[state * {1}u + i] = 0.0f; }}",
            outcome.name,
            outcome.length()
        )
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let mut text = String::new();
    for part in 0..layout.parts.len() {
        let _ = write!(text, "\nfn part_{part}(state: u32) {{\n{}}}\n", body.part(part, "    "));
    }
    text
}

/// Arguments and the library's results, state by state, to compare a device's results with.
fn golden(context: &Context<'_>) -> String {
    let mut functions = Vec::new();
    for program in context.programs {
        let list = |name: &str, rows: &mut dyn Iterator<Item = &Vec<f64>>| {
            let rows: Vec<String> = rows.map(|row| format!("{row:?}")).collect();
            format!("\"{name}\": [{}]", rows.join(", "))
        };
        let mut entries = Vec::new();
        for (k, argument) in program.arguments.iter().enumerate() {
            entries.push(list(argument.name, &mut program.cases.iter().map(|case| &case.arguments[k])));
        }
        for (k, outcome) in program.outcomes.iter().enumerate() {
            entries.push(list(
                &format!("-> {}", outcome.name),
                &mut program.cases.iter().map(|case| &case.results[k]),
            ));
        }
        functions.push(format!("  \"{}\": {{\n    {}\n  }}", program.symbol, entries.join(",\n    ")));
    }
    let provenance = first_line(context.request).replace('\\', "\\\\").replace('"', "\\\"");
    format!("{{\n  \"provenance\": \"{provenance}\",\n{}\n}}\n", functions.join(",\n"))
}

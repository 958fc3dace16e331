//! WGSL of functions in stages: a shader that calls the stages' code, with the tables between them in private
//! memory.

use std::fmt::Write;

use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::program::{Call, Instruction, Place, Program, ProgramResult, Stage, Stages};
use crate::syntax::Syntax;

/// The private memory, and the parts of each call: a function of WGSL cannot take a part of a table.
pub(super) fn staged_parts(syntax: Syntax<'_>, stages: &Stages) -> String {
    let mut text = String::from("\n");
    let longest = stages.stages.iter().map(|stage| stage.layout.array_length).max().unwrap_or(0);
    for (table, length) in &stages.locals {
        let _ = writeln!(text, "var<private> own_{table}: array<f32, {}>;", (*length).max(1));
    }
    let _ = writeln!(text, "var<private> w: array<f32, {}>;", longest.max(1));
    for (number, (call, _)) in stages.calls().into_iter().enumerate() {
        text += &parts(syntax, &stages.stages[call.stage], call, number);
    }
    text
}

/// The statements that compute a state.
pub(super) fn staged_calls(program: &Program, stages: &Stages) -> String {
    let mut text = String::new();
    instructions(program, stages, &stages.body, "    ", &mut 0, &mut text);
    text
}

fn instructions(
    program: &Program,
    stages: &Stages,
    body: &[Instruction],
    indent: &str,
    calls: &mut usize,
    text: &mut String,
) {
    let width = |table: &str| {
        let argument = program.arguments.iter().find(|x| x.name == table).map(|x| x.length);
        let outcome = program.outcomes.iter().find(|x| x.name == table).map(ProgramResult::length);
        argument.or(outcome).expect("a table of the function")
    };
    let number = |place: &Place| match place {
        Place::State(table) => format!("{table}[state * {}u + i]", width(table)),
        Place::Local { table, offset } => format!("own_{table}[{offset}u + i]"),
    };
    let each = |count: usize, statement: &str| {
        format!("{indent}for (var i = 0u; i < {count}u; i++) {{ {statement} }}\n")
    };
    for instruction in body {
        match instruction {
            Instruction::Call(call) => {
                let Stage { program, layout } = &stages.stages[call.stage];
                for part in 0..layout.parts.len() {
                    let _ = writeln!(text, "{indent}{}_{calls}_{part}(state);", program.symbol);
                }
                *calls += 1;
            }
            Instruction::Clear { place, count } => {
                *text += &each(*count, &format!("{} = 0.0f;", number(place)));
            }
            Instruction::Copy { from, to, count } => {
                *text += &each(*count, &format!("{} = {};", number(to), number(from)));
            }
            Instruction::Add { from, to, count } => {
                *text += &each(*count, &format!("{} += {};", number(to), number(from)));
            }
            Instruction::Repeat { count, body } => {
                let _ = writeln!(text, "{indent}for (var turn = 0u; turn < {count}u; turn++) {{");
                instructions(program, stages, body, &format!("{indent}    "), calls, text);
                let _ = writeln!(text, "{indent}}}");
            }
        }
    }
}

/// The parts of a call of a stage.
fn parts(syntax: Syntax<'_>, stage: &Stage, call: &Call, number: usize) -> String {
    let Stage { program, layout } = stage;
    let at = |place: &Place, width: usize, index: &dyn std::fmt::Display| match place {
        Place::State(table) => format!("{table}[state * {width}u + {index}]"),
        Place::Local { table, offset } => format!("own_{table}[{offset}u + {index}]"),
    };
    let input = |argument: usize, index: AffineIndex| {
        at(&call.arguments[argument], program.arguments[argument].length, &format!("{index}u"))
    };
    let store = |result: usize, index: AffineIndex, text: &str| {
        let place = at(&call.results[result], program.outcomes[result].length(), &format!("{index}u"));
        format!("{place} = {text};")
    };
    let clear = |result: usize| {
        let length = program.outcomes[result].length();
        let place = at(&call.results[result], length, &"i");
        format!("for (var i = 0u; i < {length}u; i++) {{ {place} = 0.0f; }}")
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let part = |part: usize| {
        format!("\nfn {}_{number}_{part}(state: u32) {{\n{}}}\n", program.symbol, body.part(part, "    "))
    };
    (0..layout.parts.len()).map(part).collect()
}

//! CUDA C of functions in stages: a kernel that calls the stages' code, with the tables between them in the
//! thread's own memory.

use std::fmt::Write;

use super::cuda_kernel::{head, parameters};
use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::program::{Call, Instruction, Place, Program, Stage, Stages};
use crate::syntax::Syntax;

/// The parts of each stage, and the kernel that calls them.
pub(super) fn staged_kernel(syntax: Syntax<'_>, program: &Program, stages: &Stages) -> String {
    let number = syntax.number();
    let name = format!("{}{}", syntax.prefix, program.symbol);
    let calls = stages.calls();
    let mut text = String::new();
    for (index, stage) in stages.stages.iter().enumerate() {
        let (call, _) = calls.iter().find(|(call, _)| call.stage == index).expect("each stage is called");
        text += &parts(syntax, &name, stage, call);
    }
    text += &head(&name, &parameters(number, program), program);
    let longest = stages.stages.iter().map(|stage| stage.layout.array_length).max().unwrap_or(0);
    for (table, length) in stages.locals.iter().chain([&("w", longest)]) {
        let _ = writeln!(text, "    {number} own_{table}[{}];", (*length).max(1));
    }
    instructions(&name, stages, &stages.body, "    ", &mut text);
    text + "}\n"
}

fn instructions(name: &str, stages: &Stages, body: &[Instruction], indent: &str, text: &mut String) {
    let number = |place: &Place| match place {
        Place::State(table) => format!("{table}[i * s]"),
        Place::Local { table, offset } => format!("own_{table}[{offset} + i]"),
    };
    for instruction in body {
        let _ = match instruction {
            Instruction::Call(Call { stage, arguments, results }) => {
                let table = |place: &Place| match place {
                    Place::State(table) => String::from(*table),
                    Place::Local { table, offset } => format!("own_{table} + {offset}"),
                };
                let tables = arguments.iter().chain(results).map(table).collect::<Vec<_>>().join(", ");
                let Stage { program, layout } = &stages.stages[*stage];
                (0..layout.parts.len()).try_for_each(|part| {
                    writeln!(text, "{indent}{name}_{}_{part}({tables}, s, own_w);", program.symbol)
                })
            }
            Instruction::Clear { place, count } => {
                writeln!(text, "{indent}for (int i = 0; i < {count}; i++) {} = 0;", number(place))
            }
            Instruction::Copy { from, to, count } | Instruction::Add { from, to, count } => {
                let sign = if matches!(instruction, Instruction::Add { .. }) { "+=" } else { "=" };
                writeln!(
                    text,
                    "{indent}for (int i = 0; i < {count}; i++) {} {sign} {};",
                    number(to),
                    number(from)
                )
            }
            Instruction::Repeat { count, body } => {
                let _ = writeln!(text, "{indent}for (int turn = 0; turn < {count}; turn++) {{");
                instructions(name, stages, body, &format!("{indent}    "), text);
                writeln!(text, "{indent}}}")
            }
        };
    }
}

/// The parts of a stage. Tables of the state have stride `s`, and tables between stages have stride 1.
fn parts(syntax: Syntax<'_>, name: &str, stage: &Stage, call: &Call) -> String {
    let Stage { program, layout } = stage;
    let number = syntax.number();
    let stride = |place: &Place| if matches!(place, Place::Local { .. }) { "" } else { " * s" };
    let input = |argument: usize, index: AffineIndex| {
        format!("{}[{index}{}]", program.arguments[argument].name, stride(&call.arguments[argument]))
    };
    let store = |result: usize, index: AffineIndex, text: &str| {
        format!("{}[{index}{}] = {text};", program.outcomes[result].name, stride(&call.results[result]))
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        let stride = stride(&call.results[result]);
        format!("for (int i = 0; i < {}; i++) {}[i{stride}] = 0;", outcome.length(), outcome.name)
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let whole = parameters(number, program);
    let part = |part: usize| {
        format!(
            "static __device__ __noinline__ void {name}_{}_{part}({whole}, const size_t s, {number} *__restrict__ w) {{\n{}}}\n\n",
            program.symbol,
            body.part(part, "    ")
        )
    };
    (0..layout.parts.len()).map(part).collect()
}

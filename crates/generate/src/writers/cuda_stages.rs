//! CUDA C of functions in stages: a kernel that calls the stages' code, with the tables between them in the
//! thread's own memory.

use std::fmt::Write;

use super::cuda_kernel::head;
use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::program::{Program, Stage};
use crate::syntax::Syntax;

/// The parts of each stage, and the kernel that calls them. Sweeps alternate between two sets of tables.
pub(super) fn staged_kernel(syntax: Syntax<'_>, program: &Program) -> String {
    let number = syntax.number();
    let name = format!("{}{}", syntax.prefix, program.symbol);
    let [first, sweep, last] = &program.stages[..] else {
        unreachable!("a step with contact has three stages")
    };
    let mut text: String = program.stages.iter().map(|stage| parts(syntax, &name, stage)).collect();
    let arguments = program.arguments.iter().map(|x| (x.name, x.length));
    let outcomes = program.outcomes.iter().map(|x| (x.name.as_str(), x.length()));
    let constants = arguments.clone().map(|(x, _)| format!("const {number} *__restrict__ {x}"));
    let results = outcomes.clone().map(|(x, _)| format!("{number} *__restrict__ {x}"));
    let whole = constants.chain(results).collect::<Vec<_>>().join(", ");
    text += &head(&name, &whole, &arguments.chain(outcomes).collect::<Vec<_>>());
    let length = |table: &str| {
        let argument = sweep.program.arguments.iter().find(|argument| argument.name == table);
        argument.map_or(0, |argument| argument.length)
    };
    let (velocity, impulses) = (length("velocity"), length("impulses"));
    let w = program.stages.iter().map(|stage| stage.layout.array_length).max().unwrap_or(0);
    for (table, length) in [
        ("problem", length("problem")),
        ("w", w),
        ("v0", velocity),
        ("v1", velocity),
        ("p0", impulses),
        ("p1", impulses),
    ] {
        let _ = writeln!(text, "    {number} {table}[{}];", length.max(1));
    }
    text += &calls(&name, first, &["problem", "v0"]);
    let _ = writeln!(text, "    for (int i = 0; i < {impulses}; i++) p0[i] = impulses[i * s];");
    let sweeps = sweep.repeats;
    let one = |from: usize, to: usize| {
        let names = [format!("v{from}"), format!("p{from}"), format!("v{to}"), format!("p{to}")];
        let names = names.each_ref().map(String::as_str);
        indented(&calls_of(&name, sweep, &["problem", names[0], names[1]], &[names[2], names[3]]))
    };
    let _ = write!(
        text,
        "    for (int sweep = 0; sweep < {}; sweep++) {{\n{}{}    }}\n",
        sweeps / 2,
        one(0, 1),
        one(1, 0)
    );
    let end = sweeps % 2;
    if end == 1 {
        let _ = write!(text, "    {{\n{}    }}\n", one(0, 1));
    }
    let velocity = format!("v{end}");
    text += &calls_of(&name, last, &["problem", &velocity, "q", "h"], &["q_next", "v_next"]);
    let _ = write!(text, "    for (int i = 0; i < {impulses}; i++) impulses_next[i * s] = p{end}[i];\n}}\n");
    text
}

fn indented(lines: &str) -> String {
    lines.lines().map(|line| format!("    {line}\n")).collect()
}

/// The calls of a stage whose arguments have their own names.
fn calls(name: &str, stage: &Stage, results: &[&str]) -> String {
    let arguments: Vec<&str> = stage.program.arguments.iter().map(|argument| argument.name).collect();
    calls_of(name, stage, &arguments, results)
}

/// The calls of a stage's parts with these tables.
fn calls_of(name: &str, stage: &Stage, arguments: &[&str], results: &[&str]) -> String {
    let tables = arguments.iter().chain(results).copied().collect::<Vec<_>>().join(", ");
    let call = |part: usize| format!("    {name}_{}_{part}({tables}, s, w);\n", stage.program.symbol);
    (0..stage.layout.parts.len()).map(call).collect()
}

/// The parts of a stage. Tables of the state have stride `s`, and tables between stages have stride 1.
fn parts(syntax: Syntax<'_>, name: &str, stage: &Stage) -> String {
    let Stage { program, layout, .. } = stage;
    let number = syntax.number();
    let index_in = |is_passed: bool, index: AffineIndex| match is_passed {
        true => format!("{index}"),
        false => format!("{index} * s"),
    };
    let input = |argument: usize, index: AffineIndex| {
        let table = program.arguments[argument].name;
        format!("{table}[{}]", index_in(stage.is_passed(table), index))
    };
    let store = |result: usize, index: AffineIndex, text: &str| {
        let table = &program.outcomes[result].name;
        format!("{table}[{}] = {text};", index_in(stage.is_passed_on(table), index))
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        let index = if stage.is_passed_on(&outcome.name) { "i" } else { "i * s" };
        format!("for (int i = 0; i < {}; i++) {}[{index}] = 0;", outcome.length(), outcome.name)
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let constants = program.arguments.iter().map(|x| format!("const {number} *__restrict__ {}", x.name));
    let outcomes = program.outcomes.iter().map(|x| format!("{number} *__restrict__ {}", x.name));
    let whole = constants.chain(outcomes).collect::<Vec<_>>().join(", ");
    let part = |part: usize| {
        format!(
            "static __device__ __noinline__ void {name}_{}_{part}({whole}, const size_t s, {number} *__restrict__ w) {{\n{}}}\n\n",
            program.symbol,
            body.part(part, "    ")
        )
    };
    (0..layout.parts.len()).map(part).collect()
}

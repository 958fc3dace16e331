//! WGSL of functions in stages: a shader that calls the stages' code, with the tables between them in private
//! memory.

use std::fmt::Write;

use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::program::{Program, Stage};
use crate::syntax::Syntax;

/// The private memory, and the parts of each stage.
pub(super) fn staged_parts(syntax: Syntax<'_>, program: &Program) -> String {
    let [_, sweep, _] = &program.stages[..] else { unreachable!("a step with contact has three stages") };
    let mut text = String::from("\n");
    let arguments = sweep.program.arguments.iter().map(|x| (x.name, x.length));
    let outcomes = sweep.program.outcomes.iter().map(|x| (x.name.as_str(), x.length()));
    for (name, length) in arguments.chain(outcomes) {
        let _ = writeln!(text, "var<private> p_{name}: array<f32, {}>;", length.max(1));
    }
    let w = program.stages.iter().map(|stage| stage.layout.array_length).max().unwrap_or(0);
    let _ = writeln!(text, "var<private> w: array<f32, {}>;", w.max(1));
    for stage in &program.stages {
        text += &parts(syntax, stage);
    }
    text
}

/// The statements that compute a state, stage by stage.
pub(super) fn staged_calls(program: &Program) -> String {
    let [first, sweep, last] = &program.stages[..] else {
        unreachable!("a step with contact has three stages")
    };
    let calls = |stage: &Stage, indent: &str| -> String {
        let call = |part: usize| format!("{indent}{}_{part}(state);\n", stage.program.symbol);
        (0..stage.layout.parts.len()).map(call).collect()
    };
    let impulses = sweep.program.outcomes[1].length();
    format!(
        "{}    for (var i = 0u; i < {impulses}u; i++) {{ p_impulses[i] = impulses[state * {impulses}u + i]; }}\n    \
         for (var sweep = 0u; sweep < {}u; sweep++) {{\n{}        p_velocity = p_velocity_next;\n        p_impulses = p_impulses_next;\n    }}\n\
         {}    for (var i = 0u; i < {impulses}u; i++) {{ impulses_next[state * {impulses}u + i] = p_impulses[i]; }}\n",
        calls(first, "    "),
        sweep.repeats,
        calls(sweep, "        "),
        calls(last, "    "),
    )
}

/// The parts of a stage.
fn parts(syntax: Syntax<'_>, stage: &Stage) -> String {
    let Stage { program, layout, .. } = stage;
    let input = |argument: usize, index: AffineIndex| {
        let argument = &program.arguments[argument];
        if stage.is_passed(argument.name) {
            format!("p_{}[{index}u]", argument.name)
        } else {
            format!("{0}[state * {1}u + {index}u]", argument.name, argument.length)
        }
    };
    let store = |result: usize, index: AffineIndex, text: &str| {
        let outcome = &program.outcomes[result];
        if stage.is_passed_on(&outcome.name) {
            format!("p_{}[{index}u] = {text};", outcome.name)
        } else {
            format!("{0}[state * {1}u + {index}u] = {text};", outcome.name, outcome.length())
        }
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        let (name, length) = (&outcome.name, outcome.length());
        if stage.is_passed_on(name) {
            format!("for (var i = 0u; i < {length}u; i++) {{ p_{name}[i] = 0.0f; }}")
        } else {
            format!("for (var i = 0u; i < {length}u; i++) {{ {name}[state * {length}u + i] = 0.0f; }}")
        }
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let part = |part: usize| {
        format!("\nfn {}_{part}(state: u32) {{\n{}}}\n", program.symbol, body.part(part, "    "))
    };
    (0..layout.parts.len()).map(part).collect()
}

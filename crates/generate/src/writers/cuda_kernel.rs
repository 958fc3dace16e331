//! A kernel in CUDA C.

use std::fmt::Write;

use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::layout::Layout;
use crate::program::Program;
use crate::syntax::Syntax;

/// The tables of a function with their widths: arguments, then results.
fn tables(program: &Program) -> impl Iterator<Item = (&str, usize)> {
    let outcomes = program.outcomes.iter().map(|x| (x.name.as_str(), x.length()));
    program.arguments.iter().map(|x| (x.name, x.length)).chain(outcomes)
}

/// The pointers to the tables of a function, as parameters.
pub(super) fn parameters(number: &str, program: &Program) -> String {
    let constants = program.arguments.iter().map(|x| format!("const {number} *__restrict__ {}", x.name));
    let outcomes = program.outcomes.iter().map(|x| format!("{number} *__restrict__ {}", x.name));
    constants.chain(outcomes).collect::<Vec<_>>().join(", ")
}

/// The head of a kernel, which moves the pointers to the numbers of a thread's state.
pub(super) fn head(name: &str, parameters: &str, program: &Program) -> String {
    let mut text = format!(
        "extern \"C\" __global__ void {name}({parameters}, const int count, const int by_columns) {{\n    \
         const int state = blockIdx.x * blockDim.x + threadIdx.x;\n    if (state >= count) {{\n        return;\n    }}\n    \
         const size_t s = by_columns ? count : 1;\n"
    );
    for (x, length) in tables(program) {
        let _ = writeln!(text, "    {x} += (size_t)state * (by_columns ? 1 : {length});");
    }
    text
}

/// The parts of a function, which access numbers with stride `s`, and the kernel that calls them.
pub(super) fn kernel(syntax: Syntax<'_>, program: &Program, layout: &Layout) -> String {
    let number = syntax.number();
    let name = format!("{}{}", syntax.prefix, program.symbol);
    let whole = parameters(number, program);
    let input =
        |argument: usize, index: AffineIndex| format!("{}[{index} * s]", program.arguments[argument].name);
    let store = |result: usize, index: AffineIndex, text: &str| {
        format!("{}[{index} * s] = {text};", program.outcomes[result].name)
    };
    let clear = |result: usize| {
        let outcome = &program.outcomes[result];
        format!("for (int i = 0; i < {}; i++) {}[i * s] = 0;", outcome.length(), outcome.name)
    };
    let (graph, results, place) = (&program.graph, &program.results, &every_number);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let (scratch, pass) = if layout.array_length > 0 {
        (format!(", {number} *__restrict__ w"), ", w")
    } else {
        (String::new(), "")
    };
    let mut text = String::new();
    for part in 0..layout.parts.len() {
        let _ = write!(
            text,
            "static __device__ __noinline__ void {name}_{part}({whole}, const size_t s{scratch}) {{\n{}}}\n\n",
            body.part(part, "    ")
        );
    }
    text += &head(&name, &whole, program);
    if layout.array_length > 0 {
        let _ = writeln!(text, "    {number} w[{}];", layout.array_length);
    }
    let names: Vec<&str> = tables(program).map(|(x, _)| x).collect();
    for part in 0..layout.parts.len() {
        let _ = writeln!(text, "    {name}_{part}({}, s{pass});", names.join(", "));
    }
    text + "}\n"
}

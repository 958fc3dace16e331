//! CUDA C: a kernel for each function, a thread for each state.

use std::fmt::Write;

use robot_dynamics_expression::{Precision, Sine};

use super::c::{comment, table};
use super::context::Context;
use super::cuda_kernel::kernel;
use super::cuda_stages::staged_kernel;
use super::sine::sine_statements;
use crate::generated_files::GeneratedFile;
use crate::heading::{about, first_line, lines};
use crate::program::Program;
use crate::syntax::{Helpers, Language, Syntax};

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    let name = context.name;
    vec![
        GeneratedFile::new(format!("{name}.cu"), source(context)),
        GeneratedFile::new(format!("test_{name}.cu"), test(context)),
        GeneratedFile::new("Makefile", makefile(context)),
    ]
}

fn syntax<'a>(context: &Context<'_>, prefix: &'a str) -> Syntax<'a> {
    Syntax { language: Language::Cuda, arithmetic: context.arithmetic(), prefix }
}

fn source(context: &Context<'_>) -> String {
    let prefix = format!("{}_", context.name);
    let syntax = syntax(context, &prefix);
    let mut head = lines(context.model, context.request);
    head.extend([
        String::new(),
        "Each kernel computes `count` states, a thread for each. By rows, one state's numbers lie side by side; by columns, one".into(),
        "number of all states: then the threads of a warp read and write side by side. With --fmad=false the results have the".into(),
        "library's bits; without, any product and sum may be rounded once.".into(),
    ]);
    let mut text = comment(&head);
    text += &prelude(syntax, context.helpers());
    for (program, layout) in context.functions() {
        text += "\n";
        text += &comment(&about(program));
        text += &match &program.stages {
            None => kernel(syntax, program, layout),
            Some(stages) => staged_kernel(syntax, program, stages),
        };
    }
    text
}

fn prelude(syntax: Syntax<'_>, helpers: Helpers) -> String {
    let (prefix, number) = (syntax.prefix, syntax.number());
    let mut text = String::new();
    if helpers.sign {
        let _ = write!(
            text,
            "\n/* -1, 0 or 1. */\nstatic __device__ {number} {prefix}sign({number} x) {{\n    return x > 0 ? 1 : x < 0 ? -1 : x;\n}}\n"
        );
    }
    if !helpers.sine {
        return text;
    }
    let _ = write!(text, "\nstruct {prefix}pair {{\n    {number} sine;\n    {number} cosine;\n}};\n");
    let (f, bits) = match syntax.arithmetic.precision {
        Precision::Double => ("", "const unsigned long long n = __double_as_longlong(shifted);"),
        Precision::Single => ("f", "const unsigned int n = __float_as_int(shifted);"),
    };
    let statements = match syntax.arithmetic.sine {
        Sine::Platform => format!("    sincos{f}(x, &pair.sine, &pair.cosine);\n"),
        Sine::Own => format!(
            "{}    {bits}\n    pair.sine = (n & 1) ? cosine : sine;\n    pair.cosine = (n & 1) ? sine : cosine;\n    \
             if (n & 2) {{\n        pair.sine = -pair.sine;\n    }}\n    \
             if ((n + 1) & 2) {{\n        pair.cosine = -pair.cosine;\n    }}\n",
            sine_statements(syntax, "    ")
        ),
    };
    let _ = write!(
        text,
        "\nstatic __device__ struct {prefix}pair {prefix}sin_cos({number} x) {{\n    struct {prefix}pair pair;\n{statements}    return pair;\n}}\n"
    );
    text
}

fn test(context: &Context<'_>) -> String {
    let (name, syntax) = (context.name, syntax(context, ""));
    let number = syntax.number();
    let mut text = comment(&[
        first_line(context.request),
        "Holds the kernels to the library's values in random states.".into(),
    ]);
    let _ = write!(
        text,
        "#include <cstdio>\n#include <cstring>\n\n#include \"{name}.cu\"\n\nstatic int failures = 0;\n\n\
         static {number} *on_device(const {number} *values, int count) {{\n    {number} *there;\n    \
         if (cudaMallocManaged(&there, count * sizeof({number})) != cudaSuccess) {{\n        printf(\"no device memory\\n\");\n        exit(1);\n    }}\n    \
         if (values) {{\n        memcpy(there, values, count * sizeof({number}));\n    }}\n    return there;\n}}\n\n\
         static void check(const char *what, const {number} *found, const {number} *expected, int count, {number} tolerance) {{\n    \
         for (int i = 0; i < count; i++) {{\n        const {number} off = found[i] - expected[i];\n        \
         if (!(off <= tolerance && off >= -tolerance)) {{\n            \
         printf(\"%s, number %d: %.17g, not %.17g\\n\", what, i, (double)found[i], (double)expected[i]);\n            failures++;\n        }}\n    }}\n}}\n"
    );
    let mut calls = String::new();
    for program in context.programs {
        let (tables, call) = test_function(syntax, name, program);
        text += &tables;
        calls += &call;
    }
    let _ = write!(
        text,
        "\nint main() {{\n{calls}    if (failures == 0) {{\n        \
         printf(\"{name}: {} functions in {} states, as the library's\\n\");\n    }}\n    return failures != 0;\n}}\n",
        context.programs.len(),
        context.request.states.max(1)
    );
    text
}

/// The tables of a function, and the block that calls its kernel and compares the results.
fn test_function(syntax: Syntax<'_>, name: &str, program: &Program) -> (String, String) {
    let number = syntax.number();
    let (mut text, mut calls) = (String::new(), String::new());
    let (symbol, states) = (&program.symbol, program.cases.len());
    calls += "    {\n";
    let mut names = Vec::new();
    for (k, argument) in program.arguments.iter().enumerate() {
        let rows = program.cases.iter().map(|case| &case.arguments[k]);
        text += &table(syntax, &format!("{symbol}_{}", argument.name), argument.length, rows);
        let count = argument.length * states;
        let _ =
            writeln!(calls, "        {number} *{0} = on_device({symbol}_{0}[0], {count});", argument.name);
        names.push(argument.name);
    }
    let mut checks = String::new();
    for (k, outcome) in program.outcomes.iter().enumerate() {
        let rows = program.cases.iter().map(|case| &case.results[k]);
        text += &table(syntax, &format!("{symbol}_expected_{}", outcome.name), outcome.length(), rows);
        let count = outcome.length() * states;
        let _ = writeln!(calls, "        {number} *{} = on_device(0, {count});", outcome.name);
        names.push(&outcome.name);
        let _ = writeln!(
            checks,
            "        check(\"{symbol}: {0}\", {0}, {symbol}_expected_{0}[0], {count}, {1});",
            outcome.name,
            syntax.literal(program.tolerance)
        );
    }
    let _ = write!(
        calls,
        "        {name}_{symbol}<<<1, {states}>>>({}, {states}, 0);\n        \
         if (cudaDeviceSynchronize() != cudaSuccess) {{\n            printf(\"{symbol}: %s\\n\", cudaGetErrorString(cudaGetLastError()));\n            return 1;\n        }}\n{checks}    }}\n",
        names.join(", ")
    );
    (text, calls)
}

fn makefile(context: &Context<'_>) -> String {
    let name = context.name;
    format!(
        "# {}\nNVCC ?= nvcc\n\ntest: test_{name}\n\t./test_{name}\n\n\
         test_{name}: {name}.cu test_{name}.cu\n\t$(NVCC) -O2 --fmad=false test_{name}.cu -o $@\n\n\
         clean:\n\trm -f test_{name}\n\n.PHONY: test clean\n",
        first_line(context.request),
    )
}

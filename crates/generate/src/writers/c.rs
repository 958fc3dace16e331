//! C99: a header, a source, a test, a Makefile.

use std::fmt::Write;

use robot_dynamics_expression::{Precision, Sine};

use super::context::Context;
use super::sine::sine_statements;
use crate::affine_index::AffineIndex;
use crate::body::Body;
use crate::generated_files::GeneratedFile;
use crate::heading::{about, commented, first_line, lines};
use crate::layout::Layout;
use crate::program::Program;
use crate::syntax::{Helpers, Language, Syntax, mentions};

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    let name = context.name;
    vec![
        GeneratedFile::new(format!("{name}.h"), header(context)),
        GeneratedFile::new(format!("{name}.c"), source(context)),
        GeneratedFile::new(format!("test_{name}.c"), test(context)),
        GeneratedFile::new("Makefile", build(context)),
    ]
}

/// A block comment.
pub(crate) fn comment(lines: &[String]) -> String {
    format!("/*\n{} */\n", commented(" *", lines))
}

fn header(context: &Context<'_>) -> String {
    let name = context.name;
    let upper = name.to_ascii_uppercase();
    let (nq, nv) = (context.model.nq(), context.model.nv());
    let mut text = comment(&lines(context.model, context.request));
    let _ = write!(
        text,
        "#ifndef {upper}_H\n#define {upper}_H\n\n#define {upper}_NQ {nq}\n#define {upper}_NV {nv}\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n/* No result may overlap another result or an argument. */\n"
    );
    for program in context.programs {
        text += "\n";
        text += &comment(&about(program));
        let _ = writeln!(text, "void {}_{}({});", name, program.symbol, parameters(context, program));
        if !program.entries.is_empty() {
            let _ = writeln!(
                text,
                "/* Row and column of each of its numbers. */\nextern const unsigned short {};",
                entries(context, program)
            );
        }
    }
    text += "\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n";
    text
}

/// The parameters in the header.
fn parameters(context: &Context<'_>, program: &Program) -> String {
    let number = syntax(context, "").number();
    let arguments = program.arguments.iter().map(|x| format!("const {number} {}[{}]", x.name, x.length));
    let outcomes = program.outcomes.iter().map(|x| format!("{number} {}[{}]", x.name, x.length()));
    arguments.chain(outcomes).collect::<Vec<_>>().join(", ")
}

fn syntax<'a>(context: &Context<'_>, prefix: &'a str) -> Syntax<'a> {
    Syntax { language: Language::C, arithmetic: context.arithmetic(), prefix }
}

fn source(context: &Context<'_>) -> String {
    let prefix = format!("{}_", context.name);
    let syntax = syntax(context, &prefix);
    let mut text = comment(&lines(context.model, context.request));
    let _ = writeln!(text, "#include \"{}.h\"\n", context.name);
    text += &prelude(syntax, context.helpers());
    for (program, layout) in context.functions() {
        text += "\n";
        let name = format!("{prefix}{}", program.symbol);
        text += &function(syntax, &Naming::plain(program, &name, layout), program);
        if !program.entries.is_empty() {
            let pairs: Vec<String> = program.entries.iter().map(|(i, j)| format!("{{{i}, {j}}}")).collect();
            let (name, pairs) = (entries(context, program), pairs.join(", "));
            let _ = write!(text, "\nconst unsigned short {name} = {{{pairs}}};\n");
        }
    }
    text
}

/// The declarator of the table of a matrix without its zeros.
fn entries(context: &Context<'_>, program: &Program) -> String {
    format!("{}_{}_entries[{}][2]", context.name, program.symbol, program.entries.len())
}

/// The helper functions.
pub(crate) fn prelude(syntax: Syntax<'_>, helpers: Helpers) -> String {
    let (prefix, number) = (syntax.prefix, syntax.number());
    let own_sine = helpers.sine && syntax.arithmetic.sine == Sine::Own;
    let mut text = String::new();
    if own_sine {
        text += "#include <float.h>\n#include <stdint.h>\n";
    }
    if helpers.root || helpers.fused || (helpers.sine && !own_sine) {
        text += "#include <math.h>\n";
    }
    if own_sine {
        text += "\n#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2)\n\
                 #error \"intermediate results must be rounded to their type (with GCC on old x86: -msse2 -mfpmath=sse)\"\n#endif\n";
    }
    text += "\n#if defined(__GNUC__)\n#define SEPARATE __attribute__((noinline))\n#else\n#define SEPARATE\n#endif\n";
    if helpers.sign {
        let _ = write!(
            text,
            "\n/* -1, 0 or 1. */\nstatic {number} {prefix}sign({number} x) {{\n    return x > 0 ? 1 : x < 0 ? -1 : x;\n}}\n"
        );
    }
    if helpers.sine {
        let _ = write!(text, "\nstruct {prefix}pair {{\n    {number} sine;\n    {number} cosine;\n}};\n");
        text += &if own_sine { own_sine_function(syntax) } else { platform_sine_function(syntax) };
    }
    text
}

fn platform_sine_function(syntax: Syntax<'_>) -> String {
    let (prefix, number) = (syntax.prefix, syntax.number());
    let f = if syntax.arithmetic.precision == Precision::Single { "f" } else { "" };
    format!(
        "\nstatic struct {prefix}pair {prefix}sin_cos({number} x) {{\n    struct {prefix}pair pair;\n    \
         pair.sine = sin{f}(x);\n    pair.cosine = cos{f}(x);\n    return pair;\n}}\n"
    )
}

fn own_sine_function(syntax: Syntax<'_>) -> String {
    let (prefix, number) = (syntax.prefix, syntax.number());
    let bits = if syntax.arithmetic.precision == Precision::Single { "uint32_t" } else { "uint64_t" };
    format!(
        "\n/* Sine and cosine: x less n quarter turns, Cody and Waite's reduction; then polynomials on [-pi/4, pi/4]. */\n\
         static struct {prefix}pair {prefix}sin_cos({number} x) {{\n\
         {}    union {{\n        {number} number;\n        {bits} n;\n    }} quarters;\n    struct {prefix}pair pair;\n    \
         quarters.number = shifted;\n    \
         pair.sine = (quarters.n & 1) ? cosine : sine;\n    \
         pair.cosine = (quarters.n & 1) ? sine : cosine;\n    \
         if (quarters.n & 2) {{\n        pair.sine = -pair.sine;\n    }}\n    \
         if ((quarters.n + 1) & 2) {{\n        pair.cosine = -pair.cosine;\n    }}\n    return pair;\n}}\n",
        sine_statements(syntax, "    ")
    )
}

/// The name and linkage of a function, and the places and layout of its numbers.
pub(crate) struct Naming<'a> {
    pub(crate) name: &'a str,
    pub(crate) linkage: &'static str,
    /// For each result: the place of each entry, if it is stored.
    pub(crate) places: Vec<Vec<Option<usize>>>,
    pub(crate) layout: &'a Layout,
}

impl<'a> Naming<'a> {
    /// All entries by rows.
    pub(crate) fn plain(program: &Program, name: &'a str, layout: &'a Layout) -> Self {
        let places = program.results.iter().map(|result| (0..result.len()).map(Some).collect()).collect();
        Self { name, linkage: "", places, layout }
    }
}

/// The definition of a function, in parts if it is long.
pub(crate) fn function(syntax: Syntax<'_>, naming: &Naming<'_>, program: &Program) -> String {
    let (name, number, layout) = (naming.name, syntax.number(), naming.layout);
    let arguments =
        program.arguments.iter().map(|x| format!("const {number} {}[restrict {}]", x.name, x.length));
    let outcomes = program.outcomes.iter().map(|x| format!("{number} {}[restrict {}]", x.name, x.length()));
    let mut parameters: Vec<String> = arguments.chain(outcomes).collect();
    let whole = parameters.join(", ");
    let names = || {
        program
            .arguments
            .iter()
            .map(|x| x.name)
            .chain(program.outcomes.iter().map(|x| x.name.as_str()))
            .collect::<Vec<_>>()
    };
    let input =
        |argument: usize, index: AffineIndex| format!("{}[{index}]", program.arguments[argument].name);
    let place = &|result: usize, index: usize| naming.places[result][index];
    let store = |result: usize, index: AffineIndex, text: &str| {
        format!("{}[{index}] = {text};", program.outcomes[result].name)
    };
    let clear = |result: usize| {
        let (outcome, count) = (&program.outcomes[result], naming.places[result].iter().flatten().count());
        format!("for (int i = 0; i < {count}; i++) {}[i] = 0;", outcome.name)
    };
    let (graph, results) = (&program.graph, &program.results);
    let body = Body { syntax, graph, layout, results, place, input, store, clear };
    let ignored = |statements: &str, names: &[&str]| -> String {
        let unused = names.iter().filter(|name| !mentions(statements, name));
        unused.map(|name| format!("    (void){name};\n")).collect()
    };
    let linkage = naming.linkage;
    let memory = format!("    {number} w[{}];\n", layout.array_length);
    if layout.parts.len() == 1 {
        let statements = body.part(0, "    ");
        let ignored = ignored(&statements, &names());
        let memory = if layout.array_length > 0 { memory } else { String::new() };
        return format!("{linkage}void {name}({whole}) {{\n{memory}{ignored}{statements}}}\n");
    }
    let mut text = String::new();
    parameters.push(format!("{number} w[restrict {}]", layout.array_length));
    let mut calls = String::new();
    for part in 0..layout.parts.len() {
        let statements = body.part(part, "    ");
        let mut all = names();
        all.push("w");
        let ignored = ignored(&statements, &all);
        let _ = write!(
            text,
            "static SEPARATE void {name}_{part}({}) {{\n{ignored}{statements}}}\n\n",
            parameters.join(", ")
        );
        let _ = writeln!(calls, "    {name}_{part}({}, w);", names().join(", "));
    }
    let _ = write!(text, "{linkage}void {name}({whole}) {{\n{memory}{calls}}}\n");
    text
}

fn test(context: &Context<'_>) -> String {
    let (name, syntax) = (context.name, syntax(context, ""));
    let number = syntax.number();
    let mut text = comment(&[
        first_line(context.request),
        "Holds the generated functions to the library's values in random states.".into(),
    ]);
    let _ = write!(
        text,
        "#include <stdio.h>\n\n#include \"{name}.h\"\n\n\
         static int failures = 0;\n\n\
         static void check(const char *what, int state, const {number} *found, const {number} *expected, int count, {number} tolerance) {{\n    \
         int i;\n    for (i = 0; i < count; i++) {{\n        \
         const {number} off = found[i] - expected[i];\n        \
         if (!(off <= tolerance && off >= -tolerance)) {{\n            \
         printf(\"%s, state %d, number %d: %.17g, not %.17g\\n\", what, state, i, (double)found[i], (double)expected[i]);\n            \
         failures++;\n        }}\n    }}\n}}\n"
    );
    let mut calls = String::new();
    for program in context.programs {
        text += &test_tables(syntax, program);
        calls += &test_calls(syntax, name, program);
    }
    let (count, states) = (context.programs.len(), context.request.states.max(1));
    let equal = if context.programs.iter().all(|program| program.tolerance == 0.0) {
        "as the library's recursions, to the last bit"
    } else {
        "as the library's"
    };
    let _ = write!(
        text,
        "\nint main(void) {{\n    int state;\n{calls}    if (failures == 0) {{\n        \
         printf(\"{name}: {count} functions in {states} states, {equal}\\n\");\n    }}\n    return failures != 0;\n}}\n"
    );
    text
}

/// The tables of arguments and expected results of a function.
fn test_tables(syntax: Syntax<'_>, program: &Program) -> String {
    let (symbol, mut text) = (&program.symbol, String::new());
    for (k, argument) in program.arguments.iter().enumerate() {
        let rows = program.cases.iter().map(|case| &case.arguments[k]);
        text += &table(syntax, &format!("{symbol}_{}", argument.name), argument.length, rows);
    }
    for (k, outcome) in program.outcomes.iter().enumerate() {
        let rows = program.cases.iter().map(|case| &case.results[k]);
        text += &table(syntax, &format!("{symbol}_expected_{}", outcome.name), outcome.length(), rows);
    }
    text
}

/// The loop that calls a function in all states and compares its results.
fn test_calls(syntax: Syntax<'_>, name: &str, program: &Program) -> String {
    let (symbol, number) = (&program.symbol, syntax.number());
    let found: String = (program.outcomes.iter())
        .map(|x| format!("        {number} {}[{}];\n", x.name, x.length()))
        .collect();
    let arguments = program.arguments.iter().map(|x| format!("{symbol}_{}[state]", x.name));
    let arguments: Vec<String> = arguments.chain(program.outcomes.iter().map(|x| x.name.clone())).collect();
    let checks: String = (program.outcomes.iter())
        .map(|x| {
            format!(
                "        check(\"{symbol}: {0}\", state, {0}, {symbol}_expected_{0}[state], {1}, {2});\n",
                x.name,
                x.length(),
                syntax.literal(program.tolerance)
            )
        })
        .collect();
    format!(
        "    for (state = 0; state < {}; state++) {{\n{found}        {name}_{symbol}({});\n{checks}    }}\n",
        program.cases.len(),
        arguments.join(", ")
    )
}

/// A table of constants.
pub(crate) fn table<'a>(
    syntax: Syntax<'_>,
    name: &str,
    length: usize,
    rows: impl Iterator<Item = &'a Vec<f64>>,
) -> String {
    let rows: Vec<String> = rows
        .map(|row| {
            let numbers: Vec<String> = row.iter().map(|&x| syntax.literal(x)).collect();
            format!("    {{{}}}", numbers.join(", "))
        })
        .collect();
    format!(
        "\nstatic const {} {name}[{}][{length}] = {{\n{},\n}};\n",
        syntax.number(),
        rows.len(),
        rows.join(",\n")
    )
}

fn build(context: &Context<'_>) -> String {
    let name = context.name;
    makefile(
        context,
        &format!(
            "test: test_{name}\n\t./test_{name}\n\n\
             test_{name}: {name}.c {name}.h test_{name}.c\n\t$(CC) $(CFLAGS) {name}.c test_{name}.c -lm -o $@\n\n\
             clean:\n\trm -f test_{name}\n"
        ),
    )
}

/// A Makefile with these rules.
pub(crate) fn makefile(context: &Context<'_>, rules: &str) -> String {
    let contract = if context.arithmetic().fused { "" } else { " -ffp-contract=off" };
    format!(
        "# {}\n\
         # `make test` holds the code to the library's values; without {} their bits may differ.\n\
         CC ?= cc\nCFLAGS = -std=c99 -O2 -Wall -Wextra -Werror -pedantic -fno-math-errno{contract}\n\n\
         {rules}\n.PHONY: test clean\n",
        first_line(context.request),
        if contract.is_empty() { "an `fma` that rounds once" } else { "-ffp-contract=off" },
    )
}

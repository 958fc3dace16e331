//! C with CasADi's calling convention, for `casadi.external`, with sparsity and Jacobians.

use std::fmt::Write;

use super::c::{Naming, comment, function, makefile, prelude};
use super::context::Context;
use super::placement::layout_for_places;
use crate::generated_files::GeneratedFile;
use crate::heading::{about, first_line, lines};
use crate::jacobian::jacobian;
use crate::layout::Layout;
use crate::program::{Program, ProgramResult};
use crate::request::Request;
use crate::syntax::{Helpers, Language, Syntax};

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    let name = context.name;
    vec![
        GeneratedFile::new(format!("{name}.c"), source(context)),
        GeneratedFile::new(format!("test_{name}.py"), test(context)),
        GeneratedFile::new("Makefile", build(context)),
    ]
}

/// Whether a Jacobian is written. Derivatives of derivatives, and those of four nested stages, are left to
/// CasADi's differences.
fn has_jacobian(program: &Program) -> bool {
    let stem = program.function.stem();
    !["derivatives", "pullback", "regressor", "coriolis", "rk4"].iter().any(|part| stem.contains(part))
}

/// A sparsity pattern in compressed columns.
struct Sparsity {
    rows: usize,
    columns: usize,
    /// The row of this crate for each row of CasADi.
    row_order: Vec<usize>,
    /// For each entry by rows: its place among the nonzeros by columns.
    places: Vec<Option<usize>>,
    nonzeros: usize,
}

impl Sparsity {
    /// The pattern of result `index`, by columns, with rows in this order.
    fn of(program: &Program, index: usize, row_order: Vec<usize>) -> Self {
        let outcome = &program.outcomes[index];
        let entries = &program.results[index];
        let mut places = vec![None; entries.len()];
        let mut nonzeros = 0;
        for column in 0..outcome.columns {
            for &row in &row_order {
                let entry = row * outcome.columns + column;
                if entries[entry].known() != Some(0.0) {
                    places[entry] = Some(nonzeros);
                    nonzeros += 1;
                }
            }
        }
        Self { rows: outcome.rows, columns: outcome.columns, row_order, places, nonzeros }
    }

    /// CasADi's list: rows, columns, the start of each column, the row of each nonzero; or 1 for a dense
    /// matrix.
    fn list(&self) -> Vec<usize> {
        let mut list = vec![self.rows, self.columns];
        if self.nonzeros == self.rows * self.columns {
            list.push(1);
            return list;
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in 0..self.columns {
            for (shown, &row) in self.row_order.iter().enumerate() {
                if self.places[row * self.columns + column].is_some() {
                    rows.push(shown);
                }
            }
            starts.push(rows.len());
        }
        list.extend(starts);
        list.extend(rows);
        list
    }
}

/// The order of a matrix's entries by columns, in which CasADi numbers them, given as indices by rows.
fn by_columns(rows: usize, columns: usize) -> Vec<usize> {
    (0..columns).flat_map(|column| (0..rows).map(move |row| row * columns + column)).collect()
}

/// The patterns of all results, with rows in their order.
fn plain(program: &Program) -> Vec<Sparsity> {
    let of = |(index, x): (usize, &ProgramResult)| Sparsity::of(program, index, (0..x.rows).collect());
    program.outcomes.iter().enumerate().map(of).collect()
}

/// The layout of a function whose results are stored by columns, without zeros.
pub(crate) fn layout(request: &Request, program: &Program) -> Layout {
    layout_by(request, program, &plain(program))
}

fn layout_by(request: &Request, program: &Program, sparsities: &[Sparsity]) -> Layout {
    layout_for_places(request, program, &|result, index| sparsities[result].places[index])
}

fn source(context: &Context<'_>) -> String {
    let prefix = format!("{}_", context.name);
    let syntax = Syntax { language: Language::C, arithmetic: context.arithmetic(), prefix: &prefix };
    let mut head = lines(context.model, context.request);
    head.push(String::new());
    head.push(
        "For casadi.external. Matrices are CasADi's, by columns; entries that are always zero are left out."
            .into(),
    );
    let mut body = String::new();
    let mut helpers = context.helpers();
    for (program, layout) in context.functions() {
        body += "\n";
        body += &comment(&about(program));
        let name = format!("{prefix}{}", program.symbol);
        body += &exported(syntax, layout, program, &name, &plain(program), &[]);
        if !has_jacobian(program) {
            continue;
        }
        let derivatives = jacobian(program, context.model, context.arithmetic());
        let of_derivatives =
            Helpers::of([(&derivatives.graph, &derivatives.plan)].into_iter(), context.arithmetic());
        helpers.root |= of_derivatives.root;
        let arguments = program.arguments.len();
        let sparsities: Vec<Sparsity> = (0..derivatives.outcomes.len())
            .map(|block| {
                let outcome = &program.outcomes[block / arguments];
                Sparsity::of(&derivatives, block, by_columns(outcome.rows, outcome.columns))
            })
            .collect();
        let nominal: Vec<(String, usize, usize)> =
            program.outcomes.iter().map(|x| (format!("out_{}", x.name), x.rows, x.columns)).collect();
        let layout = layout_by(context.request, &derivatives, &sparsities);
        body += &exported(syntax, &layout, &derivatives, &format!("jac_{name}"), &sparsities, &nominal);
    }
    let mut text = comment(&head);
    text += &prelude(syntax, helpers);
    text += "\n#ifndef casadi_real\n#define casadi_real double\n#endif\n#ifndef casadi_int\n#define casadi_int long long int\n#endif\n\
             #ifndef CASADI_SYMBOL_EXPORT\n#if defined(_WIN32)\n#define CASADI_SYMBOL_EXPORT __declspec(dllexport)\n#else\n#define CASADI_SYMBOL_EXPORT\n#endif\n#endif\n";
    let longest = context.programs.iter().flat_map(|x| &x.arguments).map(|x| x.length).max().unwrap_or(1);
    let _ = write!(
        text,
        "\n/* What CasADi leaves out is zero. */\nstatic const casadi_real {prefix}zeros[{longest}] = {{0}};\n"
    );
    text + &body
}

/// A function and all functions that CasADi calls for its shape; `nominal` are arguments that a Jacobian is
/// given and does not read.
///
/// Reference counts are not needed, so there are no `incref` and `decref`. If a function had them, the C code
/// that CasADi up to 3.7 writes would define functions of the same names in every file, and two such files
/// could not be linked.
fn exported(
    syntax: Syntax<'_>,
    layout: &Layout,
    program: &Program,
    name: &str,
    sparsities: &[Sparsity],
    nominal: &[(String, usize, usize)],
) -> String {
    let inner = format!("{name}_of");
    let places: Vec<_> = sparsities.iter().map(|sparsity| sparsity.places.clone()).collect();
    let mut text = String::new();
    text += &function(syntax, &Naming { name: &inner, linkage: "static ", places, layout }, program);
    let inputs: Vec<Pattern> = (program.arguments.iter())
        .map(|x| (x.name.to_owned(), vec![x.length, 1, 1]))
        .chain(nominal.iter().map(|(name, rows, columns)| {
            let mut none = vec![*rows, *columns];
            none.extend(vec![0; columns + 1]);
            (name.clone(), none)
        }))
        .collect();
    let outputs: Vec<Pattern> = (program.outcomes.iter().zip(sparsities))
        .map(|(x, sparsity)| (x.name.clone(), sparsity.list()))
        .collect();
    let mut calls: Vec<String> = (0..program.arguments.len())
        .map(|k| format!("arg[{k}] ? arg[{k}] : {}zeros", syntax.prefix))
        .collect();
    let mut scratch = 0;
    for (k, sparsity) in sparsities.iter().enumerate() {
        calls.push(format!("res[{k}] ? res[{k}] : w + {scratch}"));
        scratch += sparsity.nonzeros.max(1);
    }
    let _ = write!(
        text,
        "\nCASADI_SYMBOL_EXPORT int {name}(const casadi_real **arg, casadi_real **res, casadi_int *iw, casadi_real *w, int mem) {{\n    \
         (void)iw;\n    (void)mem;\n    {inner}({});\n    return 0;\n}}\n",
        calls.join(", ")
    );
    text + &shape_queries(name, &inputs, &outputs, scratch)
}

/// The name of an argument or result, and CasADi's list of its sparsity.
type Pattern = (String, Vec<usize>);

/// The functions that CasADi calls for the shape of a function: counts, names, sparsity, and sizes of work
/// memory.
fn shape_queries(name: &str, inputs: &[Pattern], outputs: &[Pattern], scratch: usize) -> String {
    let mut text = format!(
        "CASADI_SYMBOL_EXPORT casadi_int {name}_n_in(void) {{\n    return {};\n}}\n\
         CASADI_SYMBOL_EXPORT casadi_int {name}_n_out(void) {{\n    return {};\n}}\n",
        inputs.len(),
        outputs.len()
    );
    text += &names_and_sparsities(name, "in", inputs);
    text += &names_and_sparsities(name, "out", outputs);
    let _ = write!(
        text,
        "CASADI_SYMBOL_EXPORT int {name}_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {{\n    \
         if (sz_arg) *sz_arg = {};\n    if (sz_res) *sz_res = {};\n    if (sz_iw) *sz_iw = 0;\n    if (sz_w) *sz_w = {scratch};\n    return 0;\n}}\n",
        inputs.len(),
        outputs.len()
    );
    text
}

/// The functions for the names and the sparsity of arguments (`in`) or results (`out`).
fn names_and_sparsities(name: &str, way: &str, list: &[Pattern]) -> String {
    let names = list.iter().enumerate().map(|(k, (name, _))| format!("    case {k}: return \"{name}\";\n"));
    let mut text = format!(
        "CASADI_SYMBOL_EXPORT const char *{name}_name_{way}(casadi_int i) {{\n    switch (i) {{\n{}    default: return 0;\n    }}\n}}\n",
        names.collect::<String>()
    );
    let mut patterns = String::new();
    let mut cases = String::new();
    for (k, (_, pattern)) in list.iter().enumerate() {
        let numbers: Vec<String> = pattern.iter().map(ToString::to_string).collect();
        let _ = writeln!(
            patterns,
            "    static const casadi_int p{k}[{}] = {{{}}};",
            numbers.len(),
            numbers.join(", ")
        );
        let _ = writeln!(cases, "    case {k}: return p{k};");
    }
    let _ = write!(
        text,
        "CASADI_SYMBOL_EXPORT const casadi_int *{name}_sparsity_{way}(casadi_int i) {{\n{patterns}    switch (i) {{\n{cases}    default: return 0;\n    }}\n}}\n"
    );
    text
}

fn build(context: &Context<'_>) -> String {
    let name = context.name;
    makefile(
        context,
        &format!(
            "test: {name}.so\n\tpython3 test_{name}.py\n\n\
             {name}.so: {name}.c\n\t$(CC) $(CFLAGS) -fPIC -shared {name}.c -lm -o $@\n\n\
             # For C that CasADi writes of expressions with these functions, as for acados: -L. -l{name} -lm.\n\
             lib{name}.a: {name}.c\n\t$(CC) $(CFLAGS) -fPIC -c {name}.c -o {name}.o\n\t$(AR) rcs $@ {name}.o\n\n\
             clean:\n\trm -f {name}.so {name}.o lib{name}.a\n"
        ),
    )
}

fn test(context: &Context<'_>) -> String {
    let name = context.name;
    let mut text = format!(
        "\"\"\"{}\n\nHolds the functions to the library's values, and their Jacobians to differences. Needs CasADi.\n\"\"\"\n\
         import os\n\nimport casadi\nimport numpy as np\n\n\
         LIBRARY = os.path.join(os.path.dirname(os.path.abspath(__file__)), \"{name}.so\")\nCASES = {{\n",
        // Escaped for a string of Python.
        first_line(context.request).replace('\\', "\\\\").replace('"', "\\\""),
    );
    for program in context.programs {
        let _ = writeln!(text, "    \"{}\": [", program.symbol);
        for case in &program.cases {
            let results: Vec<String> = (program.outcomes.iter().zip(&case.results))
                .map(|(outcome, row)| format!("np.reshape({row:?}, ({}, {}))", outcome.rows, outcome.columns))
                .collect();
            let _ = writeln!(text, "        ({:?}, [{}]),", case.arguments, results.join(", "));
        }
        text += "    ],\n";
    }
    let tolerance = context.programs.iter().fold(0.0_f64, |most, program| most.max(program.tolerance));
    let _ = write!(
        text,
        "}}\nWITH_JACOBIAN = {:?}\n\n\n",
        context.programs.iter().filter(|x| has_jacobian(x)).map(|x| x.symbol.clone()).collect::<Vec<_>>()
    );
    let _ = write!(
        text,
        "def difference(function, arguments, at, step=1e-6):\n    \
         \"\"\"The columns of the Jacobian by one argument, entries by columns.\"\"\"\n    \
         columns = []\n    for index in range(len(arguments[at])):\n        ends = []\n        for by in (step, -step):\n            \
         moved = [list(x) for x in arguments]\n            moved[at][index] += by\n            \
         ends.append([np.ravel(np.array(y.full()), order=\"F\") for y in function.call(moved)])\n        \
         columns.append([(a - b) / (2 * step) for a, b in zip(*ends)])\n    return columns\n\n\n\
         for symbol, cases in CASES.items():\n    function = casadi.external(\"{name}_\" + symbol, LIBRARY)\n    for arguments, results in cases:\n        \
         for found, expected in zip(function.call(arguments), results):\n            \
         off = np.abs(found.full() - expected).max()\n            assert off <= {tolerance:?}, (symbol, off)\n    \
         if symbol in WITH_JACOBIAN:\n        derivatives = function.jacobian()\n        arguments = cases[0][0]\n        \
         nominal = function.call(arguments)\n        blocks = derivatives.call([casadi.DM(x) for x in arguments] + nominal)\n        \
         for at in range(len(arguments)):\n            columns = difference(function, arguments, at)\n            \
         for result in range(len(nominal)):\n                found = blocks[result * len(arguments) + at].full()\n                \
         expected = np.array([column[result] for column in columns]).T\n                \
         size = max(1.0, np.abs(found).max(), np.abs(nominal[result].full()).max())\n                \
         off = np.abs(found - expected).max()\n                assert off < 1e-6 * size, (symbol, at, result, off)\n\
         print(\"{name}: {{}} functions in {{}} states, {{}} Jacobians\".format(len(CASES), {}, len(WITH_JACOBIAN)))\n",
        context.request.states.max(1)
    );
    text
}

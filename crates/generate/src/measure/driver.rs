//! Programs that call generated functions and print how long each takes.

use std::fmt::Write;

use super::timing::{LEAST_DURATION, RUNS};
use crate::Request;
use crate::program::Program;
use crate::syntax::{Language, Syntax};
use crate::writers::c_table;

pub(super) fn c(request: &Request, name: &str, programs: &[Program]) -> String {
    let syntax = Syntax { language: Language::C, arithmetic: request.arithmetic, prefix: "" };
    let number = syntax.number();
    let mut text = format!(
        "#include <stdio.h>\n#include <time.h>\n\n#include \"{name}.h\"\n\nstatic volatile {number} kept;\n\n\
         static void measure(const char *name, void (*run)(long)) {{\n    \
         double best = 1e9, lasted = 0;\n    long count = 1;\n    int k;\n    \
         for (;; count *= 2) {{\n        const clock_t start = clock();\n        run(count);\n        \
         if ((double)(clock() - start) / CLOCKS_PER_SEC >= {LEAST_DURATION}) {{\n            break;\n        }}\n    }}\n    \
         for (k = 0; k < {RUNS}; k++) {{\n        const clock_t start = clock();\n        run(count);\n        \
         lasted = (double)(clock() - start) / CLOCKS_PER_SEC;\n        \
         best = lasted < best ? lasted : best;\n    }}\n    \
         printf(\"%s %.3f\\n\", name, 1e9 * best / (double)count);\n}}\n"
    );
    let mut calls = String::new();
    for program in programs {
        let symbol = &program.symbol;
        let mut passed = Vec::new();
        for (k, argument) in program.arguments.iter().enumerate() {
            let rows = program.cases.iter().map(|case| &case.arguments[k]);
            text += &c_table(syntax, &format!("{symbol}_{}", argument.name), argument.length, rows);
            passed.push(format!("{symbol}_{}[state]", argument.name));
        }
        let results: String = program
            .outcomes
            .iter()
            .map(|x| format!("    static {number} {}[{}];\n", x.name, x.length()))
            .collect();
        passed.extend(program.outcomes.iter().map(|x| x.name.clone()));
        let _ = write!(
            text,
            "\nstatic void run_{symbol}(long count) {{\n{results}    long k;\n    for (k = 0; k < count; k++) {{\n        \
             const int state = (int)(k % {});\n        {name}_{symbol}({});\n        kept = {}[0];\n    }}\n}}\n",
            program.cases.len(),
            passed.join(", "),
            program.outcomes[0].name
        );
        let _ = writeln!(calls, "    measure(\"{symbol}\", run_{symbol});");
    }
    text + &format!("\nint main(void) {{\n{calls}    return 0;\n}}\n")
}

pub(super) fn rust(request: &Request, name: &str, programs: &[Program]) -> String {
    let syntax = Syntax { language: Language::Rust, arithmetic: request.arithmetic, prefix: "" };
    let number = syntax.number();
    // The arguments are opaque to the optimizer, as for a call from another crate.
    let mut text = format!(
        "mod robot {{\n    include!(\"src/{name}.rs\");\n}}\n\nuse std::hint::black_box;\nuse std::time::Instant;\n\n\
         fn measure(name: &str, mut run: impl FnMut(usize)) {{\n    let mut time = |count: usize| {{\n        \
         let start = Instant::now();\n        run(count);\n        start.elapsed().as_secs_f64()\n    }};\n    \
         let mut count = 1;\n    while time(count) < {LEAST_DURATION} {{\n        count *= 2;\n    }}\n    \
         let best = (0..{RUNS}).map(|_| time(count)).fold(f64::INFINITY, f64::min);\n    \
         println!(\"{{name}} {{:.3}}\", 1e9 * best / count as f64);\n}}\n\nfn main() {{\n"
    );
    for program in programs {
        let symbol = &program.symbol;
        let states = program.cases.len();
        let mut passed = Vec::new();
        let mut tables = String::new();
        for (k, argument) in program.arguments.iter().enumerate() {
            let rows: Vec<String> = (program.cases.iter())
                .map(|case| {
                    let numbers: Vec<String> = case.arguments[k].iter().map(|&x| syntax.literal(x)).collect();
                    format!("[{}]", numbers.join(", "))
                })
                .collect();
            let _ = writeln!(
                tables,
                "        let {0}: [[{number}; {1}]; {states}] = [{2}];",
                argument.name,
                argument.length,
                rows.join(", ")
            );
            passed.push(format!("black_box(&{}[k % {states}])", argument.name));
        }
        for outcome in &program.outcomes {
            let _ = writeln!(tables, "        let mut {} = [0.0; {}];", outcome.name, outcome.length());
            passed.push(format!("black_box(&mut {})", outcome.name));
        }
        let _ = write!(
            text,
            "    {{\n{tables}        measure(\"{symbol}\", |count| {{\n            for k in 0..count {{\n                \
             robot::{symbol}({});\n            }}\n        }});\n    }}\n",
            passed.join(", ")
        );
    }
    text + "}\n"
}

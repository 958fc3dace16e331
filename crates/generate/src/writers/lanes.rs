//! Rust for many states at once: the same statements over the registers of `robot-dynamics-number`.

use std::collections::HashMap;
use std::fmt::Write;

use robot_dynamics_expression::Operand;

use super::context::Context;
use super::placement::layout_for_places;
use super::sine::sine_statements;
use crate::affine_index::AffineIndex;
use crate::body::Body;
use crate::heading::{about, commented, doc_text};
use crate::layout::Layout;
use crate::program::Program;
use crate::request::Request;
use crate::syntax::{Language, Syntax, mentions};

/// The width from which on rows are prefetched; narrower rows gain nothing.
const WIDE: usize = 16;

/// The code that all functions share.
const PRELUDE: &str = r#"
    use robot_dynamics_number::dispatch::{Call, Hardware, LaneKernel, LaneMemory, Storage};
    use robot_dynamics_number::{Scalar, StateLanes};

    pub use robot_dynamics_number::InstructionSet;

    /// Nothing is kept between calls.
    struct Nothing;

    impl Storage for Nothing {
        type Over<S: Scalar> = ();
        type Input<'a> = ();
        fn new<S: Scalar>((): ()) {}
    }

    /// How many states there are, from each table's name, length and width.
    #[track_caller]
    fn count(tables: &[(&str, usize, usize)]) -> usize {
        let (_, length, width) = tables[0];
        let states = length / width;
        for (name, length, width) in tables {
            assert!(
                *length == states * width,
                "{name} has {length} numbers; {states} states have {}",
                states * width
            );
        }
        states
    }
"#;

/// The module `lanes`.
pub(crate) fn module(context: &Context<'_>) -> String {
    let syntax = Syntax { language: Language::Lanes, arithmetic: context.arithmetic(), prefix: "" };
    let float = syntax.number();
    let mut text = String::from(
        "\n/// Many states at once: one state's numbers in each lane of the machine's vector registers.\n///\n\
         /// Tables are row-major, one state after the other, all of as many states. The newest instructions up to `limit` that the machine has\n\
         /// are looked for at each call (`InstructionSet::best()` allows all). A call runs on the thread that makes it: threads share a batch by\n\
         /// parts of its rows.\n",
    );
    text += &if context.arithmetic().fused {
        "/// Multiply-adds are rounded once where the registers have the instruction.\n".to_owned()
    } else {
        "/// Each state's results are the bits of the functions outside this module.\n".to_owned()
    };
    text += "#[allow(clippy::all, clippy::pedantic, non_camel_case_types, non_snake_case)]\npub mod lanes {";
    text += PRELUDE;
    if context.helpers().sine {
        let _ = write!(
            text,
            "\n    /// Sine and cosine, as of one state.\n    #[inline(always)]\n    \
             fn sin_cos<N: StateLanes<Float = {float}>>(x: N) -> (N, N) {{\n{}        N::turn(shifted, sine, cosine)\n    }}\n",
            sine_statements(syntax, "        ")
        );
    }
    for program in context.programs {
        text += &function(syntax, program, context.request);
    }
    text + "}\n"
}

/// The distinct values of a result: matrices contain many numbers twice, and zeros.
struct DistinctValues {
    /// For each number, the place of its value.
    places: Vec<usize>,
    /// For each value, its first number.
    firsts: Vec<usize>,
}

impl DistinctValues {
    fn of(result: &[Operand]) -> Self {
        let (mut seen, mut firsts) = (HashMap::new(), Vec::new());
        let place = |(index, &operand): (usize, &Operand)| {
            *seen.entry(operand).or_insert_with(|| {
                firsts.push(index);
                firsts.len() - 1
            })
        };
        let places = result.iter().enumerate().map(place).collect();
        Self { places, firsts }
    }

    /// Whether all numbers are distinct.
    fn is_plain(&self) -> bool {
        self.firsts.len() == self.places.len()
    }

    /// Whether this number is the first with its value.
    fn is_first(&self, index: usize) -> bool {
        self.firsts[self.places[index]] == index
    }
}

/// A table: its name, its count of numbers for one state, and how many of them are distinct.
struct LaneTable<'a> {
    name: &'a str,
    width: usize,
    count: usize,
}

/// A function over lanes, with its tables.
struct LaneFunction<'a> {
    syntax: Syntax<'a>,
    program: &'a Program,
    distinct: Vec<DistinctValues>,
    arguments: Vec<LaneTable<'a>>,
    outcomes: Vec<LaneTable<'a>>,
}

fn mutable(is_result: bool) -> &'static str {
    if is_result { "mut " } else { "" }
}

impl<'a> LaneFunction<'a> {
    fn new(syntax: Syntax<'a>, program: &'a Program) -> Self {
        let distinct: Vec<DistinctValues> =
            program.results.iter().map(|result| DistinctValues::of(result)).collect();
        let arguments = (program.arguments.iter())
            .map(|x| LaneTable { name: x.name, width: x.length, count: x.length })
            .collect();
        let outcomes = (program.outcomes.iter().zip(&distinct))
            .map(|(x, distinct)| LaneTable { name: &x.name, width: x.length(), count: distinct.firsts.len() })
            .collect();
        Self { syntax, program, distinct, arguments, outcomes }
    }

    /// A text for each table; the second argument of `write` is whether it is a result.
    fn each(&self, write: &dyn Fn(&LaneTable<'_>, bool) -> String) -> String {
        let read = self.arguments.iter().map(|table| write(table, false));
        read.chain(self.outcomes.iter().map(|table| write(table, true))).collect()
    }

    /// The statements that load a block of states.
    fn gather(&self) -> String {
        let load = |x: &LaneTable<'_>| {
            format!(
                "                N::gather_first(here, &self.{0}[first * {1}..], {1}, {0});\n",
                x.name, x.width
            )
        };
        self.arguments.iter().map(load).collect()
    }

    /// The statements that prefetch the rows of results.
    fn fetch(&self) -> String {
        let fetch = |x: &LaneTable<'_>| {
            format!(
                "                robot_dynamics_number::cache::fetch(self.{0}, first * {1}..(first + here) * {1});\n",
                x.name, x.width
            )
        };
        self.outcomes.iter().filter(|x| x.width >= WIDE).map(fetch).collect()
    }

    /// The tables of columns of results with repeated numbers, and the statements that store a block of
    /// states.
    fn scatter(&self) -> (String, String) {
        let (mut columns, mut stores) = (String::new(), String::new());
        for (x, distinct) in self.outcomes.iter().zip(&self.distinct) {
            let column = if distinct.is_plain() {
                "k".to_owned()
            } else {
                let table = format!("{}_COLUMNS", x.name.to_ascii_uppercase());
                let _ = writeln!(
                    columns,
                    "            const {table}: [u32; {}] = {:?};",
                    x.width, distinct.places
                );
                format!("{table}[k] as usize")
            };
            let _ = writeln!(
                stores,
                "                N::scatter_first(here, {1}, |k| &{0}[{column}], &mut self.{0}[first * {1}..], {1});",
                x.name, x.width
            );
        }
        (columns, stores)
    }

    /// The place of a number of a result, if it is the first with its value.
    fn place(&self, result: usize, index: usize) -> Option<usize> {
        let distinct = &self.distinct[result];
        distinct.is_first(index).then(|| distinct.places[index])
    }

    /// The public function, the kernel over rows, and the struct of a part's arguments.
    fn kernel(&self, layout: &Layout) -> String {
        let (float, name, places) = (self.syntax.number(), &self.program.symbol, layout.array_length);
        let parameters = self.each(&|x, is_result| format!(", {}: &{}[{float}]", x.name, mutable(is_result)));
        let lengths = self.each(&|x, _| format!("(\"{0}\", {0}.len(), {1}), ", x.name, x.width));
        let names = self.each(&|x, _| format!(", {}", x.name));
        let fields =
            self.each(&|x, is_result| format!("        {}: &'a {}[{float}],\n", x.name, mutable(is_result)));
        let blocks =
            self.each(&|x, _| format!("            let {} = &mut [N::zero(); {}];\n", x.name, x.count));
        let pass = self.each(&|x, _| format!("{}, ", x.name));
        let (gather, fetch, (columns, scatter)) = (self.gather(), self.fetch(), self.scatter());
        let (scratch, scratch_field, w) = if places > 0 {
            (
                format!("            let w = &mut [N::zero(); {places}];\n"),
                format!("        w: &'a mut [N; {places}],\n"),
                "w, ",
            )
        } else {
            (String::new(), String::new(), "")
        };
        let calls: String = (0..layout.parts.len())
            .map(|part| format!("                H::call({name}_part::<N, {part}> {{ {pass}{w}}});\n"))
            .collect();
        format!(
            "    #[track_caller]\n    pub fn {name}(limit: InstructionSet{parameters}) {{\n        \
             let states = count(&[{}]);\n        \
             LaneMemory::<Nothing>::new::<{float}>(limit, ()).run({name}_rows {{ states{names} }});\n    }}\n\n    \
             struct {name}_rows<'a> {{\n        states: usize,\n{fields}    }}\n\n    \
             impl LaneKernel<Nothing, {float}> for {name}_rows<'_> {{\n        #[inline(always)]\n        \
             fn run<N: StateLanes<Float = {float}>, H: Hardware>(self, (): &mut ()) {{\n{columns}{blocks}{scratch}            \
             let mut first = 0;\n            while first < self.states {{\n                \
             let here = N::LANES.min(self.states - first);\n{gather}{fetch}{calls}{scatter}                first += here;\n            }}\n        }}\n    }}\n\n    \
             struct {name}_part<'a, N, const PART: usize> {{\n{}{scratch_field}    }}\n",
            lengths.trim_end_matches(", "),
            self.each(&|x, is_result| {
                format!("        {}: &'a {}[N; {}],\n", x.name, mutable(is_result), x.count)
            }),
        )
    }

    /// The implementations of all parts.
    fn parts(&self, layout: &Layout) -> String {
        let Self { syntax, program, .. } = *self;
        let (float, name) = (syntax.number(), &program.symbol);
        let input =
            |argument: usize, index: AffineIndex| format!("{}[{index}]", program.arguments[argument].name);
        let store = |result: usize, index: AffineIndex, text: &str| {
            format!("{}[{index}] = {text};", program.outcomes[result].name)
        };
        let clear = |result: usize| {
            let zero = program.results[result].iter().position(|operand| *operand == Operand::ZERO);
            let place = self.distinct[result].places[zero.expect("a result that is cleared has zeros")];
            format!("{}[{place}] = N::zero();", program.outcomes[result].name)
        };
        let place = &|result: usize, index: usize| self.place(result, index);
        let (graph, results) = (&program.graph, &program.results);
        let body = Body { syntax, graph, layout, results, place, input, store, clear };
        let has_array = layout.array_length > 0;
        let mut text = String::new();
        for part in 0..layout.parts.len() {
            let statements = body.part(part, "            ");
            let tables = self.arguments.iter().chain(&self.outcomes).map(|x| x.name);
            let used: String = (tables.chain(has_array.then_some("w")))
                .filter(|name| mentions(&statements, name))
                .map(|name| format!("{name}, "))
                .collect();
            let _ = write!(
                text,
                "\n    impl<N: StateLanes<Float = {float}>> Call for {name}_part<'_, N, {part}> {{\n        #[inline(always)]\n        \
                 fn call<H: Hardware>(self) {{\n            let Self {{ {used}.. }} = self;\n{statements}        }}\n    }}\n"
            );
        }
        text
    }
}

fn function(syntax: Syntax<'_>, program: &Program, request: &Request) -> String {
    let function = LaneFunction::new(syntax, program);
    let layout = layout_for_places(request, program, &|result, index| function.place(result, index));
    let mut head = about(program);
    head.extend([
        String::new(),
        "# Panics".into(),
        "If the tables do not hold the same number of states.".into(),
    ]);
    let doc = commented("    ///", &doc_text(&head));
    format!("\n{doc}{}{}", function.kernel(&layout), function.parts(&layout))
}

/// The test compares states one by one with states over lanes, on every instruction set of the machine, in
/// full blocks and a partial one.
pub(crate) fn test(context: &Context<'_>) -> String {
    const STATES: usize = 37;
    let name = context.name;
    let syntax = Syntax { language: Language::Rust, arithmetic: context.arithmetic(), prefix: "" };
    let float = syntax.number();
    let sets = if context.arithmetic().fused {
        "// Where the registers have the instruction.\n        if InstructionSet::best_up_to(limit) == InstructionSet::Portable {\n            continue;\n        }\n        "
    } else {
        ""
    };
    let mut text = format!("\nuse ::{name}::{name}::lanes::{{self, InstructionSet}};\n");
    for program in context.programs {
        let symbol = &program.symbol;
        let _ = write!(text, "\n#[test]\nfn {symbol}_over_lanes_is_the_same() {{\n");
        let (mut over, mut alone) = (String::new(), String::new());
        for (k, argument) in program.arguments.iter().enumerate() {
            let rows = program.cases.iter().flat_map(|case| &case.arguments[k]);
            let numbers: Vec<String> = rows.map(|&x| syntax.literal(x)).collect();
            let (x, width) = (argument.name, argument.length);
            let _ = writeln!(
                text,
                "    let {x}: Vec<{float}> = [{}].into_iter().cycle().take({STATES} * {width}).collect();",
                numbers.join(", ")
            );
            let _ = write!(over, ", &{x}");
            let _ = write!(alone, "{x}[k * {width}..][..{width}].try_into().unwrap(), ");
        }
        let _ = write!(text, "    for &limit in InstructionSet::ALL {{\n        {sets}");
        let mut compared = String::new();
        for outcome in &program.outcomes {
            let (x, width) = (&outcome.name, outcome.length());
            let _ = writeln!(text, "let mut {x} = vec![0.0; {STATES} * {width}];");
            text += "        ";
            let _ = write!(over, ", &mut {x}");
            let _ = write!(alone, "&mut {x}_alone, ");
            let _ = writeln!(
                compared,
                "            let bits = |row: &[{float}]| row.iter().map(|x| x.to_bits()).collect::<Vec<_>>();\n            \
                 assert!(bits(&{x}[k * {width}..][..{width}]) == bits(&{x}_alone), \"state {{k}}, {x}, up to {{limit}}\");"
            );
        }
        let _ = write!(text, "lanes::{symbol}(limit{over});\n        for k in 0..{STATES} {{\n");
        for outcome in &program.outcomes {
            let _ =
                writeln!(text, "            let mut {}_alone = [0.0; {}];", outcome.name, outcome.length());
        }
        let alone = alone.trim_end_matches(", ");
        let _ = write!(text, "            robot::{symbol}({alone});\n{compared}        }}\n    }}\n}}\n");
    }
    text
}

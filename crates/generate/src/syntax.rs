//! How each language writes numbers and operations.

use crate::graph::{Graph, Operand, Operation};
use crate::plan::Plan;
use crate::{Arithmetic, Precision, Sine};

/// A language of generated code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Rust,
    /// Rust over the registers of `robot-dynamics-number`: `N` holds a number of each of several states.
    Lanes,
    C,
    Cuda,
    Wgsl,
}

/// A language, with what its names begin with and what its numbers are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Syntax<'a> {
    pub(crate) language: Language,
    pub(crate) arithmetic: Arithmetic,
    /// What the names of the file's own functions begin with.
    pub(crate) prefix: &'a str,
}

impl Syntax<'_> {
    /// The name of the number; over lanes, of one state's.
    pub(crate) fn number(&self) -> &'static str {
        match (self.language, self.arithmetic.precision) {
            (Language::Rust | Language::Lanes, Precision::Double) => "f64",
            (Language::Rust | Language::Lanes | Language::Wgsl, Precision::Single) => "f32",
            (Language::C | Language::Cuda, Precision::Double) => "double",
            (Language::C | Language::Cuda, Precision::Single) => "float",
            (Language::Wgsl, Precision::Double) => unreachable!("WGSL has no doubles: refused before"),
        }
    }

    /// The shortest digits that read back as `x`.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn literal(&self, x: f64) -> String {
        let digits = match self.arithmetic.precision {
            Precision::Double => format!("{x:?}"),
            Precision::Single => format!("{:?}", x as f32),
        };
        match (self.language, self.arithmetic.precision) {
            // All digits of a single: it is rounded from a double.
            (Language::Lanes, _) => format!("N::from_f64({:?})", self.arithmetic.precision.round(x)),
            (Language::Rust, _) | (_, Precision::Double) => digits,
            (_, Precision::Single) => digits + "f",
        }
    }

    /// A function of the C library by precision.
    fn of_library(&self, name: &str) -> String {
        let is_single = self.arithmetic.precision == Precision::Single;
        if is_single && self.language != Language::Wgsl { format!("{name}f") } else { name.into() }
    }

    fn declare(&self, name: &str, expression: &str) -> String {
        match self.language {
            Language::Rust | Language::Lanes | Language::Wgsl => format!("let {name} = {expression};"),
            Language::C | Language::Cuda => format!("const {} {name} = {expression};", self.number()),
        }
    }

    /// Both of a pair.
    fn declare_pair(&self, name: &str, angle: &str) -> String {
        let prefix = self.prefix;
        match self.language {
            Language::Rust | Language::Lanes | Language::Wgsl => {
                format!("let {name} = {prefix}sin_cos({angle});")
            }
            Language::C | Language::Cuda => {
                format!("const struct {prefix}pair {name} = {prefix}sin_cos({angle});")
            }
        }
    }

    fn half(&self, pair: &str, is_sine: bool) -> String {
        let field = match self.language {
            Language::Rust | Language::Lanes => ["1", "0"],
            Language::Wgsl => ["y", "x"],
            Language::C | Language::Cuda => ["cosine", "sine"],
        };
        format!("{pair}.{}", field[usize::from(is_sine)])
    }

    fn fused(&self, [a, b, c]: [String; 3]) -> String {
        match self.language {
            Language::Rust => format!("{}::mul_add({a}, {b}, {c})", self.number()),
            Language::Lanes => format!("N::mul_add({a}, {b}, {c})"),
            _ => format!("{}({a}, {b}, {c})", self.of_library("fma")),
        }
    }

    fn root(&self, a: &str) -> String {
        match self.language {
            Language::Rust => format!("square_root({a})"),
            Language::Lanes => format!("N::sqrt({a})"),
            _ => format!("{}({a})", self.of_library("sqrt")),
        }
    }

    fn sign(&self, a: &str) -> String {
        match self.language {
            Language::Wgsl => format!("sign({a})"),
            Language::Lanes => format!("N::signum0({a})"),
            _ => format!("{}sign({a})", self.prefix),
        }
    }
}

/// The statements of a program's parts.
pub(crate) struct Body<'a, I, O, F> {
    pub(crate) syntax: Syntax<'a>,
    pub(crate) graph: &'a Graph,
    pub(crate) plan: &'a Plan,
    pub(crate) results: &'a [Vec<Operand>],
    /// How number `index` of an argument is written.
    pub(crate) input: I,
    /// The statement that stores a text as number `index` of a result; none where it is not stored.
    pub(crate) store: O,
    /// The statement that sets all of a result to zero.
    pub(crate) clear: F,
}

/// Zeros of a result from which on it is cleared first: compilers take long for thousands of stores.
const MANY_ZEROS: usize = 8;

impl<I, O, F> Body<'_, I, O, F>
where
    I: Fn(usize, usize) -> String,
    O: Fn(usize, usize, &str) -> Option<String>,
    F: Fn(usize) -> String,
{
    /// One statement a line, each indented.
    pub(crate) fn part(&self, number: usize, indent: &str) -> String {
        let mut text = String::new();
        let mut add = |line: &str| {
            text.push_str(indent);
            text.push_str(line);
            text.push('\n');
        };
        let stored = self.stored_where(number);
        if number == 0 {
            let is_zero = |operand: &Operand| operand.known() == Some(0.0);
            let zeros = |entries: &[Operand]| entries.iter().filter(|entry| is_zero(entry)).count();
            let cleared: Vec<bool> =
                self.results.iter().map(|entries| zeros(entries) >= MANY_ZEROS).collect();
            (0..cleared.len())
                .filter(|&result| cleared[result])
                .for_each(|result| add(&(self.clear)(result)));
            // What needs no computing.
            for (result, index, operand) in self.entries() {
                let is_plain = operand.node().is_none_or(|node| self.graph.nodes[node].is_input());
                let is_done = cleared[result] && is_zero(&operand);
                if is_plain
                    && !is_done
                    && let Some(line) = (self.store)(result, index, &self.operand(operand, number))
                {
                    add(&line);
                }
            }
        }
        let mut at = 0;
        for &node in &self.plan.parts[number] {
            add(&self.statement(node, number));
            if let Some(place) = self.plan.kept[node] {
                add(&format!("w[{place}] = {};", self.name(node)));
            }
            while let Some(&(_, result, index, operand)) =
                stored.get(at).filter(|entry| entry.0 == self.step(node))
            {
                if let Some(line) = (self.store)(result, index, &self.operand(operand, number)) {
                    add(&line);
                }
                at += 1;
            }
        }
        text
    }

    /// All entries of all results.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, Operand)> {
        self.results.iter().enumerate().flat_map(|(result, entries)| {
            entries.iter().enumerate().map(move |(index, &operand)| (result, index, operand))
        })
    }

    /// The entries that a part computes, in the order of its operations.
    fn stored_where(&self, number: usize) -> Vec<(usize, usize, usize, Operand)> {
        let mut stored: Vec<_> = self
            .entries()
            .filter_map(|(result, index, operand)| {
                let node = operand.node()?;
                let is_here = self.plan.part_of[node] == number && !self.graph.nodes[node].is_input();
                is_here.then(|| (self.step(node), result, index, operand))
            })
            .collect();
        stored.sort_by_key(|&(step, result, index, _)| (step, result, index));
        stored
    }

    /// When an operation is done.
    fn step(&self, node: usize) -> usize {
        self.plan.step_of[node]
    }

    fn name(&self, node: usize) -> String {
        format!("t{}", self.step(node))
    }

    fn operand(&self, operand: Operand, part: usize) -> String {
        match operand {
            Operand::Constant(bits) => self.syntax.literal(f64::from_bits(bits)),
            Operand::Plus(node) => self.value(node as usize, part),
            Operand::Minus(node) => format!("-{}", self.value(node as usize, part)),
        }
    }

    fn value(&self, node: usize, part: usize) -> String {
        if let Operation::Input { argument, index } = self.graph.nodes[node] {
            return (self.input)(argument as usize, index as usize);
        }
        match self.plan.kept[node] {
            Some(place) if self.plan.part_of[node] != part => format!("w[{place}]"),
            _ => self.name(node),
        }
    }

    fn statement(&self, node: usize, part: usize) -> String {
        let text = |operand| self.operand(operand, part);
        let name = self.name(node);
        let expression = match self.graph.nodes[node] {
            Operation::Input { .. } => unreachable!("inputs are no steps"),
            Operation::SineCosine(a) => return self.syntax.declare_pair(&name, &text(a)),
            Operation::Sum(a, b) => format!("{} + {}", text(a), text(b)),
            Operation::Difference(a, b) => format!("{} - {}", text(a), text(b)),
            Operation::Product(a, b) => format!("{} * {}", text(a), text(b)),
            Operation::Quotient(a, b) => format!("{} / {}", text(a), text(b)),
            Operation::Fused(a, b, c) => self.syntax.fused([text(a), text(b), text(c)]),
            Operation::FusedMinus(a, b, c) => self.syntax.fused([text(a.negated()), text(b), text(c)]),
            Operation::Root(a) => self.syntax.root(&text(a)),
            Operation::Sign(a) => self.syntax.sign(&text(a)),
            Operation::Sine(a) => self.syntax.half(&text(a), true),
            Operation::Cosine(a) => self.syntax.half(&text(a), false),
        };
        self.syntax.declare(&name, &expression)
    }
}

/// Whether statements read or write the array of this name.
pub(crate) fn mentions(statements: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let entry = format!("{name}[");
    statements.match_indices(&entry).any(|(at, _)| !statements[..at].ends_with(is_part))
}

/// Whether some operation needs a function of its own in the file.
#[derive(Clone, Copy, Debug, Default)]
#[allow(clippy::struct_excessive_bools)] // one for each
pub(crate) struct Helpers {
    pub(crate) sine: bool,
    pub(crate) root: bool,
    pub(crate) sign: bool,
    pub(crate) fused: bool,
}

impl Helpers {
    pub(crate) fn of<'a>(plans: impl Iterator<Item = (&'a Graph, &'a Plan)>, arithmetic: Arithmetic) -> Self {
        let mut helpers = Self::default();
        for (graph, plan) in plans {
            for &node in plan.parts.iter().flatten() {
                match graph.nodes[node] {
                    Operation::SineCosine(_) => helpers.sine = true,
                    Operation::Root(_) => helpers.root = true,
                    Operation::Sign(_) => helpers.sign = true,
                    Operation::Fused(..) | Operation::FusedMinus(..) => helpers.fused = true,
                    _ => {}
                }
            }
        }
        helpers.fused |= helpers.sine && arithmetic.fused && arithmetic.sine == Sine::Own;
        helpers
    }
}

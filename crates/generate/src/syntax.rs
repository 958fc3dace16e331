//! The syntax of numbers and operations in each language.

use robot_dynamics_expression::{Arithmetic, Graph, Operation, Plan, Precision, Sine};

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

/// A language, with its arithmetic and the prefix of its names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Syntax<'a> {
    pub(crate) language: Language,
    pub(crate) arithmetic: Arithmetic,
    /// The prefix of the file's own functions.
    pub(crate) prefix: &'a str,
}

const NO_LOOPS: &str = "code for devices has no loops";

impl Syntax<'_> {
    /// The type of a number; over lanes, of one state's number.
    pub(crate) fn number(&self) -> &'static str {
        match (self.language, self.arithmetic.precision) {
            (Language::Rust | Language::Lanes, Precision::Double) => "f64",
            (Language::Rust | Language::Lanes | Language::Wgsl, Precision::Single) => "f32",
            (Language::C | Language::Cuda, Precision::Double) => "double",
            (Language::C | Language::Cuda, Precision::Single) => "float",
            (Language::Wgsl, Precision::Double) => unreachable!("WGSL has no doubles: refused before"),
        }
    }

    /// The shortest literal that is read back as `x`.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn literal(&self, x: f64) -> String {
        let digits = match self.arithmetic.precision {
            Precision::Double => format!("{x:?}"),
            Precision::Single => format!("{:?}", x as f32),
        };
        match (self.language, self.arithmetic.precision) {
            // All digits of a single, which is rounded from a double.
            (Language::Lanes, _) => format!("N::from_f64({:?})", self.arithmetic.precision.round(x)),
            (Language::Rust, _) | (_, Precision::Double) => digits,
            (_, Precision::Single) => digits + "f",
        }
    }

    /// The name of a C library function in this precision.
    fn library_name(&self, name: &str) -> String {
        let is_single = self.arithmetic.precision == Precision::Single;
        if is_single && self.language != Language::Wgsl { format!("{name}f") } else { name.into() }
    }

    pub(crate) fn declare(&self, name: &str, expression: &str) -> String {
        match self.language {
            Language::Rust | Language::Lanes | Language::Wgsl => format!("let {name} = {expression};"),
            Language::C | Language::Cuda => format!("const {} {name} = {expression};", self.number()),
        }
    }

    /// Declares a loop-carried variable.
    pub(crate) fn declare_carried(&self, name: &str, first: &str) -> String {
        match self.language {
            Language::Rust | Language::Lanes => format!("let mut {name} = {first};"),
            Language::C => format!("{} {name} = {first};", self.number()),
            Language::Wgsl | Language::Cuda => unreachable!("{NO_LOOPS}"),
        }
    }

    /// The head of a loop over iterations `k`.
    pub(crate) fn loop_head(&self, iterations: usize, is_read: bool) -> String {
        match self.language {
            Language::Rust | Language::Lanes => {
                format!("for {} in 0..{iterations} {{", if is_read { "k" } else { "_" })
            }
            Language::C => format!("for (int k = 0; k < {iterations}; k++) {{"),
            Language::Wgsl | Language::Cuda => unreachable!("{NO_LOOPS}"),
        }
    }

    /// Declares a table with a constant for each iteration, and returns the expression that reads it.
    pub(crate) fn constants(&self, number: usize, values: &[f64]) -> (String, String) {
        let float = self.number();
        let plain = match self.language {
            // Tables do not depend on the registers.
            Language::Lanes => Syntax { language: Language::Rust, ..*self },
            _ => *self,
        };
        let list = values.iter().map(|&x| plain.literal(x)).collect::<Vec<_>>().join(", ");
        let count = values.len();
        match self.language {
            Language::Rust => {
                (format!("static D{number}: [{float}; {count}] = [{list}];"), format!("D{number}[k]"))
            }
            Language::Lanes => (
                format!("static D{number}: [{float}; {count}] = [{list}];"),
                format!("N::from_f64(D{number}[k].into())"),
            ),
            Language::C => {
                (format!("static const {float} d{number}[{count}] = {{{list}}};"), format!("d{number}[k]"))
            }
            Language::Wgsl | Language::Cuda => unreachable!("{NO_LOOPS}"),
        }
    }

    /// Declares a pair of sine and cosine.
    pub(crate) fn declare_pair(&self, name: &str, angle: &str) -> String {
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

    pub(crate) fn half(&self, pair: &str, is_sine: bool) -> String {
        let field = match self.language {
            Language::Rust | Language::Lanes => ["1", "0"],
            Language::Wgsl => ["y", "x"],
            Language::C | Language::Cuda => ["cosine", "sine"],
        };
        format!("{pair}.{}", field[usize::from(is_sine)])
    }

    pub(crate) fn fused(&self, [a, b, c]: [String; 3]) -> String {
        match self.language {
            Language::Rust => format!("{}::mul_add({a}, {b}, {c})", self.number()),
            Language::Lanes => format!("N::mul_add({a}, {b}, {c})"),
            _ => format!("{}({a}, {b}, {c})", self.library_name("fma")),
        }
    }

    pub(crate) fn root(&self, a: &str) -> String {
        match self.language {
            Language::Rust => format!("square_root({a})"),
            Language::Lanes => format!("N::sqrt({a})"),
            _ => format!("{}({a})", self.library_name("sqrt")),
        }
    }

    pub(crate) fn sign(&self, a: &str) -> String {
        match self.language {
            Language::Wgsl => format!("sign({a})"),
            Language::Lanes => format!("N::signum0({a})"),
            _ => format!("{}sign({a})", self.prefix),
        }
    }
}

/// Whether statements access the array of this name.
pub(crate) fn mentions(statements: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let entry = format!("{name}[");
    statements.match_indices(&entry).any(|(at, _)| !statements[..at].ends_with(is_part))
}

/// Flags for the helper functions that the operations of a file need.
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
            for &node in &plan.order {
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

//! The languages and callers that code is generated for.

mod c;
mod casadi;
mod cuda;
mod lanes;
mod rust;
mod wgsl;

pub(crate) use c::table as c_table;
pub use wgsl::WGSL_WORKGROUP;

use core::fmt;

use robot_dynamics::model::Model;
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, Sine, trace_sine, trace_sine_of_quarters};

use crate::body::{Body, every_number};
use crate::layout::{AffineIndex, Layout};
use crate::program::Program;
use crate::request::{GeneratedFile, Request};
use crate::syntax::{Helpers, Language, Syntax};

/// A language, and the caller of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// A Rust crate without the standard library, whose one module can be included anywhere.
    Rust,
    /// C99: a header and a source that need libc only for roots (and for the platform's sine, if requested).
    C,
    /// C with CasADi's calling convention, for `casadi.external` and acados: sparsity, and Jacobians by the
    /// library's recursions or through the graph, whichever is shorter.
    Casadi,
    /// WGSL compute shaders, a thread for each state, in single precision.
    Wgsl,
    /// CUDA C kernels, a thread for each state, for nvcc or NVRTC.
    Cuda,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 5] = [Self::Rust, Self::C, Self::Casadi, Self::Wgsl, Self::Cuda];

    /// Its name.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_generate::Target::C.name(), "c");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Rust => "rust",
            Self::C => "c",
            Self::Casadi => "casadi",
            Self::Wgsl => "wgsl",
            Self::Cuda => "cuda",
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The input of all writers of files.
pub(crate) struct Context<'a> {
    pub(crate) model: &'a Model,
    pub(crate) request: &'a Request,
    /// The name of files and functions.
    pub(crate) name: &'a str,
    pub(crate) programs: &'a [Program],
    /// The layout of each program.
    pub(crate) layouts: &'a [Layout],
}

impl Context<'_> {
    /// The programs with their layouts.
    pub(crate) fn functions(&self) -> impl Iterator<Item = (&Program, &Layout)> {
        self.programs.iter().zip(self.layouts)
    }

    /// Whether a function has loops over bodies.
    pub(crate) fn has_loops(&self) -> bool {
        self.layouts.iter().any(Layout::has_loops)
    }

    pub(crate) fn arithmetic(&self) -> Arithmetic {
        self.request.arithmetic
    }

    pub(crate) fn helpers(&self) -> Helpers {
        let programs = self.programs.iter();
        Helpers::of(programs.map(|program| (&program.graph, &program.plan)), self.arithmetic())
    }
}

pub(crate) fn files(context: &Context<'_>) -> Vec<GeneratedFile> {
    match context.request.target {
        Target::Rust => rust::files(context),
        Target::C => c::files(context),
        Target::Casadi => casadi::files(context),
        Target::Wgsl => wgsl::files(context),
        Target::Cuda => cuda::files(context),
    }
}

/// The layout of a program for the target.
pub(crate) fn layout(request: &Request, program: &Program) -> Layout {
    match request.target {
        Target::Casadi => casadi::layout(request, program),
        Target::Rust | Target::C | Target::Wgsl | Target::Cuda => {
            layout_for_places(request, program, &every_number)
        }
    }
}

/// The layout with numbers of results stored at these places. Code for devices has no loops: an array that is
/// indexed by a loop variable is in local memory instead of registers.
fn layout_for_places(
    request: &Request,
    program: &Program,
    place: &dyn Fn(usize, usize) -> Option<usize>,
) -> Layout {
    match request.target {
        Target::Rust | Target::C | Target::Casadi if !request.straight => {
            Layout::new(&program.graph, &program.plan, &program.results, place)
        }
        _ => Layout::straight(&program.graph, &program.plan),
    }
}

/// The statements of the library's own sine, from `x` (in WGSL also `n`, the integer nearest to 2x/π) to
/// `shifted`, `sine`, `cosine`.
pub(crate) fn sine_statements(syntax: Syntax<'_>, indent: &str) -> String {
    debug_assert!(syntax.arithmetic.sine == Sine::Own);
    let is_wgsl = syntax.language == Language::Wgsl;
    let (graph, results): (Graph, Vec<Vec<Operand>>) =
        if is_wgsl { trace_sine_of_quarters(syntax.arithmetic) } else { trace_sine(syntax.arithmetic) };
    let plan = Plan::new(&graph, &results);
    let names = ["shifted", "sine", "cosine"];
    let store = |_: usize, index: AffineIndex, text: &str| syntax.declare(names[index.first], text);
    let input = |argument: usize, _: AffineIndex| ["x", "n"][argument].to_owned();
    let clear = |_: usize| -> String { unreachable!("sine and cosine are not constants") };
    let (layout, place) = (&Layout::straight(&graph, &plan), &every_number);
    Body { syntax, graph: &graph, layout, results: &results, place, input, store, clear }.part(0, indent)
}

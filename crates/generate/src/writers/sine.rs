//! The library's own sine as statements of a language.

use robot_dynamics_expression::{Graph, Operand, Plan, Sine, trace_sine, trace_sine_of_quarters};

use crate::affine_index::AffineIndex;
use crate::body::{Body, every_number};
use crate::layout::Layout;
use crate::syntax::{Language, Syntax};

/// The statements of the library's own sine, from `x` (in WGSL also `n`, the integer nearest to 2x/π) to
/// `shifted`, `sine`, `cosine`.
pub(super) fn sine_statements(syntax: Syntax<'_>, indent: &str) -> String {
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

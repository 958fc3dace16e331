//! The layout of a program whose results are stored at given places.

use crate::Target;
use crate::layout::Layout;
use crate::loops;
use crate::program::Program;
use crate::request::Request;

/// The layout with numbers of results stored at these places. Code for devices has no loops: an array that is
/// indexed by a loop variable is in local memory instead of registers.
pub(super) fn layout_for_places(
    request: &Request,
    program: &Program,
    place: &dyn Fn(usize, usize) -> Option<usize>,
) -> Layout {
    match request.target {
        Target::Rust | Target::C | Target::Casadi if !request.straight => {
            loops::shortest_layout(&program.graph, &program.plan, &program.results, place)
        }
        _ => Layout::straight(&program.graph, &program.plan),
    }
}

//! One element with its defaults, its line and its place.

use std::rc::Rc;

use crate::tree::Id;

/// An element with the defaults that apply to it.
#[derive(Clone)]
pub(crate) struct Element {
    pub(crate) node: Id,
    /// The default elements of its class, from the outermost class to the innermost.
    pub(crate) defaults: Rc<[Id]>,
    /// The line of the element.
    pub(crate) line: usize,
    /// As in `joint "elbow"`.
    pub(crate) place: String,
}

//! The pullbacks' part of the tree's memory.

use dynamics::Scalar;

use crate::Model;
use crate::spatial::screw::{Force, Screw};

/// Scratch for vector-Jacobian products: three six-vectors a body.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<S: Scalar> {
    /// L = Σ S λ over the freedoms that carry the body: its velocity if λ were one.
    pub(crate) shadow: Vec<Screw<S>>,
    /// P = Σ I L over the body and all beyond.
    pub(crate) momentum: Vec<Force<S>>,
    /// D = Σ 2Bᵀ L over the body and all beyond.
    pub(crate) drift: Vec<Force<S>>,
}

impl<S: Scalar> Scratch<S> {
    pub(crate) fn new(model: &Model) -> Self {
        let bodies = vec![Force::zero(); model.bodies.len()];
        Self { shadow: bodies.clone(), momentum: bodies.clone(), drift: bodies }
    }
}

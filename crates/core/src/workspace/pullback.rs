//! The memory of the pullbacks.

use robot_dynamics_number::Scalar;

use crate::Model;
use crate::spatial::screw::{Force, Screw};

/// Scratch for vector-Jacobian products: three six-vectors per body.
#[derive(Clone, Debug)]
pub struct Scratch<S: Scalar> {
    /// L = Σ S λ over the DoFs from the root to the body: its velocity if λ were the velocity.
    pub(crate) shadow: Vec<Screw<S>>,
    /// P = Σ I L over the body's subtree.
    pub momentum: Vec<Force<S>>,
    /// D = Σ 2Bᵀ L over the body's subtree.
    pub drift: Vec<Force<S>>,
}

impl<S: Scalar> Scratch<S> {
    pub fn new(model: &Model) -> Self {
        let bodies = vec![Force::zero(); model.bodies.len()];
        Self { shadow: bodies.clone(), momentum: bodies.clone(), drift: bodies }
    }
}

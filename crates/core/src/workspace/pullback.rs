//! The memory of the pullbacks.

use robot_dynamics_number::Scalar;

use crate::Model;
use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;

/// Buffers for vector-Jacobian products: three six-vectors per body.
#[derive(Clone, Debug)]
pub struct PullbackBuffers<S: Scalar> {
    /// L = Σ S λ over the DoFs from the root to the body: its velocity if λ were the velocity.
    pub(crate) shadow: Vec<MotionVector<S>>,
    /// P = Σ I L over the body's subtree.
    pub momentum: Vec<ForceVector<S>>,
    /// D = Σ 2Bᵀ L over the body's subtree.
    pub drift: Vec<ForceVector<S>>,
}

impl<S: Scalar> PullbackBuffers<S> {
    pub fn new(model: &Model) -> Self {
        let (shadow, forces) = (MotionVector::zero(), vec![ForceVector::zero(); model.bodies.len()]);
        Self { shadow: vec![shadow; model.bodies.len()], momentum: forces.clone(), drift: forces }
    }
}

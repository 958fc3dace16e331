//! What four freedoms' branches show to the freedoms that carry them.

use dynamics::Scalar;

use crate::scratch::momentum_block::{MomentumBlock, WIDTH};

/// Four branches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BranchBlock<S> {
    pub above: MomentumBlock<S>,
    pub inertial: MomentumBlock<S>,
    pub turning: [[S; WIDTH]; 3],
    /// The entries of a column of C below the diagonal, while a row is written.
    pub beyond: [S; WIDTH],
}

impl<S: Scalar> BranchBlock<S> {
    pub(crate) fn zero() -> Self {
        let zero = [S::zero(); WIDTH];
        Self { above: [zero; 6], inertial: [zero; 6], turning: [zero; 3], beyond: zero }
    }
}

//! Four branches side by side, as their ancestors need them for the Coriolis matrix.

use robot_dynamics_number::Scalar;

use crate::workspace::momentum_block::{MomentumBlock, WIDTH};

/// Four branches.
#[derive(Clone, Copy, Debug)]
pub struct BranchBlock<S> {
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

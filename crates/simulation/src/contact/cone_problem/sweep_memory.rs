//! The memory of the sweeps.

use core::ops::Range;

use robot_dynamics_core::clone_in_place::clone_in_place;

clone_in_place! {
    /// Memory for the sweeps.
    #[derive(Debug, Default)]
    pub(super) struct Sweeps {
        /// The coordinates of each tree, one tree after the other.
        pub(super) trees: Vec<Range<usize>>,
        /// The number of each coordinate's tree.
        pub(super) tree_of: Vec<usize>,
        /// The factor L of each tree, M = L Lᵀ, square, one after the other.
        pub(super) factors: Vec<f64>,
        pub(super) begins: Vec<usize>,
        /// The trees of each block.
        pub(super) block_trees: Vec<usize>,
        /// The places of each block's trees, of its M⁻¹Aᵀ row by row, and of its W.
        pub(super) blocks: Vec<Places>,
        pub(super) responses: Vec<f64>,
        pub(super) inertia: Vec<f64>,
        pub(super) column: Vec<f64>,
        /// p̄ and s before the sweeps.
        pub(super) multiplier: Vec<f64>,
        pub(super) shifts: Vec<f64>,
    }
}

/// The indices where the entries of a block begin.
#[derive(Clone, Debug)]
pub(super) struct Places {
    pub(super) trees: Range<usize>,
    pub(super) response: usize,
    pub(super) width: usize,
    pub(super) inertia: usize,
}

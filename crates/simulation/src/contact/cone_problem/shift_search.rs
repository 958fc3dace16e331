//! The memory of the search for the shifts.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::paths::{Four, WIDTH};

use super::tolerances::TOLERANCES;

clone_in_place! {
    /// Memory for the search for s.
    #[derive(Debug)]
    pub(super) struct ShiftSearch {
        /// For each cone s and μ|c_t| − s, in the last three iterations.
        pub(super) past: [Vec<(f64, f64)>; 3],
        /// The indices of the sliding cones among the cones.
        pub(super) sliding: Vec<usize>,
        /// dx/ds of each, for four of them side by side.
        pub(super) ways: Vec<Four>,
        /// ∂F/∂s − 1, and the change of s.
        pub(super) derivatives: Vec<f64>,
        pub(super) shifts: Vec<f64>,
        pub(super) many: UnsymmetricFactorMemory,
        /// The error of s in the last iteration.
        pub(super) off: f64,
        /// The number of fixed-point iterations left before Newton's method is tried again.
        pub(super) by_images: usize,
        /// The next such number.
        pub(super) images: usize,
    }
}

impl ShiftSearch {
    /// Allocates memory for n coordinates and 32 sliding cones.
    pub(super) fn new(n: usize) -> Self {
        Self {
            past: core::array::from_fn(|_| Vec::with_capacity(32)),
            sliding: Vec::with_capacity(32),
            ways: Vec::with_capacity(32 / WIDTH * n),
            derivatives: Vec::with_capacity(32 * 32 + WIDTH),
            shifts: Vec::with_capacity(32),
            many: UnsymmetricFactorMemory::default(),
            off: f64::INFINITY,
            by_images: 0,
            images: TOLERANCES.fixed_point_iterations,
        }
    }

    /// The largest error of s in a solution, as a fraction of the speed.
    pub(super) fn largest_error(&self) -> f64 {
        if self.by_images == 0 { TOLERANCES.shift_error } else { TOLERANCES.fixed_point_shift_error }
    }

    pub(super) fn clear(&mut self) {
        self.past.iter_mut().for_each(Vec::clear);
        (self.off, self.by_images, self.images) = (f64::INFINITY, 0, TOLERANCES.fixed_point_iterations);
    }
}

clone_in_place! {
    /// Memory for the unsymmetric factor.
    #[derive(Debug, Default)]
    pub(super) struct UnsymmetricFactorMemory {
        pub(super) lower: Vec<f64>,
        pub(super) upper: Vec<f64>,
        /// −V and U of each sliding cone, one entry for each of its coordinates.
        pub(super) pulls: Vec<f64>,
        pub(super) turns: Vec<f64>,
        pub(super) way: Vec<f64>,
    }
}

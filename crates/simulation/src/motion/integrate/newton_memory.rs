//! The memory of Newton's method.

use super::dense_factor::DenseFactor;

/// Memory of the method.
#[derive(Clone, Debug)]
pub(crate) struct Newton {
    /// v at the start of the step: the initial guess.
    pub(super) start: Vec<f64>,
    /// The iterate, its c, and Newton's correction.
    pub(super) v: Vec<f64>,
    pub(super) rest: Vec<f64>,
    pub(super) correction: Vec<f64>,
    /// −∂c/∂v.
    pub(super) slope: DenseFactor,
}

impl Newton {
    pub(crate) fn new(nv: usize) -> Self {
        let zero = || vec![0.0; nv];
        Self { start: zero(), v: zero(), rest: zero(), correction: zero(), slope: DenseFactor::new(nv) }
    }
}

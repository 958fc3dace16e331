//! The columns of changes.

use robot_dynamics_core::{Model, PARAMETERS_PER_LINK};

/// The columns of a change: (δq₀, δv₀, δτ), then those of the parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    nv: usize,
    /// The numbers of columns of controls, inertial parameters and friction coefficients.
    pub(super) controls: usize,
    pub(super) inertial: usize,
    pub(super) friction: usize,
}

impl Columns {
    /// The columns with these parameters.
    pub(super) fn new(model: &Model, controls: usize, has_inertial: bool, has_friction: bool) -> Self {
        let inertial = if has_inertial { PARAMETERS_PER_LINK * model.moving_links().count() } else { 0 };
        Self { nv: model.nv, controls, inertial, friction: usize::from(has_friction) }
    }

    /// The number of all columns.
    pub(super) fn width(&self) -> usize {
        self.first_friction() + self.friction
    }

    pub(super) fn first_control(&self) -> usize {
        3 * self.nv
    }

    pub(super) fn first_inertial(&self) -> usize {
        self.first_control() + self.controls
    }

    pub(super) fn first_friction(&self) -> usize {
        self.first_inertial() + self.inertial
    }

    /// Adds `factor` times a matrix of nv rows to the columns from `first` on.
    pub(super) fn add(&self, change: &mut [f64], first: usize, factor: f64, matrix: &[f64]) {
        let count = matrix.len() / self.nv.max(1);
        if count == 0 {
            return;
        }
        for (row, own) in change.chunks_exact_mut(self.width()).zip(matrix.chunks_exact(count)) {
            row[first..first + count].iter_mut().zip(own).for_each(|(sum, x)| *sum += factor * x);
        }
    }

    /// Writes some columns of the changes of q₁ and v₁ to a matrix of 2nv rows.
    pub(super) fn write(&self, (first, count): (usize, usize), changes: [&[f64]; 2], matrix: &mut [f64]) {
        if count == 0 {
            return;
        }
        let rows = changes.into_iter().flat_map(|change| change.chunks_exact(self.width()));
        for (to, row) in matrix.chunks_exact_mut(count).zip(rows) {
            to.copy_from_slice(&row[first..first + count]);
        }
    }
}

//! The input tables of a batch.

use robot_dynamics_core::Model;

/// The input tables of an operation with their names and widths; unused ones are empty.
pub struct InputTables<'a, T, const A: usize = 3> {
    pub names: [&'static str; A],
    pub widths: [usize; A],
    pub rows: [&'a [T]; A],
}

impl<'a, T, const A: usize> InputTables<'a, T, A> {
    /// The rows of some states.
    pub(super) fn rows(&self, first: usize, states: usize) -> [&'a [T]; A] {
        core::array::from_fn(|i| {
            let width = self.widths[i];
            &self.rows[i][first * width..(first + states) * width]
        })
    }

    /// The number of states.
    #[track_caller]
    pub(super) fn count(&self, model: &Model) -> usize {
        let (len, nq) = (self.rows[0].len(), model.nq());
        assert!(len.is_multiple_of(nq.max(1)), "q has {len} numbers, not a multiple of nq = {nq}");
        let batch = len / nq.max(1);
        for k in 1..A {
            check_table(self.names[k], self.rows[k].len(), batch, self.widths[k]);
        }
        batch
    }
}

/// Panics with both numbers if a table has the wrong length.
#[track_caller]
pub(super) fn check_table(name: &str, found: usize, batch: usize, width: usize) {
    let expected = batch * width;
    assert!(found == expected, "{name} has {found} numbers, {batch} states need {expected} ({width} each)");
}

//! The rows of bad states.

use robot_dynamics_number::Float;

use crate::bad_states::states_of;

/// Writes NaN to the rows of bad states.
#[cold]
#[inline(never)]
pub(super) fn spoil<T: Float>(bad: u32, rows: &mut [T], states: usize) {
    let width = rows.len() / states;
    for state in states_of(bad, 0) {
        rows[state * width..(state + 1) * width].fill(T::from_f64(f64::NAN));
    }
}

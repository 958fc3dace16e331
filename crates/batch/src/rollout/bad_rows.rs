//! The rows of bad states.

use robot_dynamics_number::Float;

use crate::bad_states::states_of;

/// A bit for each state with a number in one of the tables that is not finite.
#[cfg(feature = "native")]
pub(super) fn bad_rows<T: Float>(tables: &[&[T]], states: usize) -> u32 {
    let is_bad = |&state: &usize| {
        tables.iter().any(|table| {
            let width = table.len() / states;
            !table[state * width..(state + 1) * width].iter().all(|x| x.is_finite())
        })
    };
    (0..states).filter(is_bad).fold(0, |bits, state| bits | 1 << state)
}

/// Writes NaN to the rows of bad states.
#[cold]
#[inline(never)]
pub(super) fn spoil<T: Float>(bad: u32, rows: &mut [T], states: usize) {
    let width = rows.len() / states;
    for state in states_of(bad, 0) {
        rows[state * width..(state + 1) * width].fill(T::from_f64(f64::NAN));
    }
}

//! The lengths that a model asks of its slices.

/// Panics with both numbers when a slice has the wrong length.
#[inline(always)]
#[track_caller]
pub(crate) fn check_length(name: &str, found: usize, expected: usize) {
    assert!(found == expected, "{name} has {found} entries, the model needs {expected}");
}

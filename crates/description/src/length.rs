//! Checks of slice lengths.

/// Panics with both lengths if a slice has the wrong length.
#[doc(hidden)]
#[inline(always)]
#[track_caller]
pub fn check_length(name: &str, found: usize, expected: usize) {
    assert!(found == expected, "{name} has {found} entries, the model needs {expected}");
}

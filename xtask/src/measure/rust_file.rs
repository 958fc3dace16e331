//! A file of Rust with its code.

/// A file of Rust with its code.
pub(super) struct RustFile<'a> {
    pub(super) path: &'a str,
    pub(super) text: &'a str,
    /// Its code without comments, what literals hold, and unit tests.
    pub(super) code: String,
    /// Whether it is a test or a benchmark as a whole.
    pub(super) is_test: bool,
}

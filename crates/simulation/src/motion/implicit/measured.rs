//! A configuration with the lengths that need the placement of the bodies.

/// A configuration with the lengths of the bounded paths there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<'a> {
    pub(super) q: &'a [f64],
    pub(super) lengths: &'a [f64],
}

/// A configuration of a robot without bounded paths.
impl<'a> From<&'a [f64]> for Measured<'a> {
    fn from(q: &'a [f64]) -> Self {
        Self { q, lengths: &[] }
    }
}

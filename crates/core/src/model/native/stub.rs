//! Replacement without the feature `native`: no model has machine code.

use super::report::NativeReport;

/// An empty value.
#[derive(Clone, Debug, Default)]
pub struct Native(());

#[allow(clippy::unused_self)] // as with the feature
impl Native {
    pub(super) fn switch(&mut self, _: bool) {}

    pub(super) fn report<M>(&self, _: &M) -> NativeReport {
        NativeReport { reason: Some("the feature `native` is off".into()), functions: Vec::new() }
    }
}

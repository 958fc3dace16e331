//! The numbers of a tree.

use std::collections::BTreeMap;

use super::{api, duplicates, functions, size};

/// How often a rule of prose is broken.
pub(super) struct ProseCount {
    /// The rule; for phrases, the phrase.
    pub(super) name: String,
    /// By kind of file.
    pub(super) by_language: BTreeMap<&'static str, usize>,
}

/// All numbers.
pub(super) struct Measurement {
    pub(super) crates: Vec<size::CrateSize>,
    pub(super) facade: api::Facade,
    pub(super) apis: Vec<api::CrateApi>,
    pub(super) cycles: Vec<(Vec<String>, String)>,
    pub(super) prose: Vec<ProseCount>,
    pub(super) phrases: Vec<ProseCount>,
    pub(super) longest: Vec<functions::Function>,
    pub(super) duplicates: Vec<duplicates::Duplicate>,
    pub(super) repeated_types: Vec<(String, Vec<String>)>,
}

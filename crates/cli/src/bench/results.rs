//! The data of the report.

use robot_dynamics::model::Model;

use super::entry::Entry;
use super::machine::Machine;

/// The data of the report.
pub(super) struct Results<'a> {
    pub(super) model: &'a Model,
    pub(super) file: String,
    pub(super) machine: Machine,
    pub(super) tip: String,
    pub(super) states: u32,
    pub(super) seed: u64,
    pub(super) rounds: usize,
    pub(super) threads: Vec<usize>,
    pub(super) entries: Vec<Entry>,
    pub(super) interrupted: bool,
}

//! The results of a check: the margin of each law, or the violated law with its state and defect.

use core::fmt;

use super::{Sample, States};

/// A law that a model violates, with a state at which it does.
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub struct Violation {
    /// The law, as a statement.
    pub law: &'static str,
    /// The model's name, as given to the check.
    pub model: String,
    /// The seed of the states.
    pub seed: u64,
    /// The index of the state in its sequence.
    pub index: usize,
    /// The state, coordinate by coordinate: (qᵢ, q̇ᵢ, uᵢ, q̈ᵢ).
    pub state: Vec<[f64; 4]>,
    /// The defect found; NaN if a term is NaN.
    pub found: f64,
    /// The largest defect that rounding explains.
    pub allowed: f64,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [q, qd, u, qdd] =
            [0, 1, 2, 3].map(|k| self.state.iter().map(|coordinate| coordinate[k]).collect::<Vec<f64>>());
        write!(
            f,
            "{} breaks \"{}\": found {:e}, allowed {:e}, at state {} of seed {}: \
             q = {q:?}, q̇ = {qd:?}, u = {u:?}, q̈ = {qdd:?}",
            self.model, self.law, self.found, self.allowed, self.index, self.seed
        )
    }
}

/// The same text as `Display`, so that `unwrap` in a test prints a readable message.
impl fmt::Debug for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl core::error::Error for Violation {}

/// The margin of every law: the largest defect over all states, relative to the allowed defect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Each law with its worst ratio of found to allowed, in the order of checking; every ratio is at most 1.
    pub worst: Vec<(&'static str, f64)>,
}

/// Collects the defects of one model over all states; stops at the first one that is too large.
pub(super) struct Judge<'a, const N: usize> {
    pub(super) model: &'a str,
    pub(super) states: &'a States<N>,
    pub(super) report: Report,
}

impl<'a, const N: usize> Judge<'a, N> {
    pub(super) fn new(model: &'a str, states: &'a States<N>) -> Self {
        Self { model, states, report: Report::default() }
    }

    /// Requires found ≤ allowed; NaN on either side is a violation.
    pub(super) fn require(
        &mut self,
        law: &'static str,
        sample: &Sample<N>,
        found: f64,
        allowed: f64,
    ) -> Result<(), Violation> {
        if found.is_nan() || allowed.is_nan() || found > allowed {
            return Err(Violation {
                law,
                model: self.model.to_owned(),
                seed: self.states.seed(),
                index: sample.index,
                state: (0..N).map(|i| [sample.q[i], sample.qd[i], sample.u[i], sample.qdd[i]]).collect(),
                found,
                allowed,
            });
        }
        let ratio = if found == 0.0 { 0.0 } else { found / allowed };
        match self.report.worst.iter_mut().find(|(name, _)| *name == law) {
            Some((_, worst)) => *worst = worst.max(ratio),
            None => self.report.worst.push((law, ratio)),
        }
        Ok(())
    }
}

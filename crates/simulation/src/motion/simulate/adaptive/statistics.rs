//! Counts and lengths of adaptive steps.

/// Statistics of the steps of adaptive runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepStatistics {
    /// Accepted steps.
    pub accepted: usize,
    /// Steps that were rejected because their error was too large.
    pub rejected: usize,
    /// Evaluations of the motion. An accepted explicit step takes 26, its polynomial included, and a rejected
    /// one 15. Implicit steps include those of Newton's method and of Jacobians by finite differences.
    pub evaluations: usize,
    /// The shortest step taken \[s\]; 0 before the first.
    pub shortest: f64,
    /// The longest \[s\].
    pub longest: f64,
}

impl StepStatistics {
    /// Adds the statistics of later steps.
    pub(super) fn add(&mut self, later: &Self) {
        if later.accepted > 0 {
            self.shortest =
                if self.accepted == 0 { later.shortest } else { self.shortest.min(later.shortest) };
            self.longest = self.longest.max(later.longest);
        }
        self.accepted += later.accepted;
        self.rejected += later.rejected;
        self.evaluations += later.evaluations;
    }
}

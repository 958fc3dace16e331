//! Whether the file's physics is all in the model.

use crate::LoadReport;

use super::check::Check;

/// No physics of the file was ignored.
pub(super) fn ignored_physics(report: &LoadReport) -> Check {
    let ignored = report.counts.ignored_physics;
    let first = report.ignored_physics().next();
    let place =
        first.map_or_else(String::new, |finding| format!("line {}: {}", finding.line(), finding.place()));
    Check::new("load", "physics in the file that is not read", (ignored as f64, 0.0), place)
}

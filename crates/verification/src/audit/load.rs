//! Completeness of the model relative to the file.

use robot_dynamics_description::LoadReport;

use super::check::Check;

/// Checks that no physics of the file was ignored.
pub(super) fn ignored_physics(report: &LoadReport) -> Check {
    let ignored = report.counts.ignored_physics;
    let first = report.ignored_physics().next();
    let place =
        first.map_or_else(String::new, |finding| format!("line {}: {}", finding.line(), finding.place()));
    Check::new("load", "physics in the file that is not read", (ignored as f64, 0.0), place)
}

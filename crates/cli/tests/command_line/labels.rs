//! The words beside the numbers that tests read from a summary. The rest of the wording is in
//! `tests/snapshots`.

/// Energy drift relative to |E0|.
pub(crate) const DRIFT: &str = "max |E − E0| / |E0|: ";
/// Energy drift relative to the largest K, if E0 is small.
pub(crate) const DRIFT_OF_KINETIC: &str = "max |E − E0| / max K: ";
/// Energy residual of a motion with motors or losses.
pub(crate) const UNACCOUNTED: &str = "max |E − E0 − in + out| / energy moved: ";
/// Energy losses.
pub(crate) const STOPS: &str = " J, stops ";
pub(crate) const FRICTION: &str = "losses: damping and friction ";
pub(crate) const FRICTION_AMONG_OTHERS: &str = " J, friction ";
/// The distance from the goal at the end.
pub(crate) const FROM_GOAL: &str = "from its goal at the end: ";
/// The number of evaluations of adaptive steps.
pub(crate) const EVALUATIONS: &str = "rejected, ";
/// The depth of contacts \[m\].
pub(crate) const DEEPEST: &str = "largest penetration after a step: ";
/// Follows a depth \[m\].
pub(crate) const BELOW_GROUND: &str = " m below the ground";
/// The last row of the table of ground forces.
pub(crate) const TOTAL_FORCE: &str = "total";
/// The time of an interruption, and of a failure.
pub(crate) const INTERRUPTED: &str = "interrupted at t = ";
pub(crate) const FAILED: &str = " at t = ";
pub(crate) const FAILED_TO_WRITE: &str = " from t = ";
/// Results of `convert`.
pub(crate) const MASS_DIFFERENCE: &str = "M agrees to ";
pub(crate) const LOST_PHYSICS: &str = "physics lost: ";

/// The number after `mark`.
#[track_caller]
pub(crate) fn number_after(text: &str, mark: &str) -> f64 {
    let rest = text.split_once(mark).unwrap_or_else(|| panic!("no {mark:?} in\n{text}")).1;
    let end = rest.find(|c: char| !"0123456789.e+-".contains(c)).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after {mark:?} in\n{text}"))
}

/// The number before `mark`.
#[track_caller]
pub(crate) fn number_before(text: &str, mark: &str) -> f64 {
    let before = text.split(mark).next().unwrap();
    before
        .split_whitespace()
        .next_back()
        .unwrap()
        .parse()
        .unwrap_or_else(|_| panic!("no number before {mark:?}"))
}

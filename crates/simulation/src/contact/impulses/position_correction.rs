//! The position correction after a step, which removes penetrations.

use robot_dynamics_core::factorization::paths::Paths;
use robot_dynamics_core::factorization::sparse::NONE;
use robot_dynamics_core::{Model, Workspace};

use super::contact_state::ActiveContact;
use super::contact_state::InitialContact;
use super::corrected_row::CorrectedRow;
use super::{ContactImpulses, ImpulsiveStep, STUCK, Set, ShapePoint, returns};
use crate::contact::ContactSet;
use crate::placement::Placement;

/// Penetrations that are rounding, before and after the correction; the correction moves along curves \[m or
/// rad\].
pub const ROUNDING: [f64; 2] = [1e-12, 1e-10];

/// Stops farther away than this are left out: the correction moves less, or they take part in the next one
/// \[rad or m\].
const FAR: f64 = 0.1;

/// Contacts closer than this take part in the correction of another \[m\].
pub(super) const NEAR: f64 = 1e-4;

/// The multiplier of a row that can only push, and of a row that pushes and pulls.
const HALF_LINE: Set = Set::Interval(0.0, f64::INFINITY);
const LINE: Set = Set::Interval(f64::NEG_INFINITY, f64::INFINITY);

/// A stop, for `ContactImpulses::lift`.
#[derive(Clone, Copy, Debug)]
pub struct Bound<'a> {
    /// The coordinates of its row with their factors.
    pub terms: &'a [(usize, f64)],
    /// The side of the row that the stop is on, and its distance.
    pub sign: f64,
    pub(crate) gap: f64,
    /// Whether it was active in this step. Then the correction of others must not open it: from there it
    /// would fall back and displace others again, which would add energy.
    pub holds: bool,
    /// Whether it was violated at the start of the step.
    pub was_violated: bool,
    /// The number of its row, if its factors depend on q.
    pub moving: Option<usize>,
}

/// An equality, for `ContactImpulses::lift`.
#[derive(Clone, Copy, Debug)]
pub struct Equal<'a> {
    /// The coordinates of its row with their factors.
    pub terms: &'a [(usize, f64)],
    /// The part of its error to remove.
    pub(crate) gap: f64,
    /// Whether it was violated at the start of the step.
    pub was_violated: bool,
    /// The number of its row.
    pub row: usize,
}

impl ContactImpulses {
    /// Computes the displacement M̂⁻¹Aᵀp of q₁ that removes penetrations, violated bounds and the errors of
    /// equalities, up to rounding. Violations at the start of the step are corrected over several steps.
    /// Returns false if no displacement is needed.
    pub(crate) fn lift<'a>(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        ImpulsiveStep { h, paths, matrix }: ImpulsiveStep<'_>,
        (q1, rounding): (&[f64], f64),
        (bounds, equal): (impl Iterator<Item = Bound<'a>> + Clone, impl Iterator<Item = Equal<'a>> + Clone),
        change: &mut [f64],
    ) -> bool {
        let mut has_to_move = bounds.clone().any(|bound| bound.gap < -rounding)
            || equal.clone().any(|equal| equal.gap.abs() > rounding);
        let kept = returns(h);
        let is_below = self.find_penetrations(model, workspace, q1, kept, rounding);
        if !(is_below || has_to_move) {
            return false;
        }
        has_to_move |= self.add_penetration_rows(model, kept, rounding);
        if !has_to_move {
            return false;
        }
        let contacts = self.lifts.start.len();
        self.add_bound_rows((bounds, equal), rounding);
        // An ill-conditioned correction is skipped.
        if self.solve_lift((paths, matrix), contacts) && self.lifts.x.iter().all(|x| x.is_finite()) {
            change.copy_from_slice(&self.lifts.x);
            return true;
        }
        false
    }

    /// Finds the contacts at q₁, and the deepest penetration. Returns whether one has to be corrected.
    fn find_penetrations(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q1: &[f64],
        kept: f64,
        rounding: f64,
    ) -> bool {
        let Self { set, start, placement, active, begun, depth, .. } = self;
        placement.set(model, workspace, q1);
        set.find_near(model, placement, NEAR);
        let set = &*set;
        active.clear();
        let mut is_below = false;
        *depth = 0.0;
        set.for_each_contact(placement, NEAR, |point| {
            *depth = depth.max(-point.gap);
            is_below |=
                point.gap < -rounding && point.gap - allowed(set, start, begun, kept, &point) < -rounding;
            active.push(ActiveContact::new(point, NONE, None));
        });
        is_below
    }

    /// Starts the problem with the rows of the contacts. Returns whether one of them has to be corrected.
    fn add_penetration_rows(&mut self, model: &Model, kept: f64, rounding: f64) -> bool {
        let Self { set, lifts: problem, start, placement, active, begun, lifted, .. } = self;
        let mut has_to_move = false;
        problem.clear();
        lifted.clear();
        for ActiveContact { point, .. } in &*active {
            let allowed = allowed(set, start, begun, kept, point);
            let gap = point.gap - allowed;
            lifted.push(CorrectedRow { is_from_start: allowed < 0.0, ..CorrectedRow::default() });
            let row = problem.push(HALF_LINE, 1, set.coordinates(point).iter().copied());
            let (support, entries) = problem.last();
            set.each_relative_motion(model, placement, point, |dof, velocity, _| {
                if let Ok(column) = support.binary_search(&dof.coordinate) {
                    entries[column] += dof.ratio * point.axes[0].dot(&velocity);
                }
            });
            // A fixed point stays in place.
            let is_stuck = entries.iter().all(|entry| entry.abs() < STUCK);
            if is_stuck {
                entries.fill(0.0);
            } else {
                problem.start[row] = gap;
                has_to_move |= gap < -rounding;
            }
            problem.set_due(!is_stuck && gap < -rounding);
        }
        has_to_move
    }

    /// Adds the rows of the bounds and equalities.
    fn add_bound_rows<'a>(
        &mut self,
        (bounds, equal): (impl Iterator<Item = Bound<'a>>, impl Iterator<Item = Equal<'a>>),
        rounding: f64,
    ) {
        let Self { lifts: problem, lifted, .. } = self;
        for Bound { terms, sign, gap, holds, was_violated, moving } in bounds.filter(|bound| bound.gap < FAR)
        {
            let moving = moving.map(|row| (row, sign));
            lifted.push(CorrectedRow { is_from_start: was_violated, is_equality: false, moving });
            let row = problem.push_row(if holds { LINE } else { HALF_LINE }, sign, terms);
            problem.start[row] = if holds { gap.min(0.0) } else { gap };
            problem.set_due(gap < -rounding);
        }
        for Equal { terms, gap, was_violated, row: number } in equal {
            let moving = Some((number, 1.0));
            lifted.push(CorrectedRow { is_from_start: was_violated, is_equality: true, moving });
            let row = problem.push_row(LINE, 1.0, terms);
            problem.start[row] = gap;
            problem.set_due(gap.abs() > rounding);
        }
    }

    /// Solves the problem with this M̂. The rows from `contacts` on are those of bounds and equalities.
    fn solve_lift(&mut self, (paths, matrix): (&Paths, &[f64]), contacts: usize) -> bool {
        let Self { lifts: problem, joined, .. } = self;
        if problem.find_islands(paths.dof_parent()) {
            problem.set_packed_matrix((paths, matrix), paths.dof_parent());
            return problem.solve_islands();
        }
        joined.clear();
        joined.extend_from_slice(paths.dof_parent());
        problem.couple_from(contacts, joined);
        let joined = core::mem::take(&mut self.joined);
        self.couple(&joined);
        self.joined = joined;
        self.lifts.set_packed_matrix((paths, matrix), &self.dof_parent);
        self.lifts.solve_rigid()
    }
}

/// The remaining part of a penetration at the start of the step, which is allowed.
fn allowed(
    set: &ContactSet,
    start: &Placement,
    begun: &[InitialContact],
    kept: f64,
    point: &ShapePoint,
) -> f64 {
    let known = begun.binary_search_by_key(&point.number, |begun| begun.number);
    let before = known.map_or_else(|_| set.point(start, point.number).gap, |known| begun[known].gap);
    kept * before.min(0.0)
}

//! Positions after a step: what is below the ground is lifted out of it.

use super::{Active, ContactImpulses, ImpulsiveStep, STUCK, Set, TouchingPoint, returns};
use crate::factor::sparse::NONE;
use crate::{Model, Workspace};

/// Depth that is rounding, before what is below was lifted, and afterwards, when the way was bent \[m or rad\].
pub(crate) const ROUNDING: [f64; 2] = [1e-12, 1e-10];

/// Stops further away than this do not take part: what is lifted out moves less, or they take part the next time \[rad or m\].
const FAR: f64 = 0.1;

/// Contacts this near take part when another is moved \[m\].
pub(super) const NEAR: f64 = 1e-4;

/// A stop, as [`ContactImpulses::lift`] sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound<'a> {
    /// The coordinates of its row with their factors.
    pub(crate) terms: &'a [(usize, f64)],
    /// On which side of the row it is, and how far.
    pub(crate) sign: f64,
    pub(crate) gap: f64,
    /// Whether it held its row in this step: then what moves others moves nothing away from it. From there it would fall back, move others
    /// away, and so on: energy from nowhere.
    pub(crate) holds: bool,
}

impl ContactImpulses {
    /// How q₁ has to move, by M̂⁻¹Aᵀp, so that nothing is below the ground or beyond the given bounds, and the gaps of equalities are none, but for
    /// rounding. What started below comes back over some time. False where nothing has to.
    pub(crate) fn lift<'a>(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        ImpulsiveStep { h, paths, matrix }: ImpulsiveStep<'_>,
        (q1, rounding): (&[f64], f64),
        (bounds, equal): (
            impl Iterator<Item = Bound<'a>> + Clone,
            impl Iterator<Item = (&'a [(usize, f64)], f64)> + Clone,
        ),
        change: &mut [f64],
    ) -> bool {
        let kept = returns(h);
        let Self { set, lifts: problem, start, placement, active, begun, joined, depth, .. } = self;
        placement.set(model, workspace, q1);
        set.find_near(model, placement, NEAR);
        let set = &*set;
        active.clear();
        let mut has_to_move = bounds.clone().any(|bound| bound.gap < -rounding)
            || equal.clone().any(|(_, gap)| gap.abs() > rounding);
        let mut is_below = false;
        *depth = 0.0;
        // What is left of where a point started below comes off its depth.
        let allowed = |point: &TouchingPoint| {
            let known = begun.binary_search_by_key(&point.number, |begun| begun.number);
            let before = known.map_or_else(|_| set.point(start, point.number).gap, |known| begun[known].gap);
            kept * before.min(0.0)
        };
        set.look_around(placement, NEAR, |point| {
            *depth = depth.max(-point.gap);
            is_below |= point.gap < -rounding && point.gap - allowed(&point) < -rounding;
            active.push(Active::new(point, NONE, None));
        });
        if !(is_below || has_to_move) {
            return false;
        }
        problem.clear();
        let half_line = Set::Interval(0.0, f64::INFINITY);
        let line = Set::Interval(f64::NEG_INFINITY, f64::INFINITY);
        for Active { point, .. } in &*active {
            let gap = point.gap - allowed(point);
            let row = problem.push(half_line, 1, set.coordinates(point).iter().copied());
            let (support, entries) = problem.last();
            set.each_relative_motion(model, placement, point, |dof, velocity, _| {
                if let Ok(column) = support.binary_search(&dof.coordinate) {
                    entries[column] += dof.ratio * point.axes[0].dot(&velocity);
                }
            });
            // What does not move stays where it is.
            let is_stuck = entries.iter().all(|entry| entry.abs() < STUCK);
            if is_stuck {
                entries.fill(0.0);
            } else {
                problem.start[row] = gap;
                has_to_move |= gap < -rounding;
            }
            problem.set_due(!is_stuck && gap < -rounding);
        }
        if !has_to_move {
            return false;
        }
        let contacts = problem.start.len();
        for Bound { terms, sign, gap, holds } in bounds.filter(|bound| bound.gap < FAR) {
            let row = problem.push_row(if holds { line } else { half_line }, sign, terms);
            problem.start[row] = if holds { gap.min(0.0) } else { gap };
            problem.set_due(gap < -rounding);
        }
        for (terms, gap) in equal {
            let row = problem.push_row(line, 1.0, terms);
            problem.start[row] = gap;
            problem.set_due(gap.abs() > rounding);
        }
        let is_solved = if problem.find_islands(paths.carrier()) {
            problem.take_packed((paths, matrix), paths.carrier());
            problem.solve_islands()
        } else {
            joined.clear();
            joined.extend_from_slice(paths.carrier());
            problem.couple_from(contacts, joined);
            let joined = core::mem::take(&mut self.joined);
            self.couple(&joined);
            self.joined = joined;
            self.lifts.take_packed((paths, matrix), &self.carrier);
            self.lifts.solve_rigid()
        };
        // What is too ill-conditioned to be lifted stays where it is.
        if is_solved && self.lifts.x.iter().all(|x| x.is_finite()) {
            change.copy_from_slice(&self.lifts.x);
            return true;
        }
        false
    }
}

//! Positions after a step: what is below the ground is lifted out of it.

use super::{
    Active, ContactImpulses, ImpulsiveStep, MOST_ROWS, STUCK, Set, add_joint, couple_terms, returns,
};
use crate::{Model, Workspace};

/// Depth that is rounding, before what is below was lifted, and afterwards, when the way was bent \[m or rad\].
pub(crate) const ROUNDING: [f64; 2] = [1e-12, 1e-10];

/// Stops further away than this do not take part: what is lifted out moves less, or they take part the next time \[rad or m\].
const FAR: f64 = 0.1;

/// Contacts this near take part when another is moved \[m\].
const NEAR: f64 = 1e-4;

impl ContactImpulses {
    /// How q₁ has to move, by M̂⁻¹Aᵀp, so that nothing is below the ground or beyond the given bounds, each a row of coordinates, a sign
    /// and a gap, and the gaps of equalities are none, but for rounding. What started below comes back over some time. False where nothing has to.
    pub(crate) fn lift<'a>(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        ImpulsiveStep { h, matrix, carrier }: ImpulsiveStep<'_>,
        (q1, rounding): (&[f64], f64),
        (bounds, equal): (
            impl Iterator<Item = (&'a [(usize, f64)], f64, f64)>,
            impl Iterator<Item = (&'a [(usize, f64)], f64)>,
        ),
        change: &mut [f64],
    ) -> bool {
        let kept = returns(h);
        let Self { set, lifts: problem, start, placement, active, joined, .. } = self;
        placement.set(model, workspace, q1);
        problem.clear();
        active.clear();
        let mut is_below = false;
        set.look_around(placement, NEAR, |mut point| {
            point.gap -= kept * set.point(start, point.number).gap.min(0.0);
            active.push(Active { point, row: 0, rows: 1, scale: [1.0; MOST_ROWS], bias: 0.0 });
        });
        let half_line = Set::Interval(0.0, f64::INFINITY);
        for Active { point, .. } in &*active {
            let row = problem.push(half_line, 1, set.coordinates(point).iter().copied());
            let (support, entries) = problem.last();
            set.each_relative_motion(model, placement, point, |dof, velocity, _| {
                if let Ok(column) = support.binary_search(&dof.coordinate) {
                    entries[column] += dof.ratio * point.axes[0].dot(&velocity);
                }
            });
            // What does not move stays where it is.
            if entries.iter().all(|entry| entry.abs() < STUCK) {
                entries.fill(0.0);
            } else {
                problem.start[row] = point.gap;
                is_below |= point.gap < -rounding;
            }
        }
        joined.clear();
        joined.extend_from_slice(carrier);
        for (terms, sign, gap) in bounds.filter(|(.., gap)| *gap < FAR) {
            is_below |= gap < -rounding;
            let row = add_joint(problem, terms, sign, half_line);
            couple_terms(joined, terms);
            problem.start[row] = gap;
        }
        for (terms, gap) in equal {
            is_below |= gap.abs() > rounding;
            let row = add_joint(problem, terms, 1.0, Set::Interval(f64::NEG_INFINITY, f64::INFINITY));
            couple_terms(joined, terms);
            problem.start[row] = gap;
        }
        if is_below {
            let joined = core::mem::take(&mut self.joined);
            self.couple(&joined);
            self.joined = joined;
        }
        let is_solved = is_below && self.lifts.solve_rigid(matrix, &self.carrier);
        // What is too ill-conditioned to be lifted stays where it is.
        if is_solved && self.lifts.x.iter().all(|x| x.is_finite()) {
            change.copy_from_slice(&self.lifts.x);
            return true;
        }
        false
    }
}

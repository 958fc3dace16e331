//! The pairs of shapes of links that may touch, and a sweep for those that are near each other. A rule
//! generates the pairs, so memory and time do not grow with the square of the number of shapes.

use nalgebra::Vector3;
use robot_dynamics_core::Model;

use super::ContactSet;
use super::candidates::{Candidates, Sweep};
use super::pair::ShapePair;
use super::soft::mixed;
use crate::placement::Placement;

/// Pairs named by a file or a user have lower numbers than this; pairs by the rule start here.
const MOST_NAMED: usize = 1 << 22;

/// Up to this number of shapes, all pairs are made at once, so that steps do not allocate.
const FEW: usize = 64;

/// The number of a pair by the rule, for shapes in increasing order.
fn number_of([one, two]: [usize; 2]) -> usize {
    MOST_NAMED + two * (two - 1) / 2 + one
}

impl ContactSet {
    /// Whether two shapes, in increasing order, may touch by the rule, regardless of their forms.
    pub(super) fn may_touch(&self, shapes: [usize; 2]) -> bool {
        let Some(candidates) = &self.candidates else { return false };
        let Candidates { links, carriers, hangs, is_scenery, excluded, only, left_out } = candidates;
        let [one, two] = shapes;
        let [a, b] = shapes.map(|index| &self.shapes[index]);
        let (x, y) = (&a.surface, &b.surface);
        a.body != b.body
            && (x.contype & y.conaffinity) | (y.contype & x.conaffinity) != 0
            && !((carriers[one] == b.body && hangs[one] && !is_scenery[two])
                || (carriers[two] == a.body && hangs[two] && !is_scenery[one]))
            && !excluded.contains(&[links[one], links[two]])
            && only.as_ref().is_none_or(|only| only.contains(&[links[one], links[two]]))
            && !left_out.contains(&shapes)
    }

    /// The shapes of the pairs by the rule, in increasing order, with a known contact search.
    pub(super) fn pairs_by_rule(&self) -> impl Iterator<Item = [usize; 2]> {
        let count = if self.candidates.is_some() { self.shapes.len() } else { 0 };
        let all = (0..count).flat_map(|two| (0..two).map(move |one| [one, two]));
        all.filter(|shapes| self.can_meet(*shapes) && self.may_touch(*shapes))
    }

    /// Adds a named pair, before all others.
    pub(super) fn add_named(&mut self, pair: ShapePair) {
        self.enter(self.sweep.named, pair);
        self.sweep.named += 1;
    }

    fn enter(&mut self, number: usize, mut pair: ShapePair) {
        pair.number = number;
        self.sweep.slots.insert(number, self.pairs.len());
        self.pairs.push(pair);
    }

    /// Keeps the pairs that satisfy the condition.
    pub(super) fn retain_pairs(&mut self, keep: impl Fn(&Self, &ShapePair) -> bool) {
        let pairs = core::mem::take(&mut self.pairs);
        self.sweep.slots.clear();
        for pair in pairs {
            if keep(self, &pair) {
                let number = pair.number;
                self.enter(number, pair);
            }
        }
    }

    /// The named pairs.
    pub(super) fn named_pairs(&self) -> impl Iterator<Item = &ShapePair> {
        self.pairs.iter().filter(|pair| pair.number < MOST_NAMED)
    }

    /// Makes all pairs if there are few shapes.
    pub(super) fn make_few_pairs(&mut self, model: &Model) {
        if self.shapes.len() <= FEW {
            for shapes in self.pairs_by_rule().collect::<Vec<_>>() {
                self.make_pair(model, shapes);
            }
            self.sweep.near.reserve(self.pairs.len());
            self.sweep.found.reserve(self.pairs.len());
            self.sweep.order.reserve(self.shapes.len());
            self.sweep.centers.reserve(self.shapes.len());
        }
    }

    /// The index of a pair by the rule, which is made if it is new.
    fn make_pair(&mut self, model: &Model, shapes: [usize; 2]) -> usize {
        let number = number_of(shapes);
        if let Some(slot) = self.sweep.slot_of(number) {
            return slot;
        }
        let [(one, a), (two, b)] = shapes.map(|index| (index, &self.shapes[index]));
        let pair = ShapePair::new(model, [(one, a.body), (two, b.body)], mixed(&a.surface, &b.surface));
        self.enter(number, pair);
        self.pairs.len() - 1
    }

    /// Makes the pair of this number, if it does not exist.
    pub(super) fn make_numbered(&mut self, model: &Model, number: usize) {
        let Some(at) = number.checked_sub(MOST_NAMED).filter(|_| self.sweep.slot_of(number).is_none()) else {
            return;
        };
        let mut two = 1;
        let mut first = 0;
        while at >= first + two {
            first += two;
            two += 1;
        }
        if two < self.shapes.len() {
            self.make_pair(model, [at - first, two]);
        }
    }

    /// Finds the pairs whose bounding balls are within this distance \[m\].
    ///
    /// The shapes are sorted along the axis of their largest spread. Each is compared with those whose ranges
    /// begin within its own.
    pub(super) fn find_near(&mut self, model: &Model, placement: &Placement, within: f64) {
        let mut sweep = core::mem::take(&mut self.sweep);
        sweep.near.clear();
        sweep.near.extend((0..self.pairs.len()).filter(|slot| self.pairs[*slot].number < MOST_NAMED));
        if self.candidates.is_some() {
            sweep.found.clear();
            self.sweep_shapes(placement, within, &mut sweep, |set, shapes| {
                set.can_meet(shapes) && set.may_touch(shapes)
            });
            sweep.found.sort_unstable();
            self.sweep.slots = core::mem::take(&mut sweep.slots);
            for (_, shapes) in &sweep.found {
                sweep.near.push(self.make_pair(model, *shapes));
            }
            sweep.slots = core::mem::take(&mut self.sweep.slots);
        }
        self.sweep = sweep;
    }

    /// The pairs of shapes by the rule whose bounding balls overlap in this placement.
    pub(super) fn overlapping_balls(
        &self,
        placement: &Placement,
        belong: impl Fn(&Self, [usize; 2]) -> bool,
    ) -> Vec<[usize; 2]> {
        let mut sweep = Sweep::default();
        self.sweep_shapes(placement, 0.0, &mut sweep, belong);
        sweep.found.sort_unstable();
        sweep.found.into_iter().map(|(_, shapes)| shapes).collect()
    }

    fn sweep_shapes(
        &self,
        placement: &Placement,
        within: f64,
        sweep: &mut Sweep,
        belong: impl Fn(&Self, [usize; 2]) -> bool,
    ) {
        let Sweep { order, centers, found, .. } = sweep;
        let shapes = &self.shapes;
        centers.clear();
        centers.extend(shapes.iter().map(|shape| {
            let (rotation, p) = placement.body(shape.body);
            p + rotation * shape.translation
        }));
        let mean = centers.iter().sum::<Vector3<f64>>() / (centers.len().max(1) as f64);
        let spread: Vector3<f64> =
            centers.iter().map(|center| (center - mean).component_mul(&(center - mean))).sum();
        let axis = spread.imax();
        let low = |shape: usize| centers[shape][axis] - shapes[shape].reach;
        if order.len() != shapes.len() {
            order.clear();
            order.extend(0..shapes.len());
        }
        order.sort_unstable_by(|a, b| low(*a).total_cmp(&low(*b)).then(a.cmp(b)));
        for (at, &first) in order.iter().enumerate().filter(|(_, first)| self.is_active(**first)) {
            let end = centers[first][axis] + shapes[first].reach + within;
            for &second in order[at + 1..].iter().take_while(|second| low(**second) <= end) {
                let reach = shapes[first].reach + shapes[second].reach + within;
                let pair = [first.min(second), first.max(second)];
                let is_near = (centers[first] - centers[second]).norm_squared() <= reach * reach;
                if is_near && self.is_active(second) && belong(self, pair) {
                    found.push((number_of(pair), pair));
                }
            }
        }
    }
}

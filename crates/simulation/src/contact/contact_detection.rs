//! A contact point of a shape.

use nalgebra::Vector3;
use robot_dynamics_core::Model;

use super::ContactSet;
use super::contact_geometry::ABOUT;
use super::contact_shape::ContactShape;
use super::pair::PairContacts;
use super::placed_pair::MOST_PAIR_POINTS;
use super::placed_shape::PlacedShape;
use super::shape_point::{ContactPartner, ShapePoint};
use crate::Ground;
use crate::placement::Placement;

/// The most points of one shape that touch one ground.
pub(super) const MOST_POINTS: usize = 1 + ABOUT.len();

impl ContactSet {
    /// Calls `visit` for each point of each shape whose gap to a ground is at most `within` \[m\].
    pub(super) fn for_each_ground_contact(
        &self,
        placement: &Placement,
        within: f64,
        mut visit: impl FnMut(ShapePoint),
    ) {
        let is_looked_at =
            |index: usize, shape: &ContactShape| shape.on_ground.is_some() && self.is_active(index);
        for (index, shape) in
            self.shapes.iter().enumerate().filter(|(index, shape)| is_looked_at(*index, shape))
        {
            let mut placed = None;
            for (ground_index, (ground, [n, ..])) in self.grounds.iter().enumerate() {
                if !self.meets_ground(index, ground_index) {
                    continue;
                }
                let (up, height) = placement.along(shape.body, n);
                let height = height + up.dot(&shape.translation) - ground.offset;
                // Most points are rejected in the body's frame, with a margin for rounding.
                let near = within + shape.reach * 1e-9;
                if height > shape.reach + near {
                    continue;
                }
                let down = -shape.rotation.tr_mul(&up);
                if height > shape.extent.dot(&down.abs()) + near {
                    continue;
                }
                let is_low = |k: &usize| {
                    shape.form.takes_part(*k, &down)
                        && height - down.dot(&shape.form.point(*k, &down)) <= near
                };
                let points = (0..shape.form.count()).filter(is_low);
                let points = points.map(|k| {
                    let placed = placed.get_or_insert_with(|| shape.placed(placement));
                    self.at_ground(placed, (index, ground_index), k, &down)
                });
                let near = points.filter(|point| point.gap <= within);
                if shape.form.count() <= MOST_POINTS {
                    near.for_each(&mut visit);
                } else {
                    let [_, s, t] = self.grounds[ground_index].1;
                    let mut outermost = ExtremePoints::new([s, t]);
                    near.for_each(|point| outermost.add(point));
                    outermost.each(&mut visit);
                }
            }
            if !self.fields.is_empty() {
                let placed = placed.unwrap_or_else(|| shape.placed(placement));
                self.for_each_field_contact((index, &placed), within, &mut visit);
            }
        }
    }

    /// Calls `visit` for these, and for the points of each pair of shapes.
    pub(super) fn for_each_contact(
        &self,
        placement: &Placement,
        within: f64,
        mut visit: impl FnMut(ShapePoint),
    ) {
        self.for_each_ground_contact(placement, within, &mut visit);
        self.for_each_pair_contact(placement, within, visit);
    }

    /// From here on, searches find only contacts of these shapes; one entry for each shape.
    pub(super) fn set_active_shapes(&mut self, is_active: impl Iterator<Item = bool>) {
        self.active.clear();
        self.active.extend(is_active);
    }

    /// Whether searches include a shape.
    #[inline]
    pub(super) fn is_active(&self, shape: usize) -> bool {
        self.active.get(shape).is_none_or(|active| *active)
    }

    /// Makes the pair of this point's number, if it does not exist.
    pub(super) fn make_touched(&mut self, model: &Model, number: usize) {
        if let Some(number) = number.checked_sub(self.ground_count()) {
            self.make_numbered(model, number / MOST_PAIR_POINTS);
        }
    }

    /// The point of this number, at any distance.
    pub(super) fn point(&self, placement: &Placement, number: usize) -> ShapePoint {
        self.point_after(placement, number, &mut None)
    }

    /// The same, with the contact points of the last point's pair cached: points of one pair are adjacent.
    pub(super) fn point_after(
        &self,
        placement: &Placement,
        number: usize,
        last: &mut Option<PairContacts>,
    ) -> ShapePoint {
        if let Some(number) = number.checked_sub(self.ground_point_count()) {
            return self.point_of_pair_after(placement, number, last);
        }
        if number >= self.points * self.grounds.len() {
            return self.point_at_field(|shape| shape.placed(placement), number);
        }
        let (ground, point) = (number / self.points, number % self.points);
        let index = self.shapes.partition_point(|shape| shape.first <= point) - 1;
        let shape = &self.shapes[index];
        let placed = shape.placed(placement);
        let (up, _) = placement.along(shape.body, &self.grounds[ground].1[0]);
        let down = -shape.rotation.tr_mul(&up);
        self.at_ground(&placed, (index, ground), point - shape.first, &down)
    }

    fn at_ground(
        &self,
        placed: &PlacedShape,
        (shape, ground): (usize, usize),
        k: usize,
        down: &Vector3<f64>,
    ) -> ShapePoint {
        let (Ground { offset, .. }, axes) = &self.grounds[ground];
        let n = &axes[0];
        let ContactShape { form, first, .. } = &self.shapes[shape];
        let at = placed.at(&form.point(k, down));
        ShapePoint {
            number: ground * self.points + first + k,
            shape,
            against: ContactPartner::Ground(ground),
            gap: n.dot(&at) - offset,
            at,
            axes: *axes,
        }
    }
}

/// The deepest of many points and the outermost in directions all around; their convex hull supports the
/// shape.
pub(super) struct ExtremePoints {
    /// Two tangential directions of the ground.
    sides: [Vector3<f64>; 2],
    best: [Option<(f64, ShapePoint)>; MOST_POINTS],
}

impl ExtremePoints {
    pub(super) fn new(sides: [Vector3<f64>; 2]) -> Self {
        Self { sides, best: [None; MOST_POINTS] }
    }

    pub(super) fn add(&mut self, point: ShapePoint) {
        let [s, t] = &self.sides;
        for (k, best) in self.best.iter_mut().enumerate() {
            let far = match k {
                0 => -point.gap,
                k => {
                    let (sin, cos) = ABOUT[k % ABOUT.len()];
                    cos * s.dot(&point.at) + sin * t.dot(&point.at)
                }
            };
            if best.is_none_or(|(farthest, _)| far > farthest) {
                *best = Some((far, point));
            }
        }
    }

    /// Calls `visit` with each point once.
    pub(super) fn each(&self, mut visit: impl FnMut(ShapePoint)) {
        for (k, (_, point)) in self.best.iter().flatten().enumerate() {
            if self.best[..k].iter().flatten().all(|(_, other)| other.number != point.number) {
                visit(*point);
            }
        }
    }
}

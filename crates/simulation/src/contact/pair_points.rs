//! The contact points of two shapes of links, numbered so that each is recognized in the next step.

use core::f64::consts::TAU;

use nalgebra::Vector3;

use super::ContactSet;
use super::closest_points::{ClosestPoints, Line};
use super::contact_geometry::ContactGeometry;
use super::ground::axes;
use super::placed_pair::{MOST_PAIR_POINTS, PlacedPair};
use super::placed_shape::PlacedShape;

/// The rotation of these directions. None is perpendicular to an edge along an axis, whose two ends would be
/// equally far out \[rad\].
const ODD: f64 = 0.3;

impl ContactSet {
    /// The contact points of two shapes; for shapes other than balls and capsules only if some are within
    /// this distance \[m\].
    pub(super) fn meeting(&self, shapes: [usize; 2], placed: &[PlacedShape; 2], within: f64) -> PlacedPair {
        let [one, two] = shapes.map(|shape| &self.shapes[shape]);
        if let (Some(one), Some(two)) = (line(&one.form, &placed[0]), line(&two.form, &placed[1])) {
            return PlacedPair::Lines([one, two]);
        }
        let mut best = [const { None }; MOST_PAIR_POINTS];
        if let (Some(one), Some(two)) = (&one.convex, &two.convex) {
            one.meet(two, placed, within, |point| choose(&mut best, point, &placed[0]));
        }
        let mut points = best.map(|best: Option<(f64, ClosestPoints)>| best.map(|(_, point)| (point, true)));
        // Rounding decides which point is the deepest, so it has the number of the deepest only if it is not
        // one of the outermost.
        for k in (0..MOST_PAIR_POINTS).rev() {
            let before = if k == 0 { 1..MOST_PAIR_POINTS } else { 1..k };
            let is_known =
                |point: ClosestPoints| points[before].iter().flatten().any(|(other, _)| other.at == point.at);
            let is_first = points[k].is_some_and(|(point, _)| !is_known(point));
            if let Some((_, first)) = &mut points[k] {
                *first = is_first;
            }
        }
        PlacedPair::Points(points)
    }
}

/// Keeps a point if it is the deepest, or the farthest out. The directions turn with the first shape.
fn choose(
    best: &mut [Option<(f64, ClosestPoints)>; MOST_PAIR_POINTS],
    point: ClosestPoints,
    first: &PlacedShape,
) {
    let [_, s, t] = axes(first.rotation.tr_mul(&point.normal));
    let at = first.rotation.tr_mul(&(point.at - first.center));
    for (k, best) in best.iter_mut().enumerate() {
        let far = match k {
            0 => -point.gap,
            k => {
                let (sin, cos) = (ODD + k as f64 * TAU / (MOST_PAIR_POINTS - 1) as f64).sin_cos();
                cos * s.dot(&at) + sin * t.dot(&at)
            }
        };
        if best.as_ref().is_none_or(|(farthest, _)| far > *farthest) {
            *best = Some((far, point));
        }
    }
}

fn line(form: &ContactGeometry, placed: &PlacedShape) -> Option<Line> {
    let ContactGeometry::Rounded { centers, radius } = form else { return None };
    if !form.is_line() {
        return None;
    }
    let at = |center: &Vector3<f64>| placed.center + placed.rotation * center;
    Some(Line { ends: [at(centers.first()?), at(centers.last()?)], radius: *radius })
}

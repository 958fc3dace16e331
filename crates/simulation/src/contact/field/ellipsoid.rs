//! Balls and ellipsoids at a height field: the nearest point on a face, an edge or a corner.

use nalgebra::{Matrix3, Vector3};

use super::closest_points::{mixed, nearest};
use super::facets::Facets;

/// The most faces that one ball can be near at once.
pub(super) const MOST_NEAR: usize = 16;

/// The distance below which two points are equal, as a fraction of the half axes.
const SAME: f64 = 1e-12;

/// A ball or an ellipsoid in the field's frame: x = center + R D y with |y| ≤ 1, D its half axes.
///
/// Distances are measured in y, where the shape is a ball: they determine exactly whether and where it
/// touches.
pub(super) struct PlacedEllipsoid {
    pub(super) center: Vector3<f64>,
    /// R.
    pub(super) rotation: Matrix3<f64>,
    /// D.
    pub(super) half_axes: Vector3<f64>,
}

/// The nearest point on one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrianglePoint {
    pub(super) triangle: usize,
    /// |y|.
    distance: f64,
    /// \[m\].
    pub(super) gap: f64,
    /// On an edge or a corner: the point of the shape, and the normal into the shape.
    pub(super) edge: Option<[Vector3<f64>; 2]>,
    /// The point of the field.
    on_field: Vector3<f64>,
}

impl PlacedEllipsoid {
    /// The corners of a triangle in y.
    fn scaled(&self, corners: [Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
        corners.map(|corner| self.rotation.tr_mul(&(corner - self.center)).component_div(&self.half_axes))
    }

    /// `None` if the centre is behind the triangle.
    pub(super) fn near(&self, facets: &Facets, triangle: usize) -> Option<TrianglePoint> {
        let plane = facets.plane(triangle);
        let above = plane.gap(&self.center);
        if above < 0.0 {
            return None;
        }
        let corners = facets.corners(triangle);
        let shares = nearest(&self.scaled(corners));
        let on_field = mixed(&corners, shares);
        let y = self.rotation.tr_mul(&(on_field - self.center)).component_div(&self.half_axes);
        let distance = y.norm();
        // The point for the whole plane is |D Rᵀn| from the centre.
        let extent = self.rotation.tr_mul(&plane.normal).component_mul(&self.half_axes).norm();
        let to_plane = above / extent;
        if distance - to_plane <= 0.1 * SAME * (1.0 + to_plane) {
            return Some(TrianglePoint { triangle, distance, gap: above - extent, edge: None, on_field });
        }
        // The normal is D⁻¹y; the gap is exact at 0, and everywhere for a ball.
        let slope = y.component_div(&self.half_axes);
        let size = slope.norm();
        let gap = (distance - 1.0) * distance / size;
        let at = self.center + self.rotation * y.component_mul(&self.half_axes) / distance;
        let normal = self.rotation * slope / -size;
        Some(TrianglePoint { triangle, distance, gap, edge: Some([at, normal]), on_field })
    }

    /// The nearest point of each face within this distance \[m\]; the nearest faces first if there are too
    /// many.
    pub(super) fn near_faces(&self, facets: &Facets, within: f64) -> [Option<TrianglePoint>; MOST_NEAR] {
        let mut found = [None::<TrianglePoint>; MOST_NEAR];
        for triangle in facets.within(&self.center, self.half_axes.max() + within) {
            let Some(near) = self.near(facets, triangle).filter(|near| near.gap <= within) else { continue };
            let face = facets.of[triangle];
            let known = found.iter().position(|one| one.is_some_and(|one| facets.of[one.triangle] == face));
            let slot = known.or_else(|| found.iter().position(Option::is_none)).unwrap_or_else(|| {
                let far = |one: &Option<TrianglePoint>| one.map_or(f64::INFINITY, |one| one.distance);
                let farthest = (0..MOST_NEAR).max_by(|&a, &b| far(&found[a]).total_cmp(&far(&found[b])));
                farthest.unwrap_or(0)
            });
            if found[slot].is_none_or(|one| near.distance < one.distance) {
                found[slot] = Some(near);
            }
        }
        found
    }

    /// Whether no other triangle that contains this point is nearer, even from behind. Among equal ones, the
    /// first face counts.
    pub(super) fn is_least(&self, facets: &Facets, near: &TrianglePoint) -> bool {
        let face = facets.of[near.triangle];
        facets.within(&near.on_field, facets.rounding).all(|other| {
            if facets.of[other] == face {
                return true;
            }
            let corners = facets.corners(other);
            let shares = nearest(&corners.map(|corner| corner - near.on_field));
            if (mixed(&corners, shares) - near.on_field).norm() > facets.rounding {
                return true;
            }
            let scaled = self.scaled(corners);
            let nearer = near.distance - mixed(&scaled, nearest(&scaled)).norm();
            let is_behind = || facets.plane(other).gap(&self.center) < 0.0;
            nearer <= SAME && (nearer < -SAME || face < facets.of[other] || is_behind())
        })
    }
}

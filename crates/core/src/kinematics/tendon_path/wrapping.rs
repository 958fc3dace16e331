//! The shortest path between two points around a sphere or a cylinder.

use core::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};
use robot_dynamics_description::TendonSurface;

type Point2 = Vector2<f64>;

/// The part of a path on a surface: its ends, and its length \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wrap {
    pub(super) ends: [Vector3<f64>; 2],
    pub(super) length: f64,
}

/// Lengths below this count as zero.
const SMALLEST: f64 = 1e-15;

/// The part of the path from `a` to `b` on a surface of this radius about the origin, a cylinder's axis along
/// z. `None` if the straight line is the path, or a point is inside the surface.
///
/// With a point `side` outside the surface, the path goes around the surface as the way from `a` by this
/// point to `b` does. A point inside makes the path touch the surface from inside. The rules for both are
/// those of MuJoCo 4.0.0.
pub(super) fn wrap(
    surface: TendonSurface,
    radius: f64,
    [a, b]: [Vector3<f64>; 2],
    side: Option<Vector3<f64>>,
) -> Option<Wrap> {
    if radius < SMALLEST || a.norm() < SMALLEST || b.norm() < SMALLEST {
        return None;
    }
    let [x, y] = match surface {
        TendonSurface::Sphere => plane_through(&a, &b),
        TendonSurface::Cylinder => [Vector3::x(), Vector3::y()],
    };
    let project = |p: &Vector3<f64>| Point2::new(p.dot(&x), p.dot(&y));
    let (flat_a, flat_b) = (project(&a), project(&b));
    let arc = match side {
        Some(side) if side.norm() < radius => touch_inside([flat_a, flat_b], radius),
        _ => around([flat_a, flat_b], side.as_ref().map(project), radius),
    }?;
    let mut ends = arc.ends.map(|end| x * end.x + y * end.y);
    let mut length = arc.length;
    if surface == TendonSurface::Cylinder {
        // The path is a helix: its height grows evenly along the flat path.
        let (before, after) = ((arc.ends[0] - flat_a).norm(), (arc.ends[1] - flat_b).norm());
        let slope = (b.z - a.z) / (before + length + after);
        ends[0].z = a.z + slope * before;
        ends[1].z = a.z + slope * (before + length);
        length = length.hypot(ends[1].z - ends[0].z);
    }
    Some(Wrap { ends, length })
}

/// Two orthogonal unit vectors of the plane through the origin and two points, the first one toward `a`.
fn plane_through(a: &Vector3<f64>, b: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let x = a.normalize();
    let mut normal = a.cross(b);
    if normal.norm() < SMALLEST {
        // Any plane through the line will do.
        let mut other = Vector3::repeat(1.0);
        other[x.iamax()] = 0.0;
        normal = x.cross(&other);
    }
    [x, normal.normalize().cross(&x)]
}

/// A part of a circle about the origin.
struct Arc {
    ends: [Point2; 2],
    length: f64,
}

/// The arc of the shortest path around a circle, or of the path on the given side.
fn around([a, b]: [Point2; 2], side: Option<Point2>, radius: f64) -> Option<Arc> {
    let way = b - a;
    if a.norm() < radius || b.norm() < radius || way.norm_squared() < SMALLEST {
        return None;
    }
    if let Some(side) = side {
        return around_side([a, b], side, radius);
    }
    let nearest = a + way * (-a.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
    if nearest.norm() > radius {
        return None;
    }
    let [clockwise, counterclockwise] = [-1.0, 1.0].map(|turn| tangent_points([a, b], radius, turn));
    let merit = |ends: &[Point2; 2]| {
        if is_crossing([a, ends[0]], [b, ends[1]]) {
            return f64::NEG_INFINITY;
        }
        -(ends[0] - ends[1]).norm_squared()
    };
    let (turn, ends) = if merit(&clockwise) > merit(&counterclockwise) {
        (-1.0, clockwise)
    } else {
        (1.0, counterclockwise)
    };
    if merit(&ends) == f64::NEG_INFINITY {
        return None;
    }
    let angle = ends[0].perp(&ends[1]).atan2(ends[0].dot(&ends[1]));
    Some(Arc { ends, length: radius * (turn * angle).rem_euclid(TAU) })
}

/// The arc of the shortest path that turns about the center as much as the way from `a` by `side` to `b`.
///
/// The tangents turn by acos(r/|a|) and acos(r/|b|). The arc turns by the rest; without a rest the straight
/// line is the path.
fn around_side([a, b]: [Point2; 2], side: Point2, radius: f64) -> Option<Arc> {
    let side = side.try_normalize(SMALLEST).unwrap_or_else(Point2::x);
    let turned = |from: &Point2, to: &Point2| from.perp(to).atan2(from.dot(to));
    let of_tangent = |p: &Point2| (p.norm_squared() - radius * radius).max(0.0).sqrt().atan2(radius);
    let winding = turned(&a, &side) + turned(&side, &b);
    let angle = winding.abs() - of_tangent(&a) - of_tangent(&b);
    let ends = tangent_points([a, b], radius, winding.signum());
    (angle > 0.0).then_some(Arc { ends, length: radius * angle })
}

/// The points where the tangents from `a` and to `b` meet the circle, if the path runs counterclockwise
/// around it (`turn` 1) or clockwise (−1).
fn tangent_points([a, b]: [Point2; 2], radius: f64, turn: f64) -> [Point2; 2] {
    let point = |p: Point2, turn: f64| {
        let square = p.norm_squared();
        let along = radius * radius / square;
        let across = turn * radius * (square - radius * radius).max(0.0).sqrt() / square;
        p * along + Point2::new(-p.y, p.x) * across
    };
    [point(a, turn), point(b, -turn)]
}

/// Whether two segments have a common point. Parallel ones count as having none.
fn is_crossing([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> bool {
    let (first, second, between) = (b - a, d - c, c - a);
    let determinant = first.perp(&second);
    if determinant.abs() < SMALLEST {
        return false;
    }
    let (s, t) = (between.perp(&second) / determinant, between.perp(&first) / determinant);
    (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)
}

/// The point of a circle that the shortest path via the circle touches, as an arc without length. `None` if
/// the straight line meets the circle.
///
/// At that point both lines have the same angle φ to the normal. By the law of sines, the directions of `a`
/// and `b` then differ by 2φ − asin(sin φ r/|a|) − asin(sin φ r/|b|), which grows with φ.
fn touch_inside([a, b]: [Point2; 2], radius: f64) -> Option<Arc> {
    let way = b - a;
    if a.norm() <= radius || b.norm() <= radius {
        return None;
    }
    let share = -a.dot(&way) / way.norm_squared();
    if share > 0.0 && share < 1.0 && (a + way * share).norm() <= radius {
        return None;
    }
    let between = a.perp(&b).atan2(a.dot(&b));
    let excess = |phi: f64| {
        let of = |p: &Point2| phi - (phi.sin() * radius / p.norm()).asin();
        of(&a) + of(&b) - between.abs()
    };
    let (mut low, mut high) = (0.0, core::f64::consts::FRAC_PI_2);
    if excess(high) < 0.0 {
        return None;
    }
    // Bisection to the last bit.
    while low < 0.5 * (low + high) && 0.5 * (low + high) < high {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let phi = 0.5 * (low + high);
    let angle = (phi - (phi.sin() * radius / a.norm()).asin()) * between.signum();
    let (sine, cosine) = angle.sin_cos();
    let toward = a.normalize();
    let end = Point2::new(cosine * toward.x - sine * toward.y, sine * toward.x + cosine * toward.y) * radius;
    Some(Arc { ends: [end, end], length: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a circle between two tangents of length 1.
    #[test]
    fn a_path_around_a_cylinder_is_two_tangents_and_a_helix() {
        let (a, b) = (Vector3::new(1.0, -1.0, 0.0), Vector3::new(-1.0, 1.0, 3.0));
        let side = Some(Vector3::new(5.0, 5.0, 0.0));
        let found = wrap(TendonSurface::Cylinder, 1.0, [a, b], side).expect("a wrap");
        let flat = 2.0 + TAU / 4.0;
        let height = 3.0 * (TAU / 4.0) / flat;
        assert!((found.length - (TAU / 4.0).hypot(height)).abs() < 1e-15);
        assert!((found.ends[0] - Vector3::new(1.0, 0.0, 3.0 / flat)).norm() < 1e-15);
        // The whole path is a straight line on the unrolled surface.
        let total = (found.ends[0] - a).norm() + found.length + (found.ends[1] - b).norm();
        assert!((total - flat.hypot(3.0)).abs() < 1e-14);
    }

    /// Lengths of MuJoCo 4.0.0. The straight line passes the cylinder on the side of the first point, or away
    /// from a side that the path does not turn about; the last path turns by more than half a turn.
    #[test]
    fn a_path_turns_about_a_cylinder_as_the_way_by_its_side_does() {
        for (a, b, side, length) in [
            ([2.0, 1.5], [-2.5, 1.25], [0.0, 1.2], 4.506_939_094_329_986_5),
            ([2.0, 1.5], [-2.5, 1.25], [0.0, -1.2], 6.785_909_708_017_952),
            ([3.96, -10.9], [3.8, 3.08], [0.0, -1.04], 13.980_915_563_724_716),
            ([1.5, 0.5], [1.5, -0.5], [-1.2, 0.1], 6.317_019_693_584_253),
            ([2.0, -0.5], [-2.0, -0.25], [0.3, 1.1], 4.947_700_053_065_644),
        ] {
            let [a, b, side] = [a, b, side].map(|[x, y]: [f64; 2]| Vector3::new(x, y, 0.0));
            let found = wrap(TendonSurface::Cylinder, 1.0, [a, b], Some(side));
            let total = found.map_or((b - a).norm(), |found| {
                (found.ends[0] - a).norm() + found.length + (found.ends[1] - b).norm()
            });
            assert!((total - length).abs() < 1e-14 * length, "{total}, not {length}");
        }
    }

    #[test]
    fn a_path_beside_a_sphere_is_straight() {
        let ends = [Vector3::new(-2.0, 1.5, 0.0), Vector3::new(2.0, 1.2, 0.3)];
        assert_eq!(wrap(TendonSurface::Sphere, 1.0, ends, None), None);
        assert!(wrap(TendonSurface::Sphere, 1.4, ends, None).is_some());
    }

    /// Among all points of the circle, the one that the path touches from inside makes it shortest.
    #[test]
    fn a_path_that_touches_from_inside_is_the_shortest() {
        let ends = [Vector3::new(2.0, 0.4, 0.0), Vector3::new(0.3, 3.0, 0.0)];
        let found = wrap(TendonSurface::Sphere, 0.5, ends, Some(Vector3::zeros())).expect("a wrap");
        let length = |p: Vector3<f64>| (p - ends[0]).norm() + (p - ends[1]).norm();
        let least = length(found.ends[0]);
        for step in 0..1000 {
            let (sine, cosine) = (f64::from(step) / 1000.0 * TAU).sin_cos();
            assert!(length(Vector3::new(cosine, sine, 0.0) * 0.5) >= least - 1e-12);
        }
        assert_eq!(found.length, 0.0);
    }
}

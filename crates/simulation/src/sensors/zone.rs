//! The region of a touch sensor: whether it contains a point, and whether a ray meets it.

use robot_dynamics_description::Shape;

/// A convex region about its frame's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Zone {
    /// Half edges.
    Box([f64; 3]),
    /// Half axes.
    Ellipsoid([f64; 3]),
    /// Radius and half length.
    Cylinder(f64, f64),
    Capsule(f64, f64),
}

impl Zone {
    /// `None` for a shape that is not bounded and convex: the zone is then the whole link.
    pub(super) fn new(shape: &Shape) -> Option<Self> {
        match *shape {
            Shape::Box { size } => Some(Self::Box(size.map(|edge| 0.5 * edge))),
            Shape::Sphere { radius } => Some(Self::Ellipsoid([radius; 3])),
            Shape::Ellipsoid { half_axes } => Some(Self::Ellipsoid(half_axes)),
            Shape::Cylinder { radius, length } => Some(Self::Cylinder(radius, 0.5 * length)),
            Shape::Capsule { radius, length } => Some(Self::Capsule(radius, 0.5 * length)),
            Shape::Plane { .. } | Shape::HeightField { .. } | Shape::Mesh { .. } => None,
        }
    }

    /// Whether the point, in the zone's frame, is inside or on the surface.
    pub(super) fn contains(&self, point: [f64; 3]) -> bool {
        self.meets(point, [0.0; 3])
    }

    /// Whether the ray from the point, both in the zone's frame, meets it.
    pub(super) fn meets(&self, point: [f64; 3], along: [f64; 3]) -> bool {
        let all = (0.0, f64::INFINITY);
        let interval = match *self {
            Self::Box(half) => (0..3).fold(all, |within, k| slab(within, point[k], along[k], half[k])),
            Self::Ellipsoid(half) => {
                let scaled = |x: [f64; 3]| core::array::from_fn(|k| x[k] / half[k]);
                ball(all, scaled(point), scaled(along), 1.0)
            }
            Self::Cylinder(radius, half) => {
                let [x, y, z] = point;
                let [u, v, w] = along;
                slab(ball(all, [x, y, 0.0], [u, v, 0.0], radius), z, w, half)
            }
            Self::Capsule(radius, half) => {
                let [x, y, z] = point;
                let ends = [half, -half].map(|end| ball(all, [x, y, z - end], along, radius));
                if ends.iter().any(|(from, to)| from <= to) {
                    return true;
                }
                return Self::Cylinder(radius, half).meets(point, along);
            }
        };
        interval.0 <= interval.1
    }
}

/// The part of the interval of t in which |x + t u| ≤ half; an empty one ends before it begins.
fn slab((from, to): (f64, f64), x: f64, u: f64, half: f64) -> (f64, f64) {
    if u == 0.0 {
        return if x.abs() <= half { (from, to) } else { (0.0, -1.0) };
    }
    let (a, b) = ((-half - x) / u, (half - x) / u);
    (from.max(a.min(b)), to.min(a.max(b)))
}

/// The part of the interval of t in which |x + t u|² ≤ radius².
fn ball((from, to): (f64, f64), x: [f64; 3], u: [f64; 3], radius: f64) -> (f64, f64) {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (a, b, c) = (dot(u, u), dot(x, u), dot(x, x) - radius * radius);
    if a == 0.0 {
        return if c <= 0.0 { (from, to) } else { (0.0, -1.0) };
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return (0.0, -1.0);
    }
    let root = discriminant.sqrt();
    (from.max((-b - root) / a), to.min((-b + root) / a))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ray meets a zone exactly if some of its points are inside: many of them are sampled.
    #[test]
    fn a_ray_meets_what_holds_one_of_its_points() {
        let random = &mut robot_dynamics_number::SplitMix64::new(7);
        let zones = [
            Zone::Box([0.3, 0.2, 0.4]),
            Zone::Ellipsoid([0.3, 0.2, 0.4]),
            Zone::Cylinder(0.3, 0.2),
            Zone::Capsule(0.2, 0.3),
        ];
        let (mut met, mut passed) = (0, 0);
        for zone in zones {
            for _ in 0..500 {
                let mut draw = || core::array::from_fn::<f64, 3, _>(|_| random.uniform(-1.0, 1.0));
                let (point, along) = (draw(), draw());
                let inside = (0..4000).any(|k| {
                    let t = f64::from(k) * 1e-3;
                    zone.contains(core::array::from_fn(|i| point[i] + t * along[i]))
                });
                // Points between the samples may be inside while no sample is, but not vice versa.
                assert!(zone.meets(point, along) || !inside, "{zone:?} {point:?} {along:?}");
                let away = along.map(|x| -x);
                let is_outside = !zone.contains(point);
                if inside && is_outside {
                    met += 1;
                    assert!(!zone.meets(point, away), "a convex zone lies on one side: {zone:?}");
                } else {
                    passed += usize::from(!zone.meets(point, along));
                }
            }
        }
        assert!(met > 100 && passed > 500, "{met} met, {passed} passed");
    }
}

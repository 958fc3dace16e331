//! The points at which a shape can touch a half-space.
//!
//! | shape | points |
//! | --- | --- |
//! | sphere, capsule | its lowest point, those of its two ends |
//! | box, convex mesh | its corners |
//! | ellipsoid | its lowest point |
//! | cylinder | of each end the lowest point of the rim; where it stands flat, eight about the rim |
//!
//! Each has a number that stays the same while the shape moves, so that a contact is recognized in the next
//! step.

use nalgebra::Vector3;
use robot_dynamics_description::Shape;

/// Below this sine of its tilt a cylinder counts as flat, because rounding would move the lowest point around
/// its rim. The points that it then rests on are higher than the lowest by at most 8 % of the radius times
/// the sine.
const FLAT: f64 = 1e-4;

/// The number of points of a rim that a cylinder rests on.
const RIM: usize = 8;

/// Sine and cosine of eight directions, every 45°.
pub(super) const ABOUT: [(f64, f64); RIM] = {
    let half = core::f64::consts::FRAC_1_SQRT_2;
    [
        (0.0, 1.0),
        (half, half),
        (1.0, 0.0),
        (half, -half),
        (0.0, -1.0),
        (-half, -half),
        (-1.0, 0.0),
        (-half, half),
    ]
};

/// A shape in contact with a half-space, in the shape's frame.
#[derive(Clone, Debug)]
pub(super) enum ContactGeometry {
    /// Balls of one radius about these points, and their convex hull.
    Rounded { centers: Vec<Vector3<f64>>, radius: f64 },
    /// About z, from −half to half.
    Cylinder { radius: f64, half: f64 },
    /// Its half axes.
    Ellipsoid(Vector3<f64>),
}

impl ContactGeometry {
    /// `None` for shapes without known points, or that cannot move.
    pub(super) fn new(shape: &Shape) -> Option<Self> {
        Some(match *shape {
            Shape::Sphere { radius } => Self::Rounded { centers: vec![Vector3::zeros()], radius },
            Shape::Capsule { radius, length } => {
                let end = Vector3::z() * (0.5 * length);
                Self::Rounded { centers: vec![end, -end], radius }
            }
            Shape::Box { size } => {
                let half = Vector3::from(size) * 0.5;
                let sign = |k: usize, bit: usize| if k & bit == 0 { 1.0 } else { -1.0 };
                let corner = |k| half.component_mul(&Vector3::new(sign(k, 1), sign(k, 2), sign(k, 4)));
                Self::Rounded { centers: (0..8).map(corner).collect(), radius: 0.0 }
            }
            Shape::Cylinder { radius, length } => Self::Cylinder { radius, half: 0.5 * length },
            Shape::Ellipsoid { half_axes } => Self::Ellipsoid(half_axes.into()),
            Shape::Plane { .. } | Shape::HeightField { .. } | Shape::Mesh { .. } => return None,
        })
    }

    /// A convex mesh with these corners.
    pub(super) fn of_points(points: &[[f64; 3]]) -> Result<Self, String> {
        let centers: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::from(*point)).collect();
        if centers.is_empty() || centers.iter().flatten().any(|x| !x.is_finite()) {
            return Err("its points are none, or not finite".into());
        }
        Ok(Self::Rounded { centers, radius: 0.0 })
    }

    /// Whether it is a ball or a capsule.
    pub(super) fn is_line(&self) -> bool {
        matches!(self, Self::Rounded { centers, radius } if centers.len() <= 2 && *radius > 0.0)
    }

    /// The number of points.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Rounded { centers, .. } => centers.len(),
            Self::Cylinder { .. } => 2 * (1 + RIM),
            Self::Ellipsoid(_) => 1,
        }
    }

    /// Point k, for a unit vector `down` into the half-space.
    pub(super) fn point(&self, k: usize, down: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Rounded { centers, radius } => centers[k] + down * *radius,
            Self::Cylinder { radius, half } => {
                let end = if k <= RIM { *half } else { -half };
                let (sin, cos) = match k % (RIM + 1) {
                    0 => {
                        let sine = across(down).max(SMALLEST);
                        (down.y / sine, down.x / sine)
                    }
                    k => ABOUT[k % RIM],
                };
                Vector3::new(radius * cos, radius * sin, end)
            }
            // The normal at x is D⁻²x: x = D²n/|Dn|.
            Self::Ellipsoid(half_axes) => {
                let scaled = half_axes.component_mul(down);
                half_axes.component_mul(&scaled) / scaled.norm()
            }
        }
    }

    /// Whether point k can be a contact.
    pub(super) fn takes_part(&self, k: usize, down: &Vector3<f64>) -> bool {
        match self {
            Self::Cylinder { .. } => (across(down) < FLAT) != k.is_multiple_of(RIM + 1),
            _ => true,
        }
    }

    /// Whether point k moves along the shape as it turns, like that of a rim.
    pub(super) fn is_lowest(&self, k: usize) -> bool {
        matches!(self, Self::Cylinder { .. }) && k.is_multiple_of(RIM + 1)
    }

    /// Half the size of its bounding box, along its axes and centred on its origin.
    pub(super) fn extent(&self) -> Vector3<f64> {
        match self {
            Self::Rounded { centers, radius } => {
                let most =
                    centers.iter().fold(Vector3::zeros(), |most: Vector3<f64>, at| most.sup(&at.abs()));
                most.add_scalar(*radius)
            }
            Self::Cylinder { radius, half } => Vector3::new(*radius, *radius, *half),
            Self::Ellipsoid(half_axes) => *half_axes,
        }
    }

    /// The largest distance of its points from the frame's origin.
    pub(super) fn reach(&self) -> f64 {
        match self {
            Self::Rounded { centers, radius } => {
                radius + centers.iter().map(Vector3::norm).fold(0.0, f64::max)
            }
            Self::Cylinder { radius, half } => radius.hypot(*half),
            Self::Ellipsoid(half_axes) => half_axes.max(),
        }
    }
}

/// The part of a direction across the axis z.
fn across(direction: &Vector3<f64>) -> f64 {
    (direction.x * direction.x + direction.y * direction.y).sqrt()
}

/// Below this, a direction's component is rounding, and its square may underflow.
const SMALLEST: f64 = 1e-150;

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// No point of the surface is lower than the lowest of the form's points, by sampling.
    #[test]
    fn no_point_of_a_shape_is_lower() {
        let mut random = SplitMix64::new(7);
        let shapes = [
            Shape::Sphere { radius: 0.3 },
            Shape::Capsule { radius: 0.1, length: 0.4 },
            Shape::Box { size: [0.2, 0.3, 0.5] },
            Shape::Cylinder { radius: 0.2, length: 0.3 },
            Shape::Ellipsoid { half_axes: [0.1, 0.2, 0.4] },
        ];
        for shape in shapes {
            let form = ContactGeometry::new(&shape).unwrap();
            for _ in 0..50 {
                let mut unit = || Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0)).normalize();
                let down = unit();
                let lowest = (0..form.count()).map(|k| form.point(k, &down).dot(&down)).fold(0.0, f64::max);
                let (mut found, mut sum) = (0.0_f64, 0.0);
                for _ in 0..2000 {
                    let at = unit();
                    let surface = match shape {
                        Shape::Sphere { radius } => at * radius,
                        Shape::Capsule { radius, length } => {
                            at * radius + Vector3::z() * (0.5 * length * at.z.signum())
                        }
                        Shape::Box { size } => {
                            let half = Vector3::from(size) * 0.5;
                            half.component_mul(&at) / at.amax()
                        }
                        Shape::Cylinder { radius, length } => {
                            let side = at.x.hypot(at.y);
                            Vector3::new(
                                at.x / side * radius,
                                at.y / side * radius,
                                0.5 * length * at.z.signum(),
                            )
                        }
                        Shape::Ellipsoid { half_axes } => Vector3::from(half_axes).component_mul(&at),
                        _ => unreachable!(),
                    };
                    found = found.max(surface.dot(&down));
                    sum += surface.norm();
                    assert!(surface.norm() <= form.reach() + 1e-12);
                }
                assert!(sum > 0.0 && found <= lowest + 1e-12, "{shape:?}: {found} below {lowest}");
                assert!(lowest <= form.extent().dot(&down.abs()) + 1e-12);
                assert!(found > 0.9 * lowest, "{shape:?}: {found} of {lowest}");
            }
        }
    }
}

//! ℓ̈ of a spatial tendon at v̇ = 0.
//!
//! A straight part d with the direction u has ℓ̈ = u·d̈ + (|ḋ|² − (u·ḋ)²)/ℓ. The length of a path around a
//! surface is a closed form of its two ends in the axes of the surface, and nested dual numbers give its
//! second derivative by time. A path that touches a surface from inside has the least length over the
//! positions φ of the touching point, so that ℓ̈ = L_tt − Σ L_φt²/L_φφ.

use nalgebra::Vector3;
use robot_dynamics_description::TendonSurface;
use robot_dynamics_number::{Dual, Scalar};

use super::path_number::{around, straight};
use super::wrapping::Wrap;
use super::{BodyPoint, BodySurface, Segment, TendonPath};
use crate::kinematics::body_placement::{BodyMotion, Placement};
use crate::model::WORLD;

/// A number with its first and second derivative by time.
type Moving = Dual<Dual<f64, 1>, 1>;

/// The position, velocity and acceleration of a point.
#[derive(Clone, Copy)]
struct PointMotion {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
}

impl TendonPath {
    /// ℓ̈ at v̇ = 0 \[m/s²\], given the motions of all bodies at v̇ = 0.
    pub fn bias_acceleration(&self, placement: &Placement, motions: &[BodyMotion]) -> f64 {
        let segments = self.segments.iter();
        segments.map(|segment| segment.share * segment.bias_acceleration(placement, motions)).sum()
    }
}

impl Segment {
    fn bias_acceleration(&self, placement: &Placement, motions: &[BodyMotion]) -> f64 {
        let [from, to] = self.ends.map(|end| point_motion(end, placement, motions));
        let wrapped = self.surface.and_then(|surface| {
            let found = surface.wrap(placement, [from.position, to.position])?;
            Some((surface, found))
        });
        let Some((surface, found)) = wrapped else {
            return straight(&[from.components(), to.components()]).acceleration();
        };
        let (axes, origin) = surface.place(placement);
        let ends = [from, to].map(|point| surface.relative_motion(&point, placement, motions));
        let [a, b] = found.ends.map(|end| axes.tr_mul(&(end - origin)));
        let side = surface.side.map(|side| axes.tr_mul(&(side.in_world(placement) - origin)));
        let flat = |point: &Vector3<f64>| match surface.kind {
            TendonSurface::Sphere => *point,
            TendonSurface::Cylinder => Vector3::new(point.x, point.y, 0.0),
        };
        let flat_ends = ends.map(|end| PointMotion {
            position: flat(&end.position),
            velocity: flat(&end.velocity),
            acceleration: flat(&end.acceleration),
        });
        let around = if side.is_some_and(|side| side.norm() < surface.radius) {
            touch(&flat_ends, flat(&a), surface.kind)
        } else {
            around(
                &flat_ends.map(|end| end.components()),
                surface.radius,
                flat_arc(&found, (a - b).z, surface.kind),
            )
        };
        match surface.kind {
            TendonSurface::Sphere => around.acceleration(),
            TendonSurface::Cylinder => {
                let [from, to] = ends.map(|end| end.component(2));
                let rise = to - from;
                (around * around + rise * rise).sqrt().acceleration()
            }
        }
    }
}

/// The length of the arc in the plane across the axis of a surface.
pub(super) fn flat_arc(found: &Wrap, rise: f64, kind: TendonSurface) -> f64 {
    match kind {
        TendonSurface::Sphere => found.length,
        TendonSurface::Cylinder => (found.length * found.length - rise * rise).max(0.0).sqrt(),
    }
}

/// The length of the shortest path from one end to the other via a sphere, or a circle about z, which it
/// touches at `point`.
fn touch(ends: &[PointMotion; 2], point: Vector3<f64>, kind: TendonSurface) -> Moving {
    let at_rest = PointMotion { position: point, velocity: Vector3::zeros(), acceleration: Vector3::zeros() };
    let way = |end: &PointMotion| straight(&[at_rest.components(), end.components()]);
    let mut length = way(&ends[0]) + way(&ends[1]);
    // Two directions along a sphere, in the plane of the path and across it; one along a circle.
    let normal = match kind {
        TendonSurface::Sphere => ends[0].position.cross(&ends[1].position),
        TendonSurface::Cylinder => Vector3::z(),
    };
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let radius = point.norm();
    let tangents = [normal.cross(&point), normal * radius];
    let count = if kind == TendonSurface::Sphere { 2 } else { 1 };
    for tangent in &tangents[..count] {
        let [mut mixed, mut second] = [0.0; 2];
        for PointMotion { position, velocity, .. } in ends {
            let way = position - point;
            let distance = way.norm();
            let along = way / distance;
            let slope = along.dot(tangent);
            mixed -= (velocity.dot(tangent) - along.dot(velocity) * slope) / distance;
            second += (tangent.norm_squared() - slope * slope) / distance + along.dot(&point);
        }
        if second > 0.0 {
            length.gradient[0].gradient[0] -= mixed * mixed / second;
        }
    }
    length
}

fn moving(value: f64, rate: f64, acceleration: f64) -> Moving {
    Dual {
        value: Dual { value, gradient: [rate] },
        gradient: [Dual { value: rate, gradient: [acceleration] }],
    }
}

/// The second derivative by time.
trait Acceleration {
    fn acceleration(&self) -> f64;
}

impl Acceleration for Moving {
    fn acceleration(&self) -> f64 {
        self.gradient[0].gradient[0]
    }
}

impl PointMotion {
    fn component(&self, k: usize) -> Moving {
        moving(self.position[k], self.velocity[k], self.acceleration[k])
    }

    fn components(&self) -> [Moving; 3] {
        [0, 1, 2].map(|k| self.component(k))
    }
}

/// The motion of a point of a body or of the world.
fn point_motion(point: BodyPoint, placement: &Placement, motions: &[BodyMotion]) -> PointMotion {
    let lever = placement.body(point.body).0 * point.position;
    let BodyMotion { velocity, acceleration, .. } = body_motion(point.body, motions).at(&lever);
    PointMotion { position: point.in_world(placement), velocity, acceleration }
}

/// The motion of a body, or of the world, which is at rest.
fn body_motion(body: usize, motions: &[BodyMotion]) -> BodyMotion {
    if body == WORLD { BodyMotion::default() } else { motions[body] }
}

impl BodySurface {
    /// The motion of a point relative to the surface, in the axes of the surface.
    fn relative_motion(
        &self,
        point: &PointMotion,
        placement: &Placement,
        motions: &[BodyMotion],
    ) -> PointMotion {
        let (axes, position) = self.place(placement);
        let center = point_motion(BodyPoint { body: self.body, position: self.origin }, placement, motions);
        let carrier = body_motion(self.body, motions);
        let way = point.position - position;
        let rate = point.velocity - center.velocity;
        let acceleration = point.acceleration - center.acceleration;
        let acceleration = carrier.relative_acceleration([&way, &rate, &acceleration]);
        PointMotion {
            position: axes.tr_mul(&way),
            velocity: axes.tr_mul(&(rate - carrier.spin.cross(&way))),
            acceleration: axes.tr_mul(&acceleration),
        }
    }
}

//! The derivatives of the length of a spatial tendon, of ℓ̇ and of ℓ̈ by the coordinates.
//!
//! The length of a part of the path is a closed formula of its two ends in the axes of the surface that it
//! passes, or of the world. Nested dual numbers give the derivatives by the ends, and `motion_columns` those
//! of the ends by the coordinates. A path that touches a surface from inside touches it where its length is
//! least; steps of Newton's method in dual numbers give the derivatives of that point.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::TendonSurface;
use robot_dynamics_number::Dual;

use super::curvature::flat_arc;
use super::path_number::{PathNumber, around, dot, straight};
use super::wrapping::Wrap;
use super::{BodySurface, Segment, TendonPath};
use crate::Model;
use crate::kinematics::body_placement::{BodyMotion, Placement};
use crate::kinematics::motion_columns::{
    MotionColumn, MotionGradient, Seeded, Six, force_derivative, motion_columns, seeded_motion, seeded_place,
};
use crate::model::WORLD;

/// ℓ̇ and ℓ̈ in a motion, and their derivatives by the coordinates.
#[derive(Clone, Debug, Default)]
pub struct LengthDerivatives {
    pub rate: f64,
    pub second: f64,
    /// A coordinate may come several times; its derivatives are the sums.
    pub entries: Vec<LengthEntry>,
}

/// The derivatives of a length by a coordinate.
#[derive(Clone, Copy, Debug, Default)]
pub struct LengthEntry {
    pub coordinate: usize,
    /// ∂ℓ/∂q, which is ∂ℓ̇/∂v.
    pub slope: f64,
    /// ∂ℓ̇/∂q.
    pub rate_by_position: f64,
    /// ∂ℓ̈/∂q.
    pub second_by_position: f64,
    /// ∂ℓ̈/∂v.
    pub second_by_velocity: f64,
}

impl TendonPath {
    /// ℓ̇ and ℓ̈ with their derivatives by q and v, given the motions of all bodies.
    pub fn derivatives(
        &self,
        model: &Model,
        placement: &Placement,
        motions: &[BodyMotion],
    ) -> LengthDerivatives {
        let mut sum = LengthDerivatives::default();
        for segment in &self.segments {
            if let Some(moving) = MovingSegment::new(model, segment, placement, motions) {
                moving.add_derivatives(&mut sum);
            }
        }
        sum
    }

    /// Calls `add` with the entries (i, j) of ∂(∂ℓ̇/∂v)/∂q. An entry may come in several parts.
    pub fn row_derivative(
        &self,
        model: &Model,
        placement: &Placement,
        motions: &[BodyMotion],
        mut add: impl FnMut(usize, usize, f64),
    ) {
        for segment in &self.segments {
            if let Some(moving) = MovingSegment::new(model, segment, placement, motions) {
                moving.row_derivative(&mut add);
            }
        }
    }
}

/// The formula of a part's length, as a function of its ends in the axes of the surface.
enum PartLength {
    Straight,
    Around {
        kind: TendonSurface,
        radius: f64,
        arc: f64,
    },
    /// The path touches the surface at this point.
    Touch {
        kind: TendonSurface,
        point: Vector3<f64>,
    },
}

/// A segment at a state: the two ends and the surface, or the world.
struct MovingSegment {
    share: f64,
    length: PartLength,
    /// The axes and origins of the ends and of the surface.
    places: [(Matrix3<f64>, Vector3<f64>); 3],
    moving: [BodyMotion; 3],
    columns: [Vec<MotionColumn>; 3],
    /// The position, velocity and acceleration of both ends relative to the surface, along its axes.
    ends: [Six; 3],
}

/// The derivatives of a length ℓ(x) of six numbers in a motion x(t).
struct EndGradients {
    rate: f64,
    second: f64,
    /// ∂ℓ/∂x.
    slope: Six,
    /// ∂ℓ̇/∂x, which is half of ∂ℓ̈/∂ẋ.
    rate_slope: Six,
    /// ∂ℓ̈/∂x.
    second_slope: Six,
}

impl MovingSegment {
    /// `None` if all parts are on one body.
    fn new(model: &Model, segment: &Segment, placement: &Placement, motions: &[BodyMotion]) -> Option<Self> {
        let points = segment.ends.map(|end| end.in_world(placement));
        let wrapped = segment.surface.and_then(|surface| {
            let found = surface.wrap(placement, points)?;
            Some((surface, found))
        });
        let (base, base_place, length) = match &wrapped {
            None => (WORLD, (Matrix3::identity(), Vector3::zeros()), PartLength::Straight),
            Some((surface, found)) => {
                (surface.body, surface.place(placement), part_length(surface, found, placement))
            }
        };
        let bodies = [segment.ends[0].body, segment.ends[1].body, base];
        let mut carrier = model.common_ancestor([bodies[0], bodies[1]]);
        if wrapped.is_some() {
            carrier = model.common_ancestor([carrier, base]);
        }
        if wrapped.is_none() && bodies[0] == bodies[1] {
            return None;
        }
        let place = |k: usize| if k < 2 { (placement.body(bodies[k]).0, points[k]) } else { base_place };
        let places = [place(0), place(1), place(2)];
        let moving = [0, 1, 2].map(|k| motion_at(bodies[k], &places[k].1, placement, motions));
        let columns =
            [0, 1, 2].map(|k| motion_columns(model, (placement, motions), [bodies[k], carrier], places[k].1));
        let mut all = Self { share: segment.share, length, places, moving, columns, ends: [[0.0; 6]; 3] };
        let seeded = all.seeded(None, None);
        all.ends = seeded.map(|part| part.map(|x| x.value));
        Some(all)
    }

    /// The position, velocity and acceleration of both ends relative to the surface, with the derivatives by
    /// the pose of one point or by the velocity of one.
    fn seeded(&self, pose: Option<usize>, velocity: Option<usize>) -> [[Seeded; 6]; 3] {
        let place = |k: usize| seeded_place(&self.places[k].0, &self.places[k].1, pose == Some(k));
        let motion = |k: usize| seeded_motion(&self.moving[k], velocity == Some(k));
        let ((axes, origin), base) = (place(2), motion(2));
        let along = |x: &Vector3<Seeded>| {
            [0, 1, 2].map(|k| {
                let axis = axes.column(k);
                axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2]
            })
        };
        let [from, to] = [0, 1].map(|k| {
            let (point, motion) = (place(k).1, motion(k));
            let way = point - origin;
            let rate = motion.velocity - base.velocity;
            let acceleration = motion.acceleration - base.acceleration;
            let relative = rate - base.spin.cross(&way);
            [along(&way), along(&relative), along(&base.relative_acceleration([&way, &rate, &acceleration]))]
        });
        let both =
            |part: usize| core::array::from_fn(|i| if i < 3 { from[part][i] } else { to[part][i - 3] });
        [both(0), both(1), both(2)]
    }

    fn gradients(&self) -> EndGradients {
        let [x, rate, acceleration] = &self.ends;
        let moving: [Dual<Dual<Seeded, 1>, 1>; 6] = core::array::from_fn(|i| {
            let (x, rate) = (Seeded::variable(x[i], i), Seeded::constant(rate[i]));
            Dual {
                value: Dual { value: x, gradient: [rate] },
                gradient: [Dual { value: rate, gradient: [Seeded::constant(acceleration[i])] }],
            }
        });
        let length = self.length.at(&moving);
        let (rate, second) = (length.gradient[0].value, length.gradient[0].gradient[0]);
        EndGradients {
            rate: rate.value,
            second: second.value,
            slope: length.value.value.gradient,
            rate_slope: rate.gradient,
            second_slope: second.gradient,
        }
    }

    fn add_derivatives(&self, sum: &mut LengthDerivatives) {
        let EndGradients { rate, second, slope, rate_slope, second_slope } = self.gradients();
        sum.rate += self.share * rate;
        sum.second += self.share * second;
        let contract = |factors: &Six, x: &[Seeded; 6]| -> Six {
            core::array::from_fn(|k| (0..6).map(|i| factors[i] * x[i].gradient[k]).sum())
        };
        let add = |a: Six, b: Six| -> Six { core::array::from_fn(|k| a[k] + b[k]) };
        let twice = rate_slope.map(|x| 2.0 * x);
        for k in (0..3).filter(|&k| !self.columns[k].is_empty()) {
            let ([x, rate, acceleration], [_, own, driven]) =
                (self.seeded(Some(k), None), self.seeded(None, Some(k)));
            // ∂ẋ/∂ẋ_k is ∂x/∂x_k, the force of a tension 1.
            let wrench = contract(&slope, &own);
            let of_rate = MotionGradient {
                pose: add(contract(&rate_slope, &x), contract(&slope, &rate)),
                velocity: wrench,
                acceleration: [0.0; 6],
            };
            let of_second = MotionGradient {
                pose: add(
                    add(contract(&second_slope, &x), contract(&twice, &rate)),
                    contract(&slope, &acceleration),
                ),
                velocity: add(contract(&twice, &own), contract(&slope, &driven)),
                acceleration: wrench,
            };
            for column in &self.columns[k] {
                let [rate_by_position, row] = of_rate.by_state(column);
                let [second_by_position, second_by_velocity] = of_second.by_state(column);
                sum.entries.push(LengthEntry {
                    coordinate: column.coordinate,
                    slope: self.share * row,
                    rate_by_position: self.share * rate_by_position,
                    second_by_position: self.share * second_by_position,
                    second_by_velocity: self.share * second_by_velocity,
                });
            }
        }
    }

    fn row_derivative(&self, add: impl FnMut(usize, usize, f64)) {
        let [x, ..] = &self.ends;
        let variables: [Dual<Seeded, 6>; 6] =
            core::array::from_fn(|i| Dual::variable(Seeded::variable(x[i], i), i));
        let slope = self.length.at(&variables).gradient;
        let wrenches = |variable: usize| {
            let [x, ..] = self.seeded(Some(variable), None);
            // The chain rule for ∂ℓ/∂x.
            let tension: [Seeded; 6] = core::array::from_fn(|i| Dual {
                value: self.share * slope[i].value,
                gradient: core::array::from_fn(|k| {
                    let terms = (0..6).map(|j| slope[i].gradient[j] * x[j].gradient[k]);
                    self.share * terms.sum::<f64>()
                }),
            });
            self.wrenches(variable, &tension)
        };
        force_derivative(&self.columns, wrenches, add);
    }

    /// The wrenches of a length's derivatives by its ends, on the ends and the surface.
    fn wrenches(&self, variable: usize, tension: &[Seeded; 6]) -> Vec<[Seeded; 6]> {
        let place = |k: usize| seeded_place(&self.places[k].0, &self.places[k].1, variable == k);
        let (axes, origin) = place(2);
        let zero = Seeded::constant(0.0);
        let mut wrenches = vec![[zero; 6]; 3];
        for k in 0..2 {
            let parts = &tension[3 * k..3 * k + 3];
            let mut force = Vector3::repeat(zero);
            for (i, part) in parts.iter().enumerate() {
                force += axes.column(i) * *part;
            }
            let moment = (place(k).1 - origin).cross(&force);
            for i in 0..3 {
                wrenches[k][i] = force[i];
                wrenches[2][i] -= force[i];
                wrenches[2][3 + i] -= moment[i];
            }
        }
        wrenches
    }
}

impl PartLength {
    fn at<S: PathNumber>(&self, [a, b, c, d, e, f]: &[S; 6]) -> S {
        let ends = [[*a, *b, *c], [*d, *e, *f]];
        let flat = ends.map(|[x, y, _]| [x, y, S::zero()]);
        let (kind, length) = match self {
            Self::Straight => return straight(&ends),
            Self::Around { kind: TendonSurface::Sphere, radius, arc } => return around(&ends, *radius, *arc),
            Self::Touch { kind: TendonSurface::Sphere, point } => return touched(&ends, point, 2),
            Self::Around { kind, radius, arc } => (kind, around(&flat, *radius, *arc)),
            Self::Touch { kind, point } => (kind, touched(&flat, point, 1)),
        };
        debug_assert_eq!(*kind, TendonSurface::Cylinder);
        // The path is straight on the unrolled cylinder.
        let rise = ends[1][2] - ends[0][2];
        (length * length + rise * rise).sqrt()
    }
}

/// The length of the shortest path from one end to the other via a sphere (`count` 2), or a circle about z
/// (1), which it touches at `point`.
fn touched<S: PathNumber>(ends: &[[S; 3]; 2], point: &Vector3<f64>, count: usize) -> S {
    let radius = point.norm();
    let numbers = ends.map(|end| Vector3::from(end.map(PathNumber::number)));
    let normal = if count == 2 { numbers[0].cross(&numbers[1]) } else { Vector3::z() };
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let tangents = [normal.cross(point), normal * radius];
    let constant = |x: &Vector3<f64>| [0, 1, 2].map(|k| S::from_f64(x[k]));
    let mut at = constant(point);
    // Each step makes the derivatives of one more order exact.
    for _order in 0..3 {
        let outward = at.map(|x| x / S::from_f64(radius));
        let mut pull = [S::zero(); 3];
        for end in ends {
            let way = [0, 1, 2].map(|k| end[k] - at[k]);
            let distance = dot(&way, &way).sqrt();
            (0..3).for_each(|k| pull[k] += way[k] / distance);
        }
        let normal_pull = dot(&pull, &outward);
        let mut moved = at;
        for tangent in &tangents[..count] {
            let mut second = 0.0;
            for end in &numbers {
                let way = end - point;
                let along = way / way.norm();
                let slope = along.dot(tangent);
                second += (tangent.norm_squared() - slope * slope) / way.norm() + along.dot(point);
            }
            if second > 0.0 {
                let tangent = constant(tangent);
                let slope = dot(&tangent, &pull) - dot(&tangent, &outward) * normal_pull;
                (0..3).for_each(|k| moved[k] += tangent[k] * slope / S::from_f64(second));
            }
        }
        let scale = S::from_f64(radius) / dot(&moved, &moved).sqrt();
        at = moved.map(|x| x * scale);
    }
    straight(&[at, ends[0]]) + straight(&[at, ends[1]])
}

fn part_length(surface: &BodySurface, found: &Wrap, placement: &Placement) -> PartLength {
    let (axes, origin) = surface.place(placement);
    let [a, b] = found.ends.map(|end| axes.tr_mul(&(end - origin)));
    let side = surface.side.map(|side| axes.tr_mul(&(side.in_world(placement) - origin)));
    if side.is_some_and(|side| side.norm() < surface.radius) {
        let point = match surface.kind {
            TendonSurface::Sphere => a,
            TendonSurface::Cylinder => Vector3::new(a.x, a.y, 0.0),
        };
        return PartLength::Touch { kind: surface.kind, point };
    }
    let arc = flat_arc(found, (a - b).z, surface.kind);
    PartLength::Around { kind: surface.kind, radius: surface.radius, arc }
}

/// The motion of a point of the world as one of a body.
fn motion_at(body: usize, point: &Vector3<f64>, placement: &Placement, motions: &[BodyMotion]) -> BodyMotion {
    if body == WORLD { BodyMotion::default() } else { motions[body].at(&(point - placement.origin(body))) }
}

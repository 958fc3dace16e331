//! The motions that rows between two sites a and b prevent.
//!
//! The formulas take any number: `f64` for the rows, dual numbers for their derivatives.

use nalgebra::Vector3;

use super::site::SitePlace;
use crate::placement::{BodyMotion, VectorNumber};

/// The motion that a row prevents, between two sites a and b, or of b in the world.
#[derive(Clone, Debug)]
pub(crate) enum ConstrainedDirection {
    /// φ = a_k·(p_b − p_a).
    Shift(usize),
    /// φ = Σ c aᵢ·bⱼ.
    Turn(Vec<(f64, usize, usize)>),
    /// Component k of b's velocity, or k − 3 of its angular velocity, along b's own axes.
    Slip(usize),
    /// A component of the velocity of a disc's contact point on a plane.
    Roll(Box<Rolling>),
}

/// A thin disc about the origin of b, with this axle in b, on the plane n·x = offset. Its point p − r u does
/// not move along the heading (0), across it (1), or along n (2), where φ is its height.
#[derive(Clone, Debug)]
pub(crate) struct Rolling {
    pub(crate) axle: Vector3<f64>,
    pub(crate) radius: f64,
    pub(crate) normal: Vector3<f64>,
    pub(crate) offset: f64,
    pub(crate) direction: usize,
}

/// A v as the velocity of b's point relative to a's along one direction plus b's relative angular velocity
/// about another, and φ.
pub(crate) struct DirectionalRow<S = f64> {
    pub(crate) point: Vector3<S>,
    pub(crate) along: Vector3<S>,
    pub(crate) about: Vector3<S>,
    pub(crate) error: Option<S>,
}

impl<S: VectorNumber> DirectionalRow<S> {
    /// A v, given the motions of both sites.
    pub(crate) fn rate(&self, [a, b]: &[SitePlace<S>; 2], [moving_a, moving_b]: &[BodyMotion<S>; 2]) -> S {
        let velocity = |place: &SitePlace<S>, moving: &BodyMotion<S>| {
            moving.velocity + moving.spin.cross(&(self.point - place.origin))
        };
        let relative = velocity(b, moving_b) - velocity(a, moving_a);
        dot(&self.along, &relative) + dot(&self.about, &(moving_b.spin - moving_a.spin))
    }

    /// The force of a multiplier 1 on each site, and its moment about the site's origin.
    pub(crate) fn wrenches(&self, [a, b]: &[SitePlace<S>; 2]) -> [[Vector3<S>; 2]; 2] {
        let moment = |place: &SitePlace<S>| self.about + (self.point - place.origin).cross(&self.along);
        [[-self.along, -moment(a)], [self.along, moment(b)]]
    }
}

/// x·y.
pub(crate) fn dot<S: VectorNumber>(x: &Vector3<S>, y: &Vector3<S>) -> S {
    x.x * y.x + x.y * y.y + x.z * y.z
}

/// x/s.
fn divided<S: VectorNumber>(x: &Vector3<S>, s: S) -> Vector3<S> {
    x.map(|x| x / s)
}

/// A constant vector.
fn constant<S: VectorNumber>(x: &Vector3<f64>) -> Vector3<S> {
    x.map(S::from_f64)
}

impl ConstrainedDirection {
    /// Whether the row is in rad.
    pub(crate) fn is_turn(&self) -> bool {
        match self {
            Self::Turn(_) => true,
            Self::Slip(k) => *k >= 3,
            Self::Shift(_) | Self::Roll(_) => false,
        }
    }

    pub(crate) fn row<S: VectorNumber>(&self, [a, b]: &[SitePlace<S>; 2]) -> DirectionalRow<S> {
        let none = Vector3::repeat(S::zero());
        match self {
            // With the velocity of a's point there, the rotation of a_k is included.
            Self::Shift(k) => {
                let along = a.axis(*k);
                let error = Some(dot(&along, &(b.origin - a.origin)));
                DirectionalRow { point: b.origin, along, about: none, error }
            }
            // The rate of α·β is ω·(β × α).
            Self::Turn(products) => {
                let (mut about, mut error) = (none, S::zero());
                for &(c, i, j) in products {
                    let (alpha, beta, c) = (a.axis(i), b.axis(j), S::from_f64(c));
                    about += beta.cross(&alpha) * c;
                    error += c * dot(&alpha, &beta);
                }
                DirectionalRow { point: b.origin, along: none, about, error: Some(error) }
            }
            Self::Slip(k) => {
                let axis = b.axis(k % 3);
                let (along, about) = if *k < 3 { (axis, none) } else { (none, axis) };
                DirectionalRow { point: b.origin, along, about, error: None }
            }
            Self::Roll(rolling) => {
                let Contact { u, h, length, n, .. } = rolling.contact(b);
                let r = S::from_f64(rolling.radius);
                let along = [h, n.cross(&h), n][rolling.direction];
                let height = dot(&n, &b.origin) - r * length - S::from_f64(rolling.offset);
                let error = (rolling.direction == 2).then_some(height);
                DirectionalRow { point: b.origin - u * r, along, about: none, error }
            }
        }
    }

    /// A a + Ȧv, given the motions of both sites; Ȧv if they are those at v̇ = 0.
    pub(crate) fn acceleration<S: VectorNumber>(
        &self,
        [a, b]: &[SitePlace<S>; 2],
        [moving_a, moving_b]: &[BodyMotion<S>; 2],
    ) -> S {
        match self {
            // With e = a_k and d = p_b − p_a, φ̈ = e·(d̈ − ω̇_a × d − 2 ω_a × ḋ + ω_a × (ω_a × d)).
            Self::Shift(k) => {
                let d = b.origin - a.origin;
                let rate = moving_b.velocity - moving_a.velocity;
                let acceleration = moving_b.acceleration - moving_a.acceleration;
                dot(&a.axis(*k), &moving_a.relative_acceleration([&d, &rate, &acceleration]))
            }
            // With ω = ω_b − ω_a, the rate of ω·(β × α) is ω̇·(β × α) + ω·((ω_b × β) × α + β × (ω_a × α)).
            Self::Turn(products) => {
                let spin = moving_b.spin - moving_a.spin;
                let spin_rate = moving_b.spin_rate - moving_a.spin_rate;
                let mut sum = S::zero();
                for &(c, i, j) in products {
                    let (alpha, beta) = (a.axis(i), b.axis(j));
                    let normal_rate =
                        moving_b.spin.cross(&beta).cross(&alpha) + beta.cross(&moving_a.spin.cross(&alpha));
                    let rate = dot(&beta.cross(&alpha), &spin_rate) + dot(&normal_rate, &spin);
                    sum += S::from_f64(c) * rate;
                }
                sum
            }
            // The rate of b_k·x is b_k·ẋ + (ω × b_k)·x.
            Self::Slip(k) => {
                let axis = b.axis(k % 3);
                let axis_rate = moving_b.spin.cross(&axis);
                if *k < 3 {
                    dot(&axis, &moving_b.acceleration) + dot(&axis_rate, &moving_b.velocity)
                } else {
                    dot(&axis, &moving_b.spin_rate)
                }
            }
            Self::Roll(rolling) => rolling.acceleration(b, moving_b),
        }
    }
}

/// The contact of a disc: the unit axle s; u = w/|w| with w = n − (n·s) s, from the contact to the centre;
/// the heading h = s × n/|s × n|; |w|; and n.
struct Contact<S> {
    s: Vector3<S>,
    u: Vector3<S>,
    h: Vector3<S>,
    length: S,
    n: Vector3<S>,
}

impl Rolling {
    fn contact<S: VectorNumber>(&self, b: &SitePlace<S>) -> Contact<S> {
        let (n, axle) = (constant(&self.normal), constant(&self.axle));
        let s = b.axis(0) * axle.x + b.axis(1) * axle.y + b.axis(2) * axle.z;
        let w = n - s * dot(&n, &s);
        let length = dot(&w, &w).sqrt();
        Contact { s, u: divided(&w, length), h: divided(&s.cross(&n), length), length, n }
    }

    /// The rate of d·V with V = ṗ − r ω × u, the velocity of the disc's point at the contact.
    fn acceleration<S: VectorNumber>(&self, b: &SitePlace<S>, moving: &BodyMotion<S>) -> S {
        let Contact { s, u, h, length, n } = self.contact(b);
        let (r, spin) = (S::from_f64(self.radius), &moving.spin);
        let s_rate = spin.cross(&s);
        // A unit vector x/|x| changes at (ẋ − u (u·ẋ))/|x|.
        let turned = |unit: &Vector3<S>, rate: Vector3<S>| divided(&(rate - unit * dot(unit, &rate)), length);
        let u_rate = turned(&u, -s * dot(&n, &s_rate) - s_rate * dot(&n, &s));
        let h_rate = turned(&h, s_rate.cross(&n));
        let none = Vector3::repeat(S::zero());
        let (d, d_rate) = [(h, h_rate), (n.cross(&h), n.cross(&h_rate)), (n, none)][self.direction];
        let velocity = moving.velocity - spin.cross(&u) * r;
        let acceleration = moving.acceleration - (moving.spin_rate.cross(&u) + spin.cross(&u_rate)) * r;
        dot(&d, &acceleration) + dot(&d_rate, &velocity)
    }
}

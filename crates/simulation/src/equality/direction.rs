//! The motions that rows between two sites a and b prevent.

use nalgebra::Vector3;

use super::site::SitePlace;
use crate::placement::BodyMotion;

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
pub(crate) struct DirectionalRow {
    pub(crate) point: Vector3<f64>,
    pub(crate) along: Vector3<f64>,
    pub(crate) about: Vector3<f64>,
    pub(crate) error: Option<f64>,
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

    pub(crate) fn row(&self, [a, b]: &[SitePlace; 2]) -> DirectionalRow {
        let none = Vector3::zeros();
        match self {
            // With the velocity of a's point there, the rotation of a_k is included.
            Self::Shift(k) => {
                let along = a.axis(*k);
                let error = Some(along.dot(&(b.origin - a.origin)));
                DirectionalRow { point: b.origin, along, about: none, error }
            }
            // The rate of α·β is ω·(β × α).
            Self::Turn(products) => {
                let (mut about, mut error) = (none, 0.0);
                for &(c, i, j) in products {
                    let (alpha, beta) = (a.axis(i), b.axis(j));
                    about += beta.cross(&alpha) * c;
                    error += c * alpha.dot(&beta);
                }
                DirectionalRow { point: b.origin, along: none, about, error: Some(error) }
            }
            Self::Slip(k) => {
                let axis = b.axis(k % 3);
                let (along, about) = if *k < 3 { (axis, none) } else { (none, axis) };
                DirectionalRow { point: b.origin, along, about, error: None }
            }
            Self::Roll(rolling) => {
                let Contact { u, h, length, .. } = rolling.contact(b);
                let (n, r) = (&rolling.normal, rolling.radius);
                let along = [h, n.cross(&h), *n][rolling.direction];
                let height = n.dot(&b.origin) - r * length - rolling.offset;
                let error = (rolling.direction == 2).then_some(height);
                DirectionalRow { point: b.origin - u * r, along, about: none, error }
            }
        }
    }

    /// Ȧv, given the motions of both sites at v̇ = 0.
    pub(crate) fn bias(&self, [a, b]: &[SitePlace; 2], [moving_a, moving_b]: &[BodyMotion; 2]) -> f64 {
        match self {
            // With e = a_k and d = p_b − p_a, φ̈ = e·(d̈ − ω̇_a × d − 2 ω_a × ḋ + ω_a × (ω_a × d)).
            Self::Shift(k) => {
                let d = b.origin - a.origin;
                let rate = moving_b.velocity - moving_a.velocity;
                let acceleration = moving_b.acceleration - moving_a.acceleration;
                a.axis(*k).dot(&moving_a.relative_acceleration([&d, &rate, &acceleration]))
            }
            // With ω = ω_b − ω_a, the rate of ω·(β × α) is ω̇·(β × α) + ω·((ω_b × β) × α + β × (ω_a × α)).
            Self::Turn(products) => {
                let spin = moving_b.spin - moving_a.spin;
                let spin_rate = moving_b.spin_rate - moving_a.spin_rate;
                let term = |&(c, i, j): &(f64, usize, usize)| {
                    let (alpha, beta) = (a.axis(i), b.axis(j));
                    let normal_rate =
                        moving_b.spin.cross(&beta).cross(&alpha) + beta.cross(&moving_a.spin.cross(&alpha));
                    c * (beta.cross(&alpha).dot(&spin_rate) + normal_rate.dot(&spin))
                };
                products.iter().map(term).sum()
            }
            // The rate of b_k·x is b_k·ẋ + (ω × b_k)·x.
            Self::Slip(k) => {
                let axis = b.axis(k % 3);
                let axis_rate = moving_b.spin.cross(&axis);
                if *k < 3 {
                    axis.dot(&moving_b.acceleration) + axis_rate.dot(&moving_b.velocity)
                } else {
                    axis.dot(&moving_b.spin_rate)
                }
            }
            Self::Roll(rolling) => rolling.bias(b, moving_b),
        }
    }
}

/// The contact of a disc: the unit axle s; u = w/|w| with w = n − (n·s) s, from the contact to the centre;
/// the heading h = s × n/|s × n|; and |w|.
struct Contact {
    s: Vector3<f64>,
    u: Vector3<f64>,
    h: Vector3<f64>,
    length: f64,
}

impl Rolling {
    fn contact(&self, b: &SitePlace) -> Contact {
        let n = &self.normal;
        let s = b.axes * self.axle;
        let w = n - s * n.dot(&s);
        let length = w.norm();
        Contact { s, u: w / length, h: s.cross(n) / length, length }
    }

    /// The rate of d·V with V = ṗ − r ω × u, the velocity of the disc's point at the contact.
    fn bias(&self, b: &SitePlace, moving: &BodyMotion) -> f64 {
        let Contact { s, u, h, length } = self.contact(b);
        let (n, r, spin) = (&self.normal, self.radius, &moving.spin);
        let s_rate = spin.cross(&s);
        // A unit vector x/|x| changes at (ẋ − u (u·ẋ))/|x|.
        let turned = |unit: &Vector3<f64>, rate: Vector3<f64>| (rate - unit * unit.dot(&rate)) / length;
        let u_rate = turned(&u, -s * n.dot(&s_rate) - s_rate * n.dot(&s));
        let h_rate = turned(&h, s_rate.cross(n));
        let (d, d_rate) =
            [(h, h_rate), (n.cross(&h), n.cross(&h_rate)), (*n, Vector3::zeros())][self.direction];
        let velocity = moving.velocity - spin.cross(&u) * r;
        let acceleration = moving.acceleration - (moving.spin_rate.cross(&u) + spin.cross(&u_rate)) * r;
        d.dot(&acceleration) + d_rate.dot(&velocity)
    }
}

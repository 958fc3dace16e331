//! Contacts that are held, and the forces that they may exert.

use robot_dynamics_core::FrameId;
use robot_dynamics_number::{InvalidInput, check_finite, check_number, check_positive};

/// The part of a link that touches the environment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ContactGeometry {
    /// A point of the frame, at an offset along the frame's axes \[m\]; the link may rotate about it.
    Point([f64; 3]),
    /// A ball around the frame's origin, with its radius \[m\], that rolls without slip.
    Ball(f64),
    /// A face that neither moves nor rotates; forces act at its corners, along the frame's axes \[m\].
    Face(Vec<[f64; 3]>),
}

/// A contact with the environment that does not move, with a friction cone at each of its points.
///
/// A force f at a point, along the world's axes, is n f_n + t₁f₁ + t₂f₂ with normal n. It satisfies f_min ≤
/// f_n ≤ f_max and d_kᵀ(f₁, f₂) ≤ μ cos(π/s) f_n, k = 0 … s − 1, with d_k at the angle 2πk/s from t₁. This
/// pyramid with s sides is inside the cone |(f₁, f₂)| ≤ μ f_n, and its edges are on the cone.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldContact {
    pub(super) frame: FrameId,
    pub(super) geometry: ContactGeometry,
    pub(super) normal: [f64; 3],
    pub(super) friction: f64,
    pub(super) sides: usize,
    pub(super) normal_force: [f64; 2],
    pub(super) damping: f64,
}

impl HeldContact {
    /// A contact with the normal z, the friction coefficient 0.5 in a pyramid of four sides, normal forces
    /// that push without a limit, and a damping of 10 1/s.
    pub fn new(frame: FrameId, geometry: ContactGeometry) -> Self {
        Self {
            frame,
            geometry,
            normal: [0.0, 0.0, 1.0],
            friction: 0.5,
            sides: 4,
            normal_force: [0.0, f64::INFINITY],
            damping: 10.0,
        }
    }

    /// The normal along the world's axes, a unit vector that points to the robot.
    ///
    /// # Errors
    /// [`InvalidInput`] if its length differs from 1 by more than 1e-6.
    pub fn with_normal(mut self, normal: [f64; 3]) -> Result<Self, InvalidInput> {
        check_finite("the normal", &normal)?;
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        if (length - 1.0).abs() > 1e-6 {
            return Err(InvalidInput::unmet("the normal", "must be a unit vector"));
        }
        self.normal = normal.map(|n| n / length);
        Ok(self)
    }

    /// The friction coefficient μ, and the number of sides of the pyramid.
    ///
    /// # Errors
    /// [`InvalidInput`] if μ is negative or not finite, or there are fewer than three sides.
    pub fn with_friction(mut self, friction: f64, sides: usize) -> Result<Self, InvalidInput> {
        check_number("the friction coefficient", friction)?;
        if friction < 0.0 {
            return Err(InvalidInput::unmet("the friction coefficient", "must not be negative"));
        }
        if sides < 3 {
            return Err(InvalidInput::unmet("the number of sides", "must be at least three"));
        }
        (self.friction, self.sides) = (friction, sides);
        Ok(self)
    }

    /// The smallest and the largest normal force at each point \[N\]; the largest may be infinite.
    ///
    /// # Errors
    /// [`InvalidInput`] if the smallest is negative or exceeds the largest.
    pub fn with_normal_force(mut self, smallest: f64, largest: f64) -> Result<Self, InvalidInput> {
        let is_ordered = 0.0 <= smallest && smallest <= largest && smallest.is_finite();
        if !is_ordered {
            return Err(InvalidInput::unmet("the normal force", "must have bounds 0 ≤ smallest ≤ largest"));
        }
        self.normal_force = [smallest, largest];
        Ok(self)
    }

    /// kd \[1/s\]: the velocity v of the contact decays by v̇ = −kd v.
    ///
    /// # Errors
    /// [`InvalidInput`] if kd is negative or not finite.
    pub fn with_damping(mut self, damping: f64) -> Result<Self, InvalidInput> {
        check_number("the damping", damping)?;
        if damping < 0.0 {
            return Err(InvalidInput::unmet("the damping", "must not be negative"));
        }
        self.damping = damping;
        Ok(self)
    }

    /// Checks the numbers of the geometry.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        match &self.geometry {
            ContactGeometry::Point(offset) => check_finite("the offset of the contact", offset),
            ContactGeometry::Ball(radius) => check_positive("the radius of the contact", *radius, "m"),
            ContactGeometry::Face(corners) if corners.is_empty() => {
                Err(InvalidInput::unmet("a face of a contact", "must have a corner"))
            }
            ContactGeometry::Face(corners) => check_finite("a corner", corners.as_flattened()),
        }
    }

    /// The number of points with a force.
    pub(super) fn points(&self) -> usize {
        match &self.geometry {
            ContactGeometry::Face(corners) => corners.len(),
            _ => 1,
        }
    }

    /// The number of equations of its motion.
    pub(super) fn motion_rows(&self) -> usize {
        if matches!(self.geometry, ContactGeometry::Face(_)) { 6 } else { 3 }
    }

    /// t₁, t₂, n: a right-handed basis.
    pub(super) fn basis(&self) -> [[f64; 3]; 3] {
        let n = self.normal;
        // The axis that is farthest from n.
        let axis = (0..3).min_by(|a, b| n[*a].abs().total_cmp(&n[*b].abs())).unwrap_or(0);
        let mut t = core::array::from_fn(|k| f64::from(u8::from(k == axis)) - n[axis] * n[k]);
        let length = t.iter().map(|t: &f64| t * t).sum::<f64>().sqrt();
        for t in &mut t {
            *t /= length;
        }
        [t, cross(n, t), n]
    }
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

//! Placements, motion and force vectors, and inertias.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

/// `parent_from_body` in the current state.
#[derive(Clone, Copy, Debug)]
pub struct Transform<S: Scalar> {
    pub rotation: M3<S>,
    pub translation: V3<S>,
}

impl<S: Scalar> Transform<S> {
    /// `a_from_b` · `b_from_c`.
    #[inline(always)]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            rotation: self.rotation.times(&next.rotation),
            translation: self.rotation.times_plus(next.translation, self.translation),
        }
    }
}

impl<S: Scalar> Transform<S> {
    /// A force of the body's frame, along the parent's axes and about its origin.
    #[inline(always)]
    pub fn force_in_parent(&self, force: &Force<S>) -> Force<S> {
        let linear = self.rotation * force.linear;
        Force { linear, angular: self.rotation * force.angular + self.translation.cross(linear) }
    }
}

/// Angular velocity, and the acceleration field a(x) = `origin` + `gradient` x, in the body frame.
#[derive(Clone, Copy, Debug)]
pub struct BodyMotion<S: Scalar> {
    pub angular: V3<S>,
    /// \[α\]× + \[ω\]×\[ω\]×.
    pub gradient: M3<S>,
    /// Classical acceleration of the frame's origin.
    pub origin: V3<S>,
    /// α, stored in addition to the gradient that contains it.
    pub alpha: V3<S>,
}

/// Angular velocity and acceleration, and the classical acceleration of the origin, along the axes that each
/// use states.
#[derive(Clone, Copy, Debug)]
pub struct AxisMotion<S: Scalar> {
    pub angular: V3<S>,
    pub alpha: V3<S>,
    pub origin: V3<S>,
}

impl<S: Scalar> AxisMotion<S> {
    /// Adds a rotation about an axis with velocity v and acceleration a: α gains ω × z v.
    #[inline(always)]
    pub fn turn(&mut self, axis: V3<S>, v: S, a: S) {
        self.alpha = self.alpha.add_scaled(v, self.angular.cross(axis)).add_scaled(a, axis);
        self.angular = self.angular.add_scaled(v, axis);
    }

    /// Adds a translation along an axis with velocity v and acceleration a, and the Coriolis acceleration
    /// 2 ω × z v.
    #[inline(always)]
    pub fn slide(&mut self, axis: V3<S>, v: S, a: S) {
        self.origin = self.origin.add_scaled(v + v, self.angular.cross(axis)).add_scaled(a, axis);
    }
}

/// A force and its moment about the body frame's origin.
#[derive(Clone, Copy, Debug)]
pub struct Force<S: Scalar> {
    pub linear: V3<S>,
    pub angular: V3<S>,
}

/// A motion or force vector of six components.
pub type Screw<S> = Force<S>;

impl<S: Scalar> Force<S> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { linear: V3::zero(), angular: V3::zero() }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }

    #[inline(always)]
    pub fn dot(&self, other: &Self) -> S {
        self.linear.dot(other.linear) + self.angular.dot(other.angular)
    }
}

/// The inertia of a rigid body or subtree: mass, first moment, inertia about the frame's origin.
#[derive(Clone, Copy, Debug)]
pub struct SpatialInertia<S: Scalar> {
    pub mass: S,
    pub first_moment: V3<S>,
    pub inertia: Sym3<S>,
}

/// Rates of mass transport of moving points p: ∫ ṗ dm and ∫ ṗ pᵀ dm.
#[derive(Clone, Copy, Debug)]
pub struct MassFlux<S: Scalar> {
    pub momentum: V3<S>,
    pub stir: M3<S>,
}

/// An articulated-body inertia \[M H; Hᵀ I\] (linear first) with its bias force. **(RBDA §7.1)**
#[derive(Clone, Copy, Debug)]
pub struct ArticulatedInertia<S: Scalar> {
    pub mass: Sym3<S>,
    pub coupling: M3<S>,
    /// Hᵀ, for scalar types with `KEEPS_TRANSPOSE`.
    pub coupling_back: M3<S>,
    pub inertia: Sym3<S>,
    pub bias: Force<S>,
}

/// The result of one DoF's elimination: U/d, u/d and 1/d with U = Iᴬ s, d = sᵀU, u = τ − sᵀpᴬ. **(RBDA eq.
/// 7.43–7.45)**
#[derive(Clone, Copy, Debug)]
pub struct DofElimination<S: Scalar> {
    pub column: Force<S>,
    pub residual: S,
    pub inverse: S,
}

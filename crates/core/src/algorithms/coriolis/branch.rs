//! A subtree as the ancestors of its root need it.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::kinematics::shifts::pass_inward;
use crate::kinematics::world_frame::momentum_of;
use crate::model::Body;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{MassFlux, SpatialInertia};
use crate::spatial::motion::MotionVector;

impl<S: Scalar> MassFlux<S> {
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.momentum += other.momentum;
        self.first_moment_rate = self.first_moment_rate + other.first_moment_rate;
    }

    /// f = m u + ω × h and D = u hᵀ + \[ω\]×Σ of a rigid set of points, with Σ = ∫ p pᵀ dm.
    #[inline(always)]
    pub fn of(inertia: &SpatialInertia<S>, twist: &MotionVector<S>) -> Self {
        let (u, w, h) = (twist.linear, twist.angular, inertia.first_moment);
        // Σ = ½ tr(I) 1 − I is symmetric: its columns are its rows.
        let [[xx, ..], [_, yy, _], [_, _, zz]] = inertia.inertia.full().rows();
        let half_trace = Sym3::multiple_of_identity((xx + yy + zz).scale(0.5));
        let sigma = half_trace.full() - inertia.inertia.full();
        let columns = [
            w.cross(sigma.column(0)).add_scaled(h.get(0), u),
            w.cross(sigma.column(1)).add_scaled(h.get(1), u),
            w.cross(sigma.column(2)).add_scaled(h.get(2), u),
        ];
        Self {
            momentum: w.cross(h).add_scaled(inertia.mass, u),
            first_moment_rate: M3::from_columns(columns),
        }
    }
}

/// The subtree of a DoF i, reduced to three vectors for its ancestors.
pub(crate) struct Branch<S: Scalar> {
    /// I Ṡ_i + B S_i.
    pub above: ForceVector<S>,
    /// I S_i.
    pub inertial: ForceVector<S>,
    /// The moment of Bᵀ S_i; its force is zero.
    pub turning: V3<S>,
}

impl<S: Scalar> Branch<S> {
    #[inline(always)]
    pub(crate) fn new(
        inertia: &SpatialInertia<S>,
        flow: &MassFlux<S>,
        s: &MotionVector<S>,
        rate: &MotionVector<S>,
    ) -> Self {
        let d = &flow.first_moment_rate;
        let [[xx, ..], [_, yy, _], [_, _, zz]] = d.rows();
        let stretched = s.angular * (xx + yy + zz);
        let mut above = momentum_of(inertia, rate);
        above.linear += s.angular.cross(flow.momentum);
        above.angular += stretched - *d * s.angular;
        let turning = flow.momentum.cross(s.linear) + stretched - d.transpose_mul(s.angular);
        Self { above, inertial: momentum_of(inertia, s), turning }
    }

    /// Moves the vectors from a body's reference point to its parent's. The moment of Bᵀ S_i has no force, so
    /// it is the same about every point.
    #[inline(always)]
    pub(crate) fn pass_inward(&mut self, body: &Body, levers: &[V3<S>]) {
        pass_inward(body, levers, &mut self.above);
        pass_inward(body, levers, &mut self.inertial);
    }

    /// C_ji = S_jᵀ(I Ṡ_i + B S_i).
    #[inline(always)]
    pub(crate) fn above(&self, s: &MotionVector<S>) -> S {
        s.dot(&self.above)
    }

    /// C_ij = S_iᵀ(I Ṡ_j + B S_j).
    #[inline(always)]
    pub(crate) fn beyond(&self, s: &MotionVector<S>, rate: &MotionVector<S>) -> S {
        self.inertial.dot(rate) + self.turning.dot(s.angular)
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::kinematics::world_frame::{force_cross, motion_cross};

    /// B of the module's documentation, applied to each unit motion, is ½((V×*)I − I(V×) + (IV)×̄*), where
    /// F ×̄* S = S ×* F. Entries are products of three numbers below 3: 1e-13 allows about twenty rounding
    /// errors.
    #[test]
    fn body_matrix_is_echeandia_and_wensings() {
        let mut random = SplitMix64::new(5);
        for _ in 0..20 {
            let mut vector = || V3::new([(); 3].map(|()| random.uniform(-2.0, 2.0)));
            let twist = MotionVector { linear: vector(), angular: vector() };
            // A point mass and a rotational inertia. The identity is algebraic, so any symmetric numbers will
            // do.
            let ([a, b, c], [d, e, f]) = (vector().array(), vector().array());
            let inertia = SpatialInertia {
                mass: 1.7,
                first_moment: vector(),
                inertia: Sym3::from_columns(&M3::from_rows([[a, b, c], [b, d, e], [c, e, f]])),
            };
            let flow = MassFlux::of(&inertia, &twist);
            for axis in 0..6 {
                let mut s = MotionVector::zero();
                let mut unit = [0.0; 3];
                unit[axis % 3] = 1.0;
                *(if axis < 3 { &mut s.linear } else { &mut s.angular }) = V3::new(unit);
                let found = Branch::new(&inertia, &flow, &s, &MotionVector::zero()).above;
                let first = force_cross(&twist, &momentum_of(&inertia, &s));
                let second = momentum_of(&inertia, &motion_cross(&twist, &s));
                let third = force_cross(&s, &momentum_of(&inertia, &twist));
                for i in 0..3 {
                    let linear = 0.5 * (first.linear.get(i) - second.linear.get(i) + third.linear.get(i));
                    let angular = 0.5 * (first.angular.get(i) - second.angular.get(i) + third.angular.get(i));
                    assert!((found.linear.get(i) - linear).abs() < 1e-13, "{found:?}, axis {axis}");
                    assert!((found.angular.get(i) - angular).abs() < 1e-13, "{found:?}, axis {axis}");
                }
            }
        }
    }
}

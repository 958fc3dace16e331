//! Operations on articulated-body inertias. **(RBDA §7.1)**

#![allow(non_snake_case)] // the book's U

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{ArticulatedInertia, DofElimination};
use crate::spatial::motion::MotionVector;

impl<S: Scalar> ArticulatedInertia<S> {
    /// Iᴬ a.
    #[inline(always)]
    pub(super) fn times(&self, a: &MotionVector<S>) -> ForceVector<S> {
        let back = if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back * a.linear
        } else {
            self.coupling.transpose_mul(a.linear)
        };
        ForceVector {
            linear: self.mass * a.linear + self.coupling * a.angular,
            angular: back + self.inertia * a.angular,
        }
    }

    /// The pivot of one DoF's elimination, with U and 1/d.
    #[inline(always)]
    pub(super) fn pivot(
        &self,
        s: &MotionVector<S>,
        tau: S,
        armature: S,
    ) -> (DofElimination<S>, ForceVector<S>, S) {
        let U = self.times(s);
        let d = s.dot(&U) + armature;
        let u = tau - s.dot(&self.bias);
        let inverse = S::one() / d;
        let scaled = ForceVector { linear: U.linear * inverse, angular: U.angular * inverse };
        (DofElimination { column: scaled, residual: u * inverse, inverse }, U, inverse)
    }

    /// Iᵃ = Iᴬ − U Uᵀ/d, pᵃ = pᴬ + U u/d, in place.
    #[inline(always)]
    pub(super) fn eliminate(&mut self, pivot: &DofElimination<S>, U: &ForceVector<S>, inverse: S) {
        let ((f, n), (fd, nd)) = ((U.linear, U.angular), (pivot.column.linear, pivot.column.angular));
        self.mass = self.mass.minus_square(f, inverse, fd);
        self.coupling = self.coupling.minus_scaled_outer(f, n, inverse, nd);
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = self.coupling_back.minus_scaled_outer(n, f, inverse, fd);
        }
        self.inertia = self.inertia.minus_square(n, inverse, nd);
        self.bias.add_scaled(pivot.residual, U);
    }

    /// Moves the reference point; d goes from the new point to the old one: H′ = H − M \[d\]×,
    /// I′ = I − Hᵀ\[d\]× + \[d\]× H′.
    #[inline(always)]
    pub(super) fn shift(&mut self, d: V3<S>) {
        let (cross, mass) = (M3::skew(d), self.mass.full());
        let coupling = self.coupling - mass.times(&cross);
        let inertia = self.inertia.full() - self.coupling.transpose().times(&cross) + cross.times(&coupling);
        self.inertia = Sym3::from_columns(&inertia);
        self.coupling = coupling;
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = coupling.transpose();
        }
        self.bias.angular += d.cross(self.bias.linear);
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.mass = self.mass + other.mass;
        self.coupling = self.coupling + other.coupling;
        if M3::<S>::KEEPS_TRANSPOSE {
            self.coupling_back = self.coupling_back + other.coupling_back;
        }
        self.inertia = self.inertia + other.inertia;
        self.bias.add(&other.bias);
    }
}

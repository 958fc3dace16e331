//! The law of an inertia box: see [`FluidForm::InertiaBox`](robot_dynamics_description::FluidForm).

use core::f64::consts::PI;

use nalgebra::{Matrix6, Vector3};
use robot_dynamics_description::Medium;

use crate::fluid::pair::Pair;

/// For each part, linear and angular, the linear drag, and the quadratic drag of each axis.
#[derive(Clone, Debug)]
pub(in crate::fluid) struct BoxLaw {
    viscous: [f64; 2],
    quadratic: Pair,
}

impl BoxLaw {
    pub(super) fn new(size: [f64; 3], medium: &Medium) -> Self {
        let Medium { density, viscosity, .. } = *medium;
        let diameter = size.iter().sum::<f64>() / 3.0;
        let [a, b, c] = size;
        let fourth = |x: f64| (x * x) * (x * x);
        let turning = |edge: f64, one: f64, other: f64| density * edge * (fourth(one) + fourth(other)) / 64.0;
        Self {
            viscous: [3.0 * PI * diameter * viscosity, PI * diameter.powi(3) * viscosity],
            quadratic: [
                Vector3::new(b * c, a * c, a * b) * (0.5 * density),
                Vector3::new(turning(a, b, c), turning(b, a, c), turning(c, a, b)),
            ],
        }
    }

    pub(super) fn force(&self, velocity: &Pair) -> Pair {
        core::array::from_fn(|part| {
            let drag =
                self.quadratic[part].component_mul(&velocity[part].abs()).add_scalar(self.viscous[part]);
            -drag.component_mul(&velocity[part])
        })
    }

    pub(super) fn derivative(&self, velocity: &Pair) -> Matrix6<f64> {
        let mut derivative = Matrix6::zeros();
        for i in 0..6 {
            let (part, axis) = (i / 3, i % 3);
            let speed = velocity[part][axis].abs();
            derivative[(i, i)] = -(self.viscous[part] + 2.0 * self.quadratic[part][axis] * speed);
        }
        derivative
    }
}

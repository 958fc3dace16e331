//! The relation y = p(x) of two positions.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;

use super::position::CoupledPosition;
use crate::placement::{BodyMotion, Placement};

/// y = p(x), with positions that count from their references.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PolynomialRelation {
    pub(crate) position: CoupledPosition,
    pub(crate) leader: CoupledPosition,
    pub(crate) polynomial: [f64; 5],
}

impl PolynomialRelation {
    /// Whether it depends on the placement of the bodies.
    pub(super) fn needs_placement(&self) -> bool {
        self.position.needs_placement() || self.leader.needs_placement()
    }

    /// The coordinates of its row.
    pub(crate) fn coordinates(&self, model: &Model) -> BTreeSet<usize> {
        let mut all = self.position.coordinates(model);
        all.extend(self.leader.coordinates(model));
        all
    }

    /// φ = y − p(x) at q, and calls `add` with the entries of its row. `memory` has nv entries.
    pub(crate) fn place(
        &self,
        model: &Model,
        (placement, q): (&Placement, &[f64]),
        memory: &mut [f64],
        mut add: impl FnMut(usize, f64),
    ) -> f64 {
        let Self { position, leader, polynomial } = self;
        let [p, slope, _] = polynomial_at(polynomial, leader.at(placement, q));
        position.each_derivative(model, placement, memory, &mut add);
        leader.each_derivative(model, placement, memory, |k, c| add(k, -slope * c));
        position.at(placement, q) - p
    }

    /// Ȧv = ÿ − p′ẍ − p″ẋ² at v̇ = 0. `motions` are those of the bodies, if it needs their placement.
    pub(super) fn bias(
        &self,
        model: &Model,
        placement: &Placement,
        (q, v): (&[f64], &[f64]),
        motions: &[BodyMotion],
    ) -> f64 {
        let Self { position, leader, polynomial } = self;
        let [_, slope, half_curvature] = polynomial_at(polynomial, leader.at(placement, q));
        let [_, second] = position.motion(model, placement, v, motions);
        let [rate, leader_second] = leader.motion(model, placement, v, motions);
        second - slope * leader_second - 2.0 * half_curvature * rate.powi(2)
    }
}

/// p, p′ and ½p″ of a polynomial at x, by Horner's rule.
fn polynomial_at(polynomial: &[f64; 5], x: f64) -> [f64; 3] {
    let [mut p, mut slope, mut half_curvature] = [0.0; 3];
    for c in polynomial.iter().rev() {
        half_curvature = half_curvature * x + slope;
        slope = slope * x + p;
        p = p * x + c;
    }
    [p, slope, half_curvature]
}

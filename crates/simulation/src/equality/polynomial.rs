//! The relation y = p(x) of two positions.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;

use super::position::CoupledPosition;
use super::site_derivatives::RowWeights;
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
        let [p, slope, ..] = polynomial_at(polynomial, leader.at(placement, q));
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
        let [_, slope, half_curvature, _] = polynomial_at(polynomial, leader.at(placement, q));
        let [_, second] = position.motion(model, placement, v, motions);
        let [rate, leader_second] = leader.motion(model, placement, v, motions);
        second - slope * leader_second - 2.0 * half_curvature * rate.powi(2)
    }

    /// Calls `visit` with coordinates and the derivatives by q and v of w₁ r + w₂ φ̇, with r = ÿ − p′ẍ − p″ẋ²
    /// and φ̇ = ẏ − p′ẋ.
    pub(super) fn each_derivative(
        &self,
        model: &Model,
        motion: (&Placement, &[BodyMotion]),
        state: [&[f64]; 3],
        weights: RowWeights,
        mut visit: impl FnMut(usize, [f64; 2]),
    ) {
        let [_, slope, half_curvature, sixth] =
            polynomial_at(&self.polynomial, self.leader.at(motion.0, state[0]));
        let (curvature, third) = (2.0 * half_curvature, 6.0 * sixth);
        let RowWeights { acceleration, rate } = weights;
        for entry in self.position.derivatives(model, motion, state).entries {
            visit(
                entry.coordinate,
                [
                    acceleration * entry.second_by_position + rate * entry.rate_by_position,
                    acceleration * entry.second_by_velocity + rate * entry.slope,
                ],
            );
        }
        let leader = self.leader.derivatives(model, motion, state);
        for entry in leader.entries {
            let by_position = slope * entry.second_by_position
                + (curvature * leader.second + third * leader.rate.powi(2)) * entry.slope
                + 2.0 * curvature * leader.rate * entry.rate_by_position;
            let by_velocity = slope * entry.second_by_velocity + 2.0 * curvature * leader.rate * entry.slope;
            let rate_by_position = slope * entry.rate_by_position + curvature * leader.rate * entry.slope;
            visit(
                entry.coordinate,
                [
                    -acceleration * by_position - rate * rate_by_position,
                    -acceleration * by_velocity - rate * slope * entry.slope,
                ],
            );
        }
    }

    /// Calls `add` with the entries (i, j) of ∂Aᵀ/∂q = ∂²y − p′∂²x − p″ ∂x ∂xᵀ.
    pub(super) fn force_derivative(
        &self,
        model: &Model,
        motion: (&Placement, &[BodyMotion]),
        q: &[f64],
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let [_, slope, half_curvature, _] = polynomial_at(&self.polynomial, self.leader.at(motion.0, q));
        self.position.row_derivative(model, motion, &mut add);
        self.leader.row_derivative(model, motion, |i, j, entry| add(i, j, -slope * entry));
        let mut row = Vec::new();
        let mut memory = vec![0.0; model.nv()];
        self.leader.each_derivative(model, motion.0, &mut memory, |k, entry| row.push((k, entry)));
        for &(i, one) in &row {
            for &(j, other) in &row {
                add(i, j, -2.0 * half_curvature * one * other);
            }
        }
    }
}

/// p, p′, ½p″ and ⅙p‴ of a polynomial at x, by Horner's rule.
fn polynomial_at(polynomial: &[f64; 5], x: f64) -> [f64; 4] {
    let [mut p, mut slope, mut half_curvature, mut sixth] = [0.0; 4];
    for c in polynomial.iter().rev() {
        sixth = sixth * x + half_curvature;
        half_curvature = half_curvature * x + slope;
        slope = slope * x + p;
        p = p * x + c;
    }
    [p, slope, half_curvature, sixth]
}

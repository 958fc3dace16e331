//! The limits at a point of the path as half-planes of (u, x) = (s̈, ṡ²).
//!
//! With w = ṡ = √x the torque of coordinate k is τ = a u + b x + c + f + d w: dry friction f has the sign of
//! q′, and d = damping · q′. Limits of τ have the term d w, and |τ q′| ≤ P/w is the limit of power. Both are
//! linearised at a reference x̄ on the conservative side, where the exact term and its bound agree:
//! - √x ≤ (√x̄ + x/√x̄)/2, the tangent of a concave function;
//! - √x ≥ the chords of the concave function over \[0, x̄\] and intervals above x̄;
//! - 1/√x ≥ (3 − x/x̄)/(2√x̄), the tangent of a convex function.
//!
//! A solution of the linearised limits therefore obeys the exact ones. If the reference obeys the exact
//! limits, it obeys the linearised ones, so the next solution is at least as fast. This is the convex-concave
//! procedure. Source: Yuille, Rangarajan, *The concave-convex procedure*, Neural Computation 15 (2003).

use robot_dynamics_core::{Model, Workspace, dissipation, dissipation_derivative};

use super::half_planes::HalfPlanes;
use super::sample::NEARBY;
use super::{MotionLimits, PathCoefficients, TreePathPoint, path_coefficients};

/// The ends of chords of √x, as multiples of √x̄. Short chords above x̄ follow the tangent.
const CHORD_ENDS: [f64; 4] = [0.0, 1.0, 1.1, 2.0];

/// The side of a grid point: the end of the interval before it, or the start of the interval after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Before,
    After,
}

/// The dynamics at a grid point.
#[derive(Debug)]
pub(super) struct PathPoint {
    pub(super) coefficients: PathCoefficients,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    /// damping · q′.
    viscous: Vec<f64>,
    /// friction · sign q′ before and after the point.
    friction: [Vec<f64>; 2],
    /// The largest x within the limits of velocity.
    largest: f64,
}

/// α u + β x + γ.
#[derive(Clone, Copy)]
struct Affine {
    u: f64,
    x: f64,
    constant: f64,
}

impl Affine {
    fn scaled(self, k: f64) -> Self {
        Self { u: k * self.u, x: k * self.x, constant: k * self.constant }
    }
}

/// The place of x in the variables of an interval, and the reference of the linearisation.
#[derive(Clone, Copy)]
pub(super) struct Linearization {
    /// x here is x at the interval's start plus 2 · `ahead` · u.
    pub(super) ahead: f64,
    pub(super) side: Side,
    /// x̄; 0 where x is known to be zero. Without it the terms with w are left out.
    pub(super) reference: Option<f64>,
}

impl PathPoint {
    /// The dynamics at a point whose neighbours in the grid are at these distances; `None` if a number is not
    /// finite.
    pub(super) fn new(
        model: &Model,
        workspace: &mut Workspace,
        point: TreePathPoint,
        distances: [f64; 2],
        limits: &MotionLimits,
    ) -> Option<Self> {
        let coefficients = path_coefficients(model, workspace, &point);
        let TreePathPoint { q, dq, ddq } = point;
        let numbers = coefficients.a.iter().chain(&coefficients.b).chain(&coefficients.c);
        if numbers.chain(q.iter().chain(&dq).chain(&ddq)).any(|x| !x.is_finite()) {
            return None;
        }
        let zero = vec![0.0; dq.len()];
        let (mut viscous, mut friction) = (zero.clone(), [zero.clone(), zero]);
        if limits.dissipation {
            dissipation_derivative(model, &mut viscous);
            for (friction, step) in friction.iter_mut().zip([-distances[0], distances[1]]) {
                // The direction of a coordinate that turns here is that of its interval.
                let rate: Vec<f64> = dq.iter().zip(&ddq).map(|(dq, ddq)| dq + ddq * NEARBY * step).collect();
                dissipation(model, &rate, friction);
                let damping = viscous.iter().zip(&rate);
                friction
                    .iter_mut()
                    .zip(damping)
                    .for_each(|(force, (b, rate)): (&mut f64, _)| *force -= b * rate);
            }
            viscous.iter_mut().zip(&dq).for_each(|(b, dq)| *b *= dq);
        }
        let bounds = dq.iter().zip(&limits.velocity).filter(|(dq, _)| **dq != 0.0);
        let largest = bounds.map(|(dq, v)| (v / dq).powi(2)).fold(f64::INFINITY, f64::min);
        Some(Self { coefficients, dq, ddq, viscous, friction, largest })
    }

    /// Whether a limit has a term with w.
    pub(super) fn has_roots(&self, limits: &MotionLimits) -> bool {
        let damped = self.viscous.iter().any(|b| *b != 0.0);
        damped || limits.power.iter().any(|power| power.is_finite())
    }

    /// τ at rest, at the start of the interval that follows.
    pub(super) fn torque_at_rest(&self, k: usize) -> f64 {
        self.coefficients.c[k] + self.friction[Side::After as usize][k]
    }

    /// Adds all limits of the point.
    pub(super) fn add_limits(&self, planes: &mut HalfPlanes, limits: &MotionLimits, place: Linearization) {
        let PathCoefficients { a, b, c } = &self.coefficients;
        let friction = &self.friction[place.side as usize];
        // The reachable sets of the next point contain these limits of x there.
        if place.ahead == 0.0 {
            planes.add(0.0, 1.0, self.largest);
            if place.reference.is_some() && self.has_roots(limits) {
                place.add_trust(planes);
            }
        }
        for k in 0..self.dq.len() {
            let (dq, d) = (self.dq[k], self.viscous[k]);
            let tau = Affine { u: a[k], x: b[k], constant: c[k] + friction[k] };
            place.add(planes, tau, d, limits.torque_upper[k]);
            place.add(planes, tau.scaled(-1.0), -d, -limits.torque_lower[k]);
            let acceleration = Affine { u: dq, x: self.ddq[k], constant: 0.0 };
            place.add(planes, acceleration, 0.0, limits.acceleration[k]);
            place.add(planes, acceleration.scaled(-1.0), 0.0, limits.acceleration[k]);
            if let (Some(reference), true) = (place.reference, limits.power[k].is_finite() && dq != 0.0) {
                place.add_power(planes, tau.scaled(dq), d * dq, limits.power[k], reference);
            }
        }
    }
}

impl Linearization {
    /// Adds α u + β x + γ + d √x ≤ limit.
    fn add(self, planes: &mut HalfPlanes, affine: Affine, d: f64, limit: f64) {
        let mut row = |slope: f64, offset: f64| {
            let beta = affine.x + slope;
            planes.add(affine.u + 2.0 * self.ahead * beta, beta, limit - affine.constant - offset);
        };
        let reference = self.reference.unwrap_or(0.0);
        if d == 0.0 || reference == 0.0 {
            row(0.0, 0.0);
        } else if d > 0.0 {
            let root = reference.sqrt();
            row(0.5 * d / root, 0.5 * d * root);
        } else {
            let root = reference.sqrt();
            for ends in CHORD_ENDS.windows(2) {
                // The chord from (p², p) to (r², r) is (x + p r)/(p + r).
                let (p, r) = (ends[0] * root, ends[1] * root);
                row(d / (p + r), d * p * r / (p + r));
            }
        }
    }

    /// Adds −P ≤ (α u + β x + γ + d w) w ≤ P, where the brackets hold τ q′.
    fn add_power(self, planes: &mut HalfPlanes, affine: Affine, d: f64, power: f64, reference: f64) {
        if reference == 0.0 {
            return;
        }
        let root = reference.sqrt();
        let (slope, largest) = (0.5 * power / (reference * root), 1.5 * power / root);
        for sign in [1.0, -1.0] {
            let side = affine.scaled(sign);
            self.add(planes, Affine { x: side.x + slope, ..side }, sign * d, largest);
        }
    }

    /// The chords bound √x from below only up to the last of their ends.
    fn add_trust(self, planes: &mut HalfPlanes) {
        let last = CHORD_ENDS[CHORD_ENDS.len() - 1];
        planes.add(0.0, 1.0, last * last * self.reference.unwrap_or(0.0));
    }
}

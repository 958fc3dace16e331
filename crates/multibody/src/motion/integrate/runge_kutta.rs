//! The classical Runge–Kutta step on a manifold, after Munthe-Kaas.

use dynamics::DynamicsError;

use super::explicit::{add_scaled, arrive};
use super::{StepForces, StepWorkspace, accelerate};
use crate::joint::Chart;
use crate::space::configuration::{Stretch, stretches, vector_at};
use crate::spatial::algebra::V3;
use crate::{Model, integrate};

/// The classical four stages for (Θ, v), where q = q₀ ⊕ Θ: order 4 on every joint. **(HLW §IV.8)**
///
/// Θ obeys Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\] + O(|Θ|⁴): the brackets vanish where q is a plain number, which
/// leaves the classical method.
pub(super) fn runge_kutta4(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), DynamicsError> {
    workspace.displacement.fill(0.0);
    workspace.q_sum.fill(0.0);
    workspace.v_sum.fill(0.0);
    // (where the stage is reached from the one before, as a fraction of h; its weight in the sum)
    for (reach, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let StepWorkspace { displacement, v: v_stage, acceleration, .. } = &mut *workspace;
        for d in displacement.iter_mut() {
            *d *= reach * h;
        }
        if reach == 0.0 {
            v_stage.copy_from_slice(v);
        } else {
            for ((stage, v), a) in v_stage.iter_mut().zip(&*v).zip(&*acceleration) {
                *stage = v + reach * h * a;
            }
        }
        let mut q_stage = core::mem::take(&mut workspace.q);
        let v_stage = core::mem::take(&mut workspace.v);
        integrate(model, q, &workspace.displacement, &mut q_stage);
        let accelerated = accelerate(model, workspace, forces, &q_stage, &v_stage);
        displacement_rate(model, &mut workspace.displacement, &v_stage);
        (workspace.q, workspace.v) = (q_stage, v_stage);
        accelerated?;
        add_scaled(&mut workspace.q_sum, weight, &workspace.displacement);
        add_scaled(&mut workspace.v_sum, weight, &workspace.acceleration);
    }
    for d in &mut workspace.q_sum {
        *d *= h / 6.0;
    }
    integrate(model, q, &workspace.q_sum, &mut workspace.q);
    workspace.v.copy_from_slice(v);
    add_scaled(&mut workspace.v, h / 6.0, &workspace.v_sum);
    arrive(workspace, q, v)
}

/// Θ ← Θ̇(Θ, v).
pub(crate) fn displacement_rate(model: &Model, theta: &mut [f64], v: &[f64]) {
    // A follower's stretch comes again; its leader is a plain number, where Θ̇ = v whatever Θ is.
    for Stretch { chart, v: k, .. } in stretches(model) {
        match chart {
            Chart::Line => theta[k] = v[k],
            Chart::Rotation => {
                let (t, w) = (vector_at(theta, k), vector_at(v, k));
                let once = t.cross(w);
                let rate = w + once * 0.5 + t.cross(once) * (1.0 / 12.0);
                theta[k..k + 3].copy_from_slice(&rate.array());
            }
            Chart::Placement => {
                let t = (vector_at(theta, k), vector_at(theta, k + 3));
                let w = (vector_at(v, k), vector_at(v, k + 3));
                let once = bracket(t, w);
                let twice = bracket(t, once);
                let rate = |w: V3<f64>, a: V3<f64>, b: V3<f64>| w + a * 0.5 + b * (1.0 / 12.0);
                theta[k..k + 3].copy_from_slice(&rate(w.0, once.0, twice.0).array());
                theta[k + 3..k + 6].copy_from_slice(&rate(w.1, once.1, twice.1).array());
            }
        }
    }
}

/// The Lie bracket of se(3), linear part first: \[(u,ω),(u′,ω′)\] = (ω × u′ + u × ω′, ω × ω′). **(MR §8.2.2)**
pub(crate) fn bracket(a: (V3<f64>, V3<f64>), b: (V3<f64>, V3<f64>)) -> (V3<f64>, V3<f64>) {
    (a.1.cross(b.0) + a.0.cross(b.1), a.1.cross(b.1))
}

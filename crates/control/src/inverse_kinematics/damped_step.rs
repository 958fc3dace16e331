//! The damped least-squares step within the limits.

use nalgebra::{Matrix6, Vector6};

/// The memory for the steps of one robot.
pub(super) struct DampedStep {
    /// Jₑ, 6×nv, column by column; rows that are not controlled are zero.
    pub jacobian: Vec<Vector6<f64>>,
    /// The distances of each coordinate from its lower and upper limit.
    pub room: Vec<(f64, f64)>,
    /// δ.
    pub step: Vec<f64>,
    fixed: Vec<bool>,
}

impl DampedStep {
    pub(super) fn new(nv: usize) -> Self {
        Self {
            jacobian: vec![Vector6::zeros(); nv],
            room: vec![(f64::NEG_INFINITY, f64::INFINITY); nv],
            step: vec![0.0; nv],
            fixed: vec![false; nv],
        }
    }

    /// δ that minimizes |e + Jₑδ|² + λ|δ|², where each coordinate that would exceed its limit stops there.
    /// Returns e + Jₑδ.
    ///
    /// A coordinate that is fixed at a limit changes the problem of the free ones, δ = −Jᵀ(J Jᵀ + λ 1)⁻¹(e +
    /// J_fixed δ_fixed). The problem is solved again until no coordinate exceeds its limit, at most nv + 1
    /// times. As λ → ∞ only coordinates that the gradient itself pushes outwards remain fixed.
    pub(super) fn solve(&mut self, error: &Vector6<f64>, damping: f64) -> Option<Vector6<f64>> {
        let Self { jacobian, room, step, fixed } = self;
        fixed.fill(false);
        step.fill(0.0);
        let mut remaining = *error;
        loop {
            let mut gram = Matrix6::identity() * damping;
            for (column, _) in jacobian.iter().zip(&*fixed).filter(|(_, fixed)| !**fixed) {
                gram.ger(1.0, column, column, 1.0);
            }
            let force = gram.cholesky()?.solve(&remaining);
            let mut is_done = true;
            for (k, column) in jacobian.iter().enumerate() {
                if fixed[k] {
                    continue;
                }
                let (low, high) = room[k];
                step[k] = -column.dot(&force);
                if step[k] < low || step[k] > high {
                    step[k] = step[k].clamp(low, high);
                    fixed[k] = true;
                    remaining += column * step[k];
                    is_done = false;
                }
            }
            if is_done {
                break;
            }
        }
        let change: Vector6<f64> = jacobian.iter().zip(&*step).map(|(column, x)| column * *x).sum();
        Some(error + change)
    }
}

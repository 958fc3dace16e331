//! Gains of the springs, dampers and servos that a method treats explicitly.

use robot_dynamics_core::Model;

use crate::Actuation;
use crate::motion::step_actuation::StepActuation;

/// Adds K and D of the joints' springs and, with `dissipation`, of their dampers.
pub fn add_passive_gains(model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
    let nv = model.nv();
    for dof in &model.dofs {
        let (at, square) = (dof.coordinate * (nv + 1), dof.ratio * dof.ratio);
        stiffness[at] += square * dof.passive.stiffness.max(0.0);
        damping[at] += if dissipation { square * dof.passive.damping.max(0.0) } else { 0.0 };
    }
}

/// Adds K and D of tendons and servos.
pub(crate) fn add_actuation_gains(
    actuation: &Actuation,
    nv: usize,
    stiffness: &mut [f64],
    damping: &mut [f64],
) {
    let (mut k, mut d, mut couplings) = (vec![0.0; nv], vec![0.0; nv], Vec::new());
    actuation.add_gains(&mut k, &mut d, &mut couplings);
    for i in 0..nv {
        stiffness[i * (nv + 1)] += k[i];
        damping[i * (nv + 1)] += d[i];
    }
    for coupling in &couplings {
        for &(i, one) in &coupling.row {
            for &(j, other) in &coupling.row {
                stiffness[i * nv + j] += coupling.stiffness * one * other;
                damping[i * nv + j] += coupling.damping * one * other;
            }
        }
    }
}

impl StepActuation {
    /// Adds K and D of its tendons and servos.
    pub(crate) fn add_gains(&self, nv: usize, stiffness: &mut [f64], damping: &mut [f64]) {
        add_actuation_gains(self.actuation(), nv, stiffness, damping);
    }
}

//! The sign of health of the Coriolis matrix.

use crate::{Workspace, coriolis_matrix, mass_matrix_rate};
use dynamics::Dual;

use super::check::{Check, Worst};
use super::probe::{Probe, ROUNDING};

/// Ṁ − 2C is skew-symmetric, with Ṁ by differentiating M along the motion, which sees no C.
pub(super) fn defect(probe: &Probe<'_>) -> Check {
    let mut worst = Worst::of("skew", "Ṁ − 2C skew-symmetric");
    let (model, oracle, nv) = (probe.model, probe.oracle, probe.model.nv());
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(oracle);
    let (mut coriolis, mut rate) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
    for (index, state) in probe.states() {
        coriolis_matrix(model, workspace, &state.q, &state.v, &mut coriolis);
        mass_matrix_rate(oracle, duals, &state.q, &state.v, &mut rate);
        let entry = |i: usize, j: usize| rate[i * nv + j] - 2.0 * coriolis[i * nv + j];
        for i in 0..nv {
            for j in 0..=i {
                worst.see((entry(i, j) + entry(j, i)).abs(), ROUNDING * state.inertia * state.speed, index);
            }
        }
    }
    worst.check()
}

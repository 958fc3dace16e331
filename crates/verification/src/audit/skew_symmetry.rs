//! The skew symmetry of Ṁ − 2C.

use robot_dynamics_core::{Workspace, coriolis_matrix, mass_matrix_rate};
use robot_dynamics_number::Dual;

use super::check::{Check, LargestDefect};
use super::probe::{Probe, ROUNDING};

/// Ṁ − 2C is skew-symmetric, where Ṁ is the derivative of M along the motion and does not involve C.
pub(super) fn defect(probe: &Probe<'_>) -> Check {
    let mut worst = LargestDefect::of("skew", "Ṁ − 2C skew-symmetric");
    let (model, reference, nv) = (probe.model, probe.reference, probe.model.nv());
    let workspace = &mut Workspace::new(model);
    let duals = &mut Workspace::<Dual<f64, 1>>::new(reference);
    let (mut coriolis, mut rate) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
    for (index, state) in probe.states() {
        coriolis_matrix(model, workspace, &state.q, &state.v, &mut coriolis);
        mass_matrix_rate(reference, duals, &state.q, &state.v, &mut rate);
        let entry = |i: usize, j: usize| rate[i * nv + j] - 2.0 * coriolis[i * nv + j];
        for i in 0..nv {
            for j in 0..=i {
                worst.record(
                    (entry(i, j) + entry(j, i)).abs(),
                    ROUNDING * state.inertia * state.speed,
                    index,
                );
            }
        }
    }
    worst.check()
}

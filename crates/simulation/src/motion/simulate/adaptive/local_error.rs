//! The coordinate that limits the step.

use differential_equations::prelude::ODE;

use super::motion::AdaptiveSystem;

/// The coordinate with the largest error over a step of `h`, weighted as in the step control: |error| / (1 +
/// |y|).
///
/// The method does not expose the errors of its steps. The estimate here compares one step of the classical
/// Runge–Kutta method of order 4 with two half steps. It is largest where the motion is fastest, for any
/// method. An entry that is not finite counts as infinite.
pub(super) fn least_accurate(motion: &AdaptiveSystem<'_, '_>, t: f64, y: &[f64], h: f64) -> String {
    let whole = step(motion, t, y, h);
    let half = step(motion, t, y, 0.5 * h);
    let halves = step(motion, t + 0.5 * h, &half, 0.5 * h);
    let model = motion.model;
    let (nq, nv) = (model.nq(), model.nv());
    let error = |i: usize| {
        let error = (whole[i] - halves[i]).abs() / (1.0 + y[i].abs());
        if error.is_nan() { f64::INFINITY } else { error }
    };
    // The last two entries of y are the energy account and belong to no coordinate.
    let largest = (0..nq + nv).max_by(|&i, &j| error(i).total_cmp(&error(j))).unwrap_or(0);
    let coordinate = if largest >= nq {
        largest - nq
    } else {
        let owner = model.joints().iter().find(|j| j.q().contains(&largest));
        // The four numbers of a quaternion do not match its three axes one to one, so the last entries share
        // a name.
        owner.map_or(0, |joint| joint.v_index + (largest - joint.q_index).min(joint.nv - 1))
    };
    model.coordinate_names().get(coordinate).cloned().unwrap_or_default()
}

/// One classical Runge–Kutta step.
fn step(motion: &AdaptiveSystem<'_, '_>, t: f64, y: &[f64], h: f64) -> Vec<f64> {
    let at = |slope: &[f64], fraction: f64| -> Vec<f64> {
        y.iter().zip(slope).map(|(y, slope)| y + fraction * h * slope).collect()
    };
    let rate = |t: f64, y: &Vec<f64>| {
        let mut rate = vec![0.0; y.len()];
        motion.diff(t, y, &mut rate);
        rate
    };
    let k1 = rate(t, &y.to_vec());
    let k2 = rate(t + 0.5 * h, &at(&k1, 0.5));
    let k3 = rate(t + 0.5 * h, &at(&k2, 0.5));
    let k4 = rate(t + h, &at(&k3, 1.0));
    let mean: Vec<f64> = (0..y.len()).map(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0).collect();
    at(&mean, 1.0)
}

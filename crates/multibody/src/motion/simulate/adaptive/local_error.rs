//! Which coordinate asks for the shortest steps.

use differential_equations::prelude::ODE;

use super::motion::Motion;

/// The coordinate whose error over a step of `h` is the largest, as the step control weighs it: |error| / (1 + |y|).
///
/// The method keeps the errors of its steps to itself. Here the error is that of one step of the classical
/// Runge–Kutta method of order 4 against two half as long, which is largest where the motion is fastest, whatever the
/// method. An entry that is not finite counts as infinite.
pub(super) fn least_accurate(motion: &Motion<'_, '_>, t: f64, y: &[f64], h: f64) -> String {
    let whole = step(motion, t, y, h);
    let half = step(motion, t, y, 0.5 * h);
    let halves = step(motion, t + 0.5 * h, &half, 0.5 * h);
    let model = motion.model;
    let (nq, nv) = (model.nq(), model.nv());
    let error = |i: usize| {
        let error = (whole[i] - halves[i]).abs() / (1.0 + y[i].abs());
        if error.is_nan() { f64::INFINITY } else { error }
    };
    // The books, the last two entries of y, belong to no coordinate.
    let largest = (0..nq + nv).max_by(|&i, &j| error(i).total_cmp(&error(j))).unwrap_or(0);
    let coordinate = if largest >= nq {
        largest - nq
    } else {
        let owner = model.joints().iter().find(|j| (j.q_index..j.q_index + j.nq).contains(&largest));
        // Of a quaternion's four numbers no one belongs to one axis: the last entries share a name.
        owner.map_or(0, |joint| joint.v_index + (largest - joint.q_index).min(joint.nv - 1))
    };
    model.coordinate_names().get(coordinate).cloned().unwrap_or_default()
}

/// One classical Runge–Kutta step.
fn step(motion: &Motion<'_, '_>, t: f64, y: &[f64], h: f64) -> Vec<f64> {
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

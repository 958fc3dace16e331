//! How displacements Θ on the manifold of configurations change.

use crate::Model;
use crate::joint::Chart;
use crate::space::configuration::{Stretch, stretches};
use crate::space::displacement_rate::bracket;
use crate::spatial::algebra::V3;

/// A displacement of one joint: linear and angular part.
type Pair = (V3<f64>, V3<f64>);

/// The joint's part of a vector (stride 1) or of a column of a matrix; a rotation has no linear part.
fn read(x: &[f64], chart: Chart, first: usize, stride: usize) -> Pair {
    let at = |k: usize| V3::new([x[k * stride], x[(k + 1) * stride], x[(k + 2) * stride]]);
    if chart == Chart::Placement { (at(first), at(first + 3)) } else { (V3::zero(), at(first)) }
}

fn write(to: &mut [f64], chart: Chart, first: usize, stride: usize, (linear, angular): Pair) {
    let mut put = |k: usize, x: V3<f64>| {
        x.array().into_iter().enumerate().for_each(|(l, x)| to[(k + l) * stride] = x);
    };
    if chart == Chart::Placement {
        put(first, linear);
        put(first + 3, angular);
    } else {
        put(first, angular);
    }
}

fn add(a: Pair, k: f64, b: Pair) -> Pair {
    (a.0.add_scaled(k, b.0), a.1.add_scaled(k, b.1))
}

/// Σₖ (−ad Θ)ᵏ x · `first`!/(k + `first`)!: e^(−ad Θ) x for `first` = 0, J(Θ) x for 1.
///
/// Summed until a term no longer counts; the terms grow up to e^|Θ| before, and with them the rounding.
fn series(theta: Pair, x: Pair, first: u32) -> Pair {
    let (mut sum, mut term) = (x, x);
    for k in 1..400 {
        let product = bracket(theta, term);
        term = add((V3::zero(), V3::zero()), -1.0 / f64::from(k + first), product);
        sum = add(sum, 1.0, term);
        let size = |x: Pair| x.0.dot(x.0) + x.1.dot(x.1);
        // An eighth of ε, squared.
        let counts = size(term) > 1e-33 * size(sum);
        if !counts {
            break;
        }
    }
    sum
}

/// The change of q₀ ⊕ Θ, from the changes of Θ and of q₀ itself: e^(−ad Θ) δq₀ + J(Θ) δΘ.
pub(super) fn retraction_change(model: &Model, theta: &[f64], theta_change: &[f64], q_change: &mut [f64]) {
    let (n, width) = (model.nv, 3 * model.nv);
    // A follower names its leader's stretch again: everything below is written, not added.
    for Stretch { chart, v: k, .. } in stretches(model) {
        if chart == Chart::Line {
            let row = k * width..(k + 1) * width;
            q_change[row.clone()].copy_from_slice(&theta_change[row]);
            q_change[k * width + k] += 1.0;
            continue;
        }
        let own = read(theta, chart, k, 1);
        let dimensions = if chart == Chart::Placement { 6 } else { 3 };
        for column in 0..width {
            let changed = series(own, read(&theta_change[column..], chart, k, width), 1);
            let mut total = changed;
            if (k..k + dimensions).contains(&column) {
                let mut unit = [0.0; 6];
                unit[column - k] = 1.0;
                total = add(changed, 1.0, series(own, read(&unit, chart, 0, 1), 0));
            }
            write(&mut q_change[column..], chart, k, width, total);
        }
    }
    debug_assert_eq!(q_change.len(), n * width);
}

/// The change of Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\].
pub(super) fn rate_change(
    model: &Model,
    (theta, theta_change): (&[f64], &[f64]),
    (v, v_change): (&[f64], &[f64]),
    rate_change: &mut [f64],
) {
    let width = 3 * model.nv;
    for Stretch { chart, v: k, .. } in stretches(model) {
        if chart == Chart::Line {
            let row = k * width..(k + 1) * width;
            rate_change[row.clone()].copy_from_slice(&v_change[row]);
            continue;
        }
        let (t, w) = (read(theta, chart, k, 1), read(v, chart, k, 1));
        let once = bracket(t, w);
        for column in 0..width {
            let dt = read(&theta_change[column..], chart, k, width);
            let dw = read(&v_change[column..], chart, k, width);
            let once_change = add(bracket(dt, w), 1.0, bracket(t, dw));
            let twice_change = add(bracket(dt, once), 1.0, bracket(t, once_change));
            let change = add(add(dw, 0.5, once_change), 1.0 / 12.0, twice_change);
            write(&mut rate_change[column..], chart, k, width, change);
        }
    }
}

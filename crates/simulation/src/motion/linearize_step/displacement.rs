//! Derivatives of displacements Θ on the configuration manifold.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::displacement_rate::bracket;
use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_number::algebra::V3;

use crate::motion::integrate::vectors::add_scaled;

/// The displacement of one joint: linear and angular part.
type JointDisplacement = (V3<f64>, V3<f64>);

/// The joint's part of a vector; a rotation has a zero linear part.
fn read(x: &[f64], chart: Chart, first: usize) -> JointDisplacement {
    let at = |k: usize| V3::new([x[k], x[k + 1], x[k + 2]]);
    if chart == Chart::Placement { (at(first), at(first + 3)) } else { (V3::zero(), at(first)) }
}

/// The number of entries in a joint's displacement.
fn dimensions(chart: Chart) -> usize {
    if chart == Chart::Placement { 6 } else { 3 }
}

/// A linear map of the displacements of one joint, by its columns.
struct Map {
    columns: [[f64; 6]; 6],
    dimensions: usize,
}

impl Map {
    fn new(chart: Chart, image: impl Fn(JointDisplacement) -> JointDisplacement) -> Self {
        let (dimensions, mut columns) = (dimensions(chart), [[0.0; 6]; 6]);
        for (index, column) in columns[..dimensions].iter_mut().enumerate() {
            let mut unit = [0.0; 6];
            unit[index] = 1.0;
            let (linear, angular) = image(read(&unit, chart, 0));
            if chart == Chart::Placement {
                column[..3].copy_from_slice(&linear.array());
                column[3..].copy_from_slice(&angular.array());
            } else {
                column[..3].copy_from_slice(&angular.array());
            }
        }
        Self { columns, dimensions }
    }

    /// Adds the product of the map and the joint's rows of a change, `width` numbers each, to the same rows
    /// of another.
    fn add(&self, first: usize, width: usize, change: &[f64], to: &mut [f64]) {
        for (column, change) in
            self.columns[..self.dimensions].iter().zip(change[first * width..].chunks(width))
        {
            for (&entry, to) in column[..self.dimensions].iter().zip(to[first * width..].chunks_mut(width)) {
                add_scaled(to, entry, change);
            }
        }
    }
}

fn add(a: JointDisplacement, k: f64, b: JointDisplacement) -> JointDisplacement {
    (a.0.add_scaled(k, b.0), a.1.add_scaled(k, b.1))
}

/// Σₖ (−ad Θ)ᵏ x · `first`!/(k + `first`)!: e^(−ad Θ) x for `first` = 0, J(Θ) x for 1.
///
/// The sum ends when a term is negligible. Terms may first grow up to e^|Θ|, and the rounding grows with
/// them.
fn series(theta: JointDisplacement, x: JointDisplacement, first: u32) -> JointDisplacement {
    let (mut sum, mut term) = (x, x);
    for k in 1..400 {
        let product = bracket(theta, term);
        term = add((V3::zero(), V3::zero()), -1.0 / f64::from(k + first), product);
        sum = add(sum, 1.0, term);
        let size = |x: JointDisplacement| x.0.dot(x.0) + x.1.dot(x.1);
        // An eighth of ε, squared.
        let counts = size(term) > 1e-33 * size(sum);
        if !counts {
            break;
        }
    }
    sum
}

/// Adds `entry` to the diagonal of the block of δq₀ (0), δv₀ (1) or δτ (2).
pub(in crate::motion) fn add_identity(change: &mut [f64], nv: usize, block: usize, entry: f64) {
    let width = change.len() / nv.max(1);
    for k in 0..nv {
        change[k * width + block * nv + k] += entry;
    }
}

/// The derivative of q₀ ⊕ Θ from those of Θ and of q₀: e^(−ad Θ) δq₀ + J(Θ) δΘ. A change has nv rows, and its
/// first nv columns are those of δq₀.
pub(crate) fn retraction_change(model: &Model, theta: &[f64], theta_change: &[f64], q_change: &mut [f64]) {
    let width = theta_change.len() / model.nv.max(1);
    // A mimic joint repeats the stretch of its leader, so the results are written, not added.
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        if chart == Chart::Line {
            let row = k * width..(k + 1) * width;
            q_change[row.clone()].copy_from_slice(&theta_change[row]);
            q_change[k * width + k] += 1.0;
            continue;
        }
        let own = read(theta, chart, k);
        q_change[k * width..(k + dimensions(chart)) * width].fill(0.0);
        Map::new(chart, |unit| series(own, unit, 1)).add(k, width, theta_change, q_change);
        let turned = Map::new(chart, |unit| series(own, unit, 0));
        for (index, column) in turned.columns[..turned.dimensions].iter().enumerate() {
            for (row, &entry) in column[..turned.dimensions].iter().enumerate() {
                q_change[(k + row) * width + k + index] += entry;
            }
        }
    }
}

/// The derivative of Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\].
pub(in crate::motion) fn rate_change(
    model: &Model,
    (theta, theta_change): (&[f64], &[f64]),
    (v, v_change): (&[f64], &[f64]),
    rate_change: &mut [f64],
) {
    let width = theta_change.len() / model.nv.max(1);
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        if chart == Chart::Line {
            let row = k * width..(k + 1) * width;
            rate_change[row.clone()].copy_from_slice(&v_change[row]);
            continue;
        }
        let (t, w) = (read(theta, chart, k), read(v, chart, k));
        let once = bracket(t, w);
        let by_displacement = Map::new(chart, |dt| {
            let once_change = bracket(dt, w);
            let twice_change = add(bracket(dt, once), 1.0, bracket(t, once_change));
            add(add((V3::zero(), V3::zero()), 0.5, once_change), 1.0 / 12.0, twice_change)
        });
        let by_velocity = Map::new(chart, |dw| {
            let once_change = bracket(t, dw);
            add(add(dw, 0.5, once_change), 1.0 / 12.0, bracket(t, once_change))
        });
        rate_change[k * width..(k + dimensions(chart)) * width].fill(0.0);
        by_displacement.add(k, width, theta_change, rate_change);
        by_velocity.add(k, width, v_change, rate_change);
    }
}

//! The gear of an actuator on a joint of several degrees of freedom.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::model::Joint;
use robot_dynamics_description::Quaternion;

/// The axes of the gear of a spherical or floating joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axes {
    /// Those of v, of the child.
    Child,
    /// Those of the joint's frame.
    Joint,
    /// Those of the joint's frame for forces, and those of the child for moments.
    ChildForMoments,
}

/// The gear of the degrees of freedom of one joint.
#[derive(Clone, Debug)]
pub(super) struct DofGear {
    /// The indices of the joint's first numbers in q and v.
    q: usize,
    v: usize,
    count: usize,
    chart: Chart,
    gear: [f64; 6],
    axes: Axes,
}

impl DofGear {
    pub(super) fn new(model: &Model, joint: &Joint, gear: [f64; 6], axes: Axes) -> Self {
        let stretch = coordinate_ranges(model).find(|stretch| stretch.v == joint.v_index);
        let chart = stretch.map_or(Chart::Line, |stretch| stretch.chart);
        Self { q: joint.q_index, v: joint.v_index, count: joint.nv, chart, gear, axes }
    }

    /// ∂ℓ̇/∂v of the joint's own velocities.
    fn row(&self, q: &[f64]) -> [f64; 6] {
        let [a, b, c, d, e, f] = self.gear;
        let back = |from: usize, part: [f64; 3]| self.rotation(q, from).rotate_back(part);
        match (self.axes, self.chart) {
            (Axes::Child, _) | (_, Chart::Line) | (Axes::ChildForMoments, Chart::Rotation) => self.gear,
            (Axes::Joint, Chart::Rotation) => {
                let [a, b, c] = back(0, [a, b, c]);
                [a, b, c, 0.0, 0.0, 0.0]
            }
            (axes, Chart::Placement) => {
                let [a, b, c] = back(3, [a, b, c]);
                let [d, e, f] = if axes == Axes::Joint { back(3, [d, e, f]) } else { [d, e, f] };
                [a, b, c, d, e, f]
            }
        }
    }

    /// The quaternion from this index of the joint's q.
    fn rotation(&self, q: &[f64], from: usize) -> Quaternion {
        Quaternion::from_xyzw(core::array::from_fn(|k| q[self.q + from + k]))
    }

    /// ℓ and ℓ̇.
    pub(super) fn length_and_rate(&self, q: &[f64], v: &[f64]) -> (f64, f64) {
        let row = self.row(q);
        let rate = (0..self.count).map(|k| row[k] * v[self.v + k]).sum();
        let length = match self.chart {
            Chart::Line => (0..self.count).map(|k| self.gear[k] * q[self.q + k]).sum(),
            Chart::Rotation => {
                // The rotation vector has the same components in both frames.
                let turn = self.rotation(q, 0).log();
                (0..3).map(|k| self.gear[k] * turn[k]).sum()
            }
            Chart::Placement => 0.0,
        };
        (length, rate)
    }

    /// τ += (∂ℓ̇/∂v)ᵀ f.
    pub(super) fn spread(&self, q: &[f64], force: f64, tau: &mut [f64]) {
        let row = self.row(q);
        for k in 0..self.count {
            tau[self.v + k] += row[k] * force;
        }
    }

    /// The change of ℓ in a full turn about the gear, for a spherical joint.
    pub(super) fn period(&self) -> Option<f64> {
        let [a, b, c, ..] = self.gear;
        (self.chart == Chart::Rotation).then(|| core::f64::consts::TAU * (a * a + b * b + c * c).sqrt())
    }
}

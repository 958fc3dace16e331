//! Springs of spherical and floating joints, and the nonlinear terms of their dampers.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::manifold::{coordinate_ranges, quaternion_at, vector_at};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_description::{JointDescription, PolynomialStiffnessDamping, Quaternion};

/// The spring and the damper's nonlinear terms of one such joint.
#[derive(Clone, Debug)]
pub(super) struct PoseSpring {
    /// The indices of its quaternion in q and of ω in v.
    turn: (usize, usize),
    /// The indices of its position and linear velocity, for a floating joint.
    shift: Option<(usize, usize)>,
    stiffness: f64,
    higher_terms: PolynomialStiffnessDamping,
    rest: ([f64; 3], Quaternion),
}

impl PoseSpring {
    /// Removes damping.
    pub(super) fn forget_dissipation(&mut self) {
        self.higher_terms.damping = [0.0; 2];
    }

    /// `None` for a joint without a spring, or of another kind.
    pub(super) fn new(model: &Model, joint: &JointDescription) -> Option<Self> {
        if joint.spring.is_none() && joint.higher_terms.is_zero() {
            return None;
        }
        let own = model.joints.iter().find(|own| own.name == joint.name && own.nv > 0)?;
        let stretch = coordinate_ranges(model).find(|stretch| stretch.v == own.v_index)?;
        let (turn, shift) = match stretch.chart {
            Chart::Line => return None,
            Chart::Rotation => ((stretch.q, stretch.v), None),
            Chart::Placement => ((stretch.q + 3, stretch.v + 3), Some((stretch.q, stretch.v))),
        };
        let spring = joint.spring.unwrap_or_default();
        let rest = (spring.rest.translation, Quaternion::from_rotation(&spring.rest.rotation));
        Some(Self { turn, shift, stiffness: spring.stiffness, higher_terms: joint.higher_terms, rest })
    }

    /// φ = log(q_rest⁻¹ q), and p − p_rest.
    fn stretch(&self, q: &[f64]) -> ([f64; 3], [f64; 3]) {
        let (position, turn) = self.rest;
        let phi = turn.conjugate().times(quaternion_at(q, self.turn.0)).log();
        let shift = self.shift.map_or([0.0; 3], |(at, _)| core::array::from_fn(|i| q[at + i] - position[i]));
        (phi, shift)
    }

    /// The force at a stretch x: −(k + k₂|x| + k₃|x|²) x.
    fn pull(&self, x: [f64; 3]) -> [f64; 3] {
        let [k2, k3] = self.higher_terms.stiffness;
        let length = norm(x);
        x.map(|x| -(self.stiffness + (k2 + k3 * length) * length) * x)
    }

    /// τ += the forces of the spring and the damper.
    pub(super) fn spread(&self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        let (phi, shift) = self.stretch(q);
        add(tau, self.turn.1, self.pull(phi));
        if let Some((_, first)) = self.shift {
            add(tau, first, quaternion_at(q, self.turn.0).rotate_back(self.pull(shift)));
        }
        if self.higher_terms.damping != [0.0; 2] {
            let resist = |rate: [f64; 3]| rate.map(|rate| self.higher_terms.damping_force(rate));
            let (turning, moving) = self.rates(q, v);
            add(tau, self.turn.1, resist(turning));
            if let Some((_, first)) = self.shift {
                add(tau, first, quaternion_at(q, self.turn.0).rotate_back(resist(moving)));
            }
        }
    }

    /// ω along the body's axes, and ṗ along the axes of the joint's parent, by which the damper acts.
    fn rates(&self, q: &[f64], v: &[f64]) -> ([f64; 3], [f64; 3]) {
        let moving = self
            .shift
            .map_or([0.0; 3], |(_, first)| quaternion_at(q, self.turn.0).rotate(vector_at(v, first).array()));
        (vector_at(v, self.turn.1).array(), moving)
    }

    /// ½ k |x|² and the energy of the nonlinear terms \[J\].
    pub(super) fn energy(&self, q: &[f64]) -> f64 {
        let of = |x: [f64; 3]| {
            let length = norm(x);
            0.5 * self.stiffness * length * length + self.higher_terms.energy(length)
        };
        let (phi, shift) = self.stretch(q);
        of(phi) + of(shift)
    }

    /// −Σ f(`rate`)·`mean`: the power that the damper's nonlinear terms dissipate \[W\].
    pub(super) fn lost_power(&self, q: &[f64], rate: &[f64], mean: &[f64]) -> f64 {
        if self.higher_terms.damping == [0.0; 2] {
            return 0.0;
        }
        let ((a, b), (mean_a, mean_b)) = (self.rates(q, rate), self.rates(q, mean));
        let power = |rate: [f64; 3], mean: [f64; 3]| -> f64 {
            rate.iter().zip(mean).map(|(rate, mean)| -self.higher_terms.damping_force(*rate) * mean).sum()
        };
        power(a, mean_a) + power(b, mean_b)
    }

    /// Its coordinates, each with k: the symmetric part of ∂φ/∂Θ has the eigenvalues 1 and ½|φ| cot ½|φ| ≤ 1.
    pub(super) fn gains(&self) -> impl Iterator<Item = (usize, f64)> {
        let coordinates = self.shift.into_iter().flat_map(|(_, first)| first..first + 3);
        coordinates.chain(self.turn.1..self.turn.1 + 3).map(|coordinate| (coordinate, self.stiffness))
    }
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn add(tau: &mut [f64], first: usize, force: [f64; 3]) {
    tau[first..first + 3].iter_mut().zip(force).for_each(|(tau, force)| *tau += force);
}

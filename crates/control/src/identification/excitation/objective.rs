//! The objective of an exciting motion: the information of its states, and barriers of its limits.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, dissipation, inverse_dynamics};
use robot_dynamics_number::{Dual, Scalar};

use super::barrier::Interval;
use super::fourier_series::Basis;
use super::information::information;
use super::options::{ExcitationCriterion, ExcitationLimits, ExcitationOptions};
use super::quasi_newton::Objective;
use crate::identification::BaseParameters;
use crate::identification::record::write_rows;

/// A number with its derivatives by the position, the velocity and the acceleration of one coordinate.
type Tangent = Dual<f64, 3>;

/// The four quantities that have limits, one interval for each coordinate.
#[derive(Clone, Debug)]
pub(super) struct Intervals {
    pub(super) motion: [Vec<Interval>; 3],
    pub(super) torque: Vec<Interval>,
}

impl Intervals {
    pub(super) fn new(limits: &ExcitationLimits, margin: f64) -> Self {
        let position = limits.position.iter().map(|ends| Interval::new(*ends).shrunk(margin)).collect();
        let symmetric = |all: &[f64]| -> Vec<Interval> {
            all.iter().map(|limit| Interval::symmetric(*limit).shrunk(margin)).collect()
        };
        Self {
            motion: [position, symmetric(&limits.velocity), symmetric(&limits.acceleration)],
            torque: symmetric(&limits.torque),
        }
    }
}

/// criterion + μ · mean barrier, over the free coefficients of the series.
pub(super) struct Information<'a> {
    model: &'a Model,
    options: &'a ExcitationOptions,
    workspace: Workspace,
    tangents: Workspace<Tangent>,
    /// The columns of W that are base parameters.
    columns: Vec<usize>,
    /// The number of all columns of W.
    all_columns: usize,
    basis: Basis,
    /// The factors of the free coefficients at every sample.
    factors: Vec<[Vec<f64>; 3]>,
    pub(super) intervals: Intervals,
    pub(super) criterion: ExcitationCriterion,
    /// μ.
    pub(super) weight: f64,
}

/// q, v and a at a sample.
type State = [Vec<f64>; 3];

impl<'a> Information<'a> {
    pub(super) fn new(
        model: &'a Model,
        base: &BaseParameters,
        options: &'a ExcitationOptions,
        intervals: Intervals,
    ) -> Self {
        let basis =
            Basis { period: options.period, harmonics: options.harmonics, from_rest: options.from_rest };
        let mut all = Self {
            model,
            options,
            workspace: Workspace::new(model),
            tangents: Workspace::new(model),
            columns: base.parameters.iter().map(|parameter| parameter.index).collect(),
            all_columns: base.combinations.ncols(),
            basis,
            factors: Vec::new(),
            intervals,
            criterion: ExcitationCriterion::Determinant,
            weight: 1.0,
        };
        all.sample(options.samples);
        all
    }

    /// Sets the number of equidistant states of the period. None is at the start, where a motion from rest
    /// has no direction of friction.
    pub(super) fn sample(&mut self, samples: usize) {
        let step = self.options.period / samples as f64;
        self.factors = (0..samples).map(|k| self.basis.factors((k as f64 + 0.5) * step)).collect();
    }

    pub(super) fn basis(&self) -> Basis {
        self.basis
    }

    /// The state at a sample.
    fn state(&self, factors: &[Vec<f64>; 3], x: &DVector<f64>) -> State {
        let blocks = || x.as_slice().chunks_exact(self.basis.len());
        let sum = |factors: &[f64], own: &[f64]| factors.iter().zip(own).map(|(f, x)| f * x).sum();
        factors.each_ref().map(|factors| blocks().map(|own| sum(factors, own)).collect())
    }

    /// The torques at a state, with damping and friction.
    fn torques(&mut self, [q, v, a]: &State) -> Vec<f64> {
        let (mut tau, mut lost) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        inverse_dynamics(self.model, &mut self.workspace, q, v, a, &mut tau);
        dissipation(self.model, v, &mut lost);
        tau.iter().zip(lost).map(|(tau, lost)| tau + lost).collect()
    }

    fn noise(&self, i: usize) -> f64 {
        self.options.noise.get(i).copied().unwrap_or(1.0)
    }

    /// W of the base parameters at all samples, divided by the noise. Coordinates without a sensor are zero.
    pub(super) fn rows(&mut self, x: &DVector<f64>) -> DMatrix<f64> {
        let nv = self.model.nv();
        let mut rows = DMatrix::zeros(self.factors.len() * nv, self.columns.len());
        let mut all = vec![0.0; nv * self.all_columns];
        for k in 0..self.factors.len() {
            let [q, v, a] = self.state(&self.factors[k], x);
            write_rows(self.model, &mut self.workspace, &self.options.terms, [&q, &v, &a], &mut all);
            for i in 0..nv {
                let own = &all[i * self.all_columns..][..self.all_columns];
                for (c, &column) in self.columns.iter().enumerate() {
                    rows[(k * nv + i, c)] = own[column] / self.noise(i);
                }
            }
        }
        rows
    }

    /// The largest usage of a limit at the samples: 1 at a limit of `intervals`.
    pub(super) fn usage(&mut self, x: &DVector<f64>, intervals: &Intervals) -> f64 {
        let mut most: f64 = 0.0;
        for k in 0..self.factors.len() {
            let state = self.state(&self.factors[k], x);
            for (values, intervals) in state.iter().zip(&intervals.motion) {
                let own = values.iter().zip(intervals).map(|(x, interval)| interval.usage(*x));
                most = own.fold(most, f64::max);
            }
            let tau = self.torques(&state);
            most = tau.iter().zip(&intervals.torque).map(|(x, own)| own.usage(*x)).fold(most, f64::max);
        }
        most
    }

    /// The mean barrier.
    fn barrier(&mut self, x: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        for k in 0..self.factors.len() {
            let state = self.state(&self.factors[k], x);
            for (values, intervals) in state.iter().zip(&self.intervals.motion) {
                sum += values.iter().zip(intervals).map(|(x, own)| own.barrier(*x).0).sum::<f64>();
            }
            if sum.is_infinite() {
                return sum;
            }
            let tau = self.torques(&state);
            sum += tau.iter().zip(&self.intervals.torque).map(|(x, own)| own.barrier(*x).0).sum::<f64>();
        }
        sum / (self.factors.len() * self.model.nv()) as f64
    }

    /// The derivatives of the objective by q, v and a of one coordinate at one state: of the rows through
    /// `by_rows`, the derivative by W there, and of the torques through their barriers.
    fn derivatives(&mut self, state: &State, joint: usize, by_rows: &DMatrix<f64>, weight: f64) -> [f64; 3] {
        let nv = self.model.nv();
        let [q, v, a]: [Vec<Tangent>; 3] = core::array::from_fn(|part| {
            let mut all: Vec<Tangent> = state[part].iter().map(|x| Dual::constant(*x)).collect();
            all[joint] = Dual::variable(state[part][joint], part);
            all
        });
        let mut rows = vec![Tangent::zero(); nv * self.all_columns];
        write_rows(self.model, &mut self.tangents, &self.options.terms, [&q, &v, &a], &mut rows);
        let mut sum = [0.0; 3];
        let mut add = |factor: f64, tangent: &Tangent| {
            sum.iter_mut().zip(tangent.gradient).for_each(|(sum, own)| *sum += factor * own);
        };
        for i in 0..nv {
            let own = &rows[i * self.all_columns..][..self.all_columns];
            for (c, &column) in self.columns.iter().enumerate() {
                add(by_rows[(i, c)] / self.noise(i), &own[column]);
            }
        }
        let mut tau = vec![Tangent::zero(); nv];
        let mut lost = tau.clone();
        inverse_dynamics(self.model, &mut self.tangents, &q, &v, &a, &mut tau);
        dissipation(self.model, &v, &mut lost);
        for (i, (tau, lost)) in tau.iter().zip(&lost).enumerate() {
            let all = *tau + *lost;
            add(weight * self.intervals.torque[i].barrier(all.value).1, &all);
        }
        for (part, sum) in sum.iter_mut().enumerate() {
            *sum += weight * self.intervals.motion[part][joint].barrier(state[part][joint]).1;
        }
        sum
    }
}

impl Objective for Information<'_> {
    fn value(&mut self, x: &DVector<f64>) -> f64 {
        let barrier = self.barrier(x);
        if !barrier.is_finite() {
            return f64::INFINITY;
        }
        let rows = self.rows(x);
        let own = information(&rows, self.criterion).map_or(f64::INFINITY, |(value, _)| value);
        own + self.weight * barrier
    }

    fn gradient(&mut self, x: &DVector<f64>) -> DVector<f64> {
        let (nv, p) = (self.model.nv(), self.basis.len());
        let rows = self.rows(x);
        let by_rows = match information(&rows, self.criterion) {
            Some((_, derivative)) => derivative,
            None => DMatrix::zeros(rows.nrows(), rows.ncols()),
        };
        let weight = self.weight / (self.factors.len() * nv) as f64;
        let mut gradient = DVector::zeros(x.len());
        for k in 0..self.factors.len() {
            let state = self.state(&self.factors[k], x);
            let own = by_rows.rows(k * nv, nv).into_owned();
            for joint in 0..nv {
                let derivatives = self.derivatives(&state, joint, &own, weight);
                for (factors, derivative) in self.factors[k].iter().zip(derivatives) {
                    for (entry, factor) in gradient.as_mut_slice()[joint * p..].iter_mut().zip(factors) {
                        *entry += factor * derivative;
                    }
                }
            }
        }
        gradient
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};

    use super::*;
    use crate::identification::{JointTerm, JointTermKind};

    /// The gradient of both criteria and of all barriers, against central differences.
    ///
    /// The condition of WᵀW is up to 1e7, so values have errors of 1e-10, which the step of 1e-4 divides. The
    /// differences themselves are exact to the step's square.
    #[test]
    fn gradient_matches_differences() {
        let options = RandomRobotOptions {
            joints: 4,
            massless: 0.0,
            kinds: JointKinds::SingleDof,
            ..RandomRobotOptions::default()
        };
        let model = Model::new(random_robot(2, &options)).expect("a robot");
        let terms = JointTerm::of_all(&model, &[JointTermKind::Damping, JointTermKind::Armature]);
        let base = BaseParameters::of_with_terms(&model, &terms, 100, 1).expect("terms");
        let nv = model.nv();
        let limits = ExcitationLimits {
            position: vec![[-3.0, 4.0]; nv],
            velocity: vec![8.0; nv],
            acceleration: vec![f64::INFINITY; nv],
            torque: vec![1e4; nv],
        };
        for (from_rest, criterion) in
            [(true, ExcitationCriterion::Determinant), (false, ExcitationCriterion::Condition)]
        {
            let options = ExcitationOptions::new(3.0, 4).with_rest(from_rest).with_terms(&terms);
            let mut objective = Information::new(&model, &base, &options, Intervals::new(&limits, 0.1));
            (objective.criterion, objective.weight) = (criterion, 0.7);
            let random = &mut robot_dynamics_number::SplitMix64::new(5);
            let x = DVector::from_fn(nv * objective.basis().len(), |_, _| random.uniform(-0.5, 0.5));
            assert!(objective.value(&x).is_finite());
            let gradient = objective.gradient(&x);
            for i in 0..x.len() {
                let mut side = |step: f64| {
                    let mut moved = x.clone();
                    moved[i] += step;
                    objective.value(&moved)
                };
                let expected = (side(1e-4) - side(-1e-4)) / 2e-4;
                assert!(
                    (gradient[i] - expected).abs() < 1e-5 * (1.0 + gradient.amax()),
                    "{i}: {} {expected}",
                    gradient[i]
                );
            }
        }
    }
}

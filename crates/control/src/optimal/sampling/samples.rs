//! The samples of an iteration: their controls, and their costs by rollouts in several threads.

use robot_dynamics_number::SplitMix64;

use crate::optimal::error::OptimalControlError;
use crate::optimal::problem::Problem;

/// A copy of the problem with the states of a rollout.
#[derive(Clone)]
pub(super) struct Worker {
    pub(super) problem: Problem,
    state: Vec<f64>,
    next: Vec<f64>,
}

/// The distribution of an iteration.
pub(super) struct Distribution<'a> {
    /// The mean of the controls of all nodes, and their deviations.
    pub(super) mean: &'a [f64],
    pub(super) deviation: &'a [f64],
    pub(super) correlation: f64,
    /// The random numbers of sample i follow from this and i.
    pub(super) seed: u64,
}

impl Worker {
    pub(super) fn new(problem: Problem) -> Self {
        let state = problem.initial_state().to_vec();
        Self { problem, next: state.clone(), state }
    }

    /// The cost of controls from x₀; infinite if a step or a cost fails.
    pub(super) fn cost(&mut self, controls: &[f64]) -> f64 {
        self.roll_out(controls).unwrap_or(f64::INFINITY)
    }

    /// The first failure along controls, if one fails.
    pub(super) fn first_failure(&mut self, controls: &[f64]) -> Option<OptimalControlError> {
        self.roll_out(controls).err()
    }

    fn roll_out(&mut self, controls: &[f64]) -> Result<f64, OptimalControlError> {
        let Self { problem, state, next } = self;
        state.copy_from_slice(problem.initial_state());
        let (mut sum, mut rest) = (0.0, controls);
        for node in 0..problem.nodes() {
            let (u, after) = rest.split_at(problem.controls(node));
            rest = after;
            problem.step(node, state, u, next)?;
            sum += problem.cost(node, state, u)?;
            std::mem::swap(state, next);
        }
        Ok(sum + problem.cost(problem.nodes(), state, &[])?)
    }

    /// Writes the controls of a sample, within the bounds. Sample 0 is the mean.
    fn draw(&self, from: &Distribution<'_>, index: usize, controls: &mut [f64]) {
        controls.fill(0.0);
        if index > 0 {
            self.draw_noise(from, index, controls);
        }
        for ((u, mean), deviation) in controls.iter_mut().zip(from.mean).zip(from.deviation) {
            *u = mean + deviation * *u;
        }
        let mut rest = controls;
        for node in 0..self.problem.nodes() {
            let (own, after) = rest.split_at_mut(self.problem.controls(node));
            self.problem.control_bounds(node).clamp(own);
            rest = after;
        }
    }

    /// Noise of variance 1. That of a node is correlated with that of the node before, if it has as many
    /// controls.
    fn draw_noise(&self, from: &Distribution<'_>, index: usize, noise: &mut [f64]) {
        let mut normal = Normal::new(from.seed, index);
        let fresh = (1.0 - from.correlation * from.correlation).sqrt();
        let (mut first, mut before) = (0, 0);
        for node in 0..self.problem.nodes() {
            let m = self.problem.controls(node);
            for i in first..first + m {
                let drawn = normal.next();
                noise[i] = if before == m { from.correlation * noise[i - m] + fresh * drawn } else { drawn };
            }
            (first, before) = (first + m, m);
        }
    }
}

/// Standard normal numbers by the method of Box and Muller.
struct Normal {
    random: SplitMix64,
    /// The second number of a pair.
    kept: Option<f64>,
}

impl Normal {
    /// Numbers that follow from a seed and an index: the index moves the seed by a hash, so that the
    /// sequences of two samples do not overlap.
    fn new(seed: u64, index: usize) -> Self {
        let hash = SplitMix64::new(index as u64).next_u64();
        Self { random: SplitMix64::new(seed ^ hash), kept: None }
    }

    fn next(&mut self) -> f64 {
        if let Some(kept) = self.kept.take() {
            return kept;
        }
        // 1 − u is above 0.
        let radius = (-2.0 * (1.0 - self.random.uniform(0.0, 1.0)).ln()).sqrt();
        let (sin, cos) = self.random.uniform(0.0, std::f64::consts::TAU).sin_cos();
        self.kept = Some(radius * sin);
        radius * cos
    }
}

/// Draws all samples and computes their costs; each worker takes a range of them.
pub(super) fn evaluate(
    workers: &mut [Worker],
    from: &Distribution<'_>,
    controls: &mut [f64],
    costs: &mut [f64],
) {
    let (share, length) = (costs.len().div_ceil(workers.len()), from.mean.len());
    let run = |worker: &mut Worker, first: usize, controls: &mut [f64], costs: &mut [f64]| {
        for (k, (controls, cost)) in controls.chunks_exact_mut(length).zip(costs).enumerate() {
            worker.draw(from, first + k, controls);
            *cost = worker.cost(controls);
        }
    };
    if let [worker] = workers {
        return run(worker, 0, controls, costs);
    }
    let ranges = controls.chunks_mut(share * length).zip(costs.chunks_mut(share));
    std::thread::scope(|scope| {
        for (index, (worker, (controls, costs))) in workers.iter_mut().zip(ranges).enumerate() {
            let run = &run;
            scope.spawn(move || run(worker, index * share, controls, costs));
        }
    });
}

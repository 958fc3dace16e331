//! An algorithm on all states of one robot as a batch.

use std::hint::black_box;

use dynamics::Scalar;
use multibody::Model;
use multibody::batch::{
    BatchFloat, BatchOptions, BatchWorkspace, forward_dynamics, inverse_dynamics, mass_matrix,
};

use crate::{Algorithm, StateTable};

/// A batch to be measured: `NAME_batch_f64`, `NAME_batch_f32`, or with `_threads_N` at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchName {
    /// Inverse dynamics, forward dynamics or the mass matrix.
    pub algorithm: Algorithm,
    /// f32 instead of f64.
    pub single: bool,
    /// How many threads, where the name says so; one otherwise.
    pub threads: Option<usize>,
}

impl BatchName {
    /// The batch of that name.
    pub fn parse(name: &str) -> Option<Self> {
        let (algorithm, rest) = name.split_once("_batch_")?;
        let algorithm = Algorithm::named(algorithm)?;
        let is_recursion = matches!(
            algorithm,
            Algorithm::InverseDynamics | Algorithm::ForwardDynamics | Algorithm::MassMatrix
        );
        let (number, threads) = match rest.split_once("_threads_") {
            Some((number, threads)) => (number, Some(threads.parse().ok().filter(|&n| n > 0)?)),
            None => (rest, None),
        };
        let single = match number {
            "f64" => false,
            "f32" => true,
            _ => return None,
        };
        is_recursion.then_some(Self { algorithm, single, threads })
    }

    /// How often the states stand in the batch: several threads need more work than one.
    pub fn repetitions(self) -> usize {
        if self.threads.is_some() { 8 } else { 1 }
    }
}

/// A batch's tables.
#[derive(Debug)]
pub struct BatchTask<'a, T: BatchFloat> {
    model: &'a Model,
    workspace: BatchWorkspace<T>,
    q: Vec<T>,
    v: Vec<T>,
    a: Vec<T>,
    tau: Vec<T>,
    result: Vec<T>,
}

impl<'a, T: BatchFloat + Into<f64>> BatchTask<'a, T> {
    /// All states of a table, `repetitions` times.
    ///
    /// # Panics
    /// If the threads cannot be started.
    pub fn new(model: &'a Model, states: &StateTable, repetitions: usize, options: BatchOptions) -> Self {
        let workspace = BatchWorkspace::with_options(model, options).expect("threads");
        let [q, v, a, tau] = [0, 1, 2, 3].map(|k| {
            let one = (0..states.count()).flat_map(|i| states.get(i)[k]);
            one.map(|&x| <T as Scalar>::from_f64(x)).collect::<Vec<T>>().repeat(repetitions)
        });
        Self { model, workspace, q, v, a, tau, result: Vec::new() }
    }

    /// Computes all states.
    ///
    /// # Panics
    /// If a state has no result, or there are no batches of the algorithm.
    pub fn call(&mut self, algorithm: Algorithm) {
        let Self { model, workspace: w, q, v, a, tau, result } = self;
        let batch = q.len() / model.nq();
        let width = if algorithm == Algorithm::MassMatrix { model.nv() * model.nv() } else { model.nv() };
        result.resize(batch * width, T::zero());
        let computed = match algorithm {
            Algorithm::InverseDynamics => inverse_dynamics(model, w, q, v, a, result),
            Algorithm::ForwardDynamics => forward_dynamics(model, w, q, v, tau, result),
            Algorithm::MassMatrix => mass_matrix(model, w, q, result),
            other => panic!("no batches of {}", other.name()),
        };
        black_box(&*result);
        computed.expect("every state has a result");
    }

    /// States of the batch.
    pub fn count(&self) -> usize {
        self.q.len() / self.model.nq()
    }

    /// The numbers of the last call, one state after the other.
    pub fn result(&self) -> impl Iterator<Item = f64> {
        self.result.iter().map(|&x| x.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Task, robot_by_name};

    #[test]
    fn names_are_read() {
        let name = |text| BatchName::parse(text).map(|x| (x.algorithm, x.single, x.threads, x.repetitions()));
        let inverse = Algorithm::InverseDynamics;
        assert_eq!(name("inverse_dynamics_batch_f64"), Some((inverse, false, None, 1)));
        assert_eq!(name("mass_matrix_batch_f32"), Some((Algorithm::MassMatrix, true, None, 1)));
        assert_eq!(name("inverse_dynamics_batch_f64_threads_2"), Some((inverse, false, Some(2), 8)));
        for wrong in [
            "inverse_dynamics",
            "coriolis_matrix_batch_f64",
            "mass_matrix_batch_f16",
            "x_batch_f64_threads_0",
        ] {
            assert_eq!(name(wrong), None, "{wrong}");
        }
    }

    /// The batch holds its states in their order: each result is the single state's to some thousand roundings.
    #[test]
    fn a_batch_has_the_single_states() {
        let model = robot_by_name("ur5").expect("ur5");
        let states = StateTable::random(&model, 11, 3);
        let mut batch = BatchTask::<f64>::new(&model, &states, 2, BatchOptions::default());
        let mut single = Task::new(&model, &states);
        assert_eq!(batch.count(), 22);
        batch.call(Algorithm::InverseDynamics);
        let found: Vec<f64> = batch.result().collect();
        for i in 0..22 {
            single.call(Algorithm::InverseDynamics, i % 11);
            for (found, expected) in found[i * 6..].iter().zip(single.result(Algorithm::InverseDynamics)) {
                assert!((found - expected).abs() < 1e-11, "state {i}: {found} and {expected}");
            }
        }
    }
}

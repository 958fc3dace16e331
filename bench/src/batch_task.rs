//! An algorithm on all states of one robot as a batch.

use std::hint::black_box;

use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchQuantity, BatchWorkspace};
use robot_dynamics::model::Model;
use robot_dynamics::quantity::{Inputs, Quantity};
use robot_dynamics_number::Scalar;

use crate::{StateTable, named};

/// The name of a batch: `NAME_batch_f64`, `NAME_batch_f32`, optionally with the suffix `_threads_N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchName {
    /// The algorithm.
    pub algorithm: Quantity,
    /// f32 instead of f64.
    pub single: bool,
    /// Number of threads, one by default.
    pub threads: Option<usize>,
}

impl BatchName {
    /// Parses a name.
    pub fn parse(name: &str) -> Option<Self> {
        let (algorithm, rest) = name.split_once("_batch_")?;
        let algorithm = named(algorithm)?;
        let (number, threads) = match rest.split_once("_threads_") {
            Some((number, threads)) => (number, Some(threads.parse().ok().filter(|&n| n > 0)?)),
            None => (rest, None),
        };
        let single = match number {
            "f64" => false,
            "f32" => true,
            _ => return None,
        };
        algorithm.has_batch().then_some(Self { algorithm, single, threads })
    }

    /// Number of copies of the states in the batch, since several threads need more work than one.
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
    /// The tables of results, and the number of compared values per state in each.
    results: [Vec<T>; 3],
    widths: [usize; 2],
}

impl<'a, T: BatchFloat + Into<f64>> BatchTask<'a, T> {
    /// A table with `repetitions` copies of all states.
    ///
    /// # Panics
    /// Panics if the threads cannot be started.
    pub fn new(model: &'a Model, states: &StateTable, repetitions: usize, options: BatchOptions) -> Self {
        let workspace = BatchWorkspace::with_options(model, options).expect("threads");
        let [q, v, a, tau] = [0, 1, 2, 3].map(|k| {
            let one = (0..states.count()).flat_map(|i| states.get(i)[k]);
            one.map(|&x| <T as Scalar>::from_f64(x)).collect::<Vec<T>>().repeat(repetitions)
        });
        Self { model, workspace, q, v, a, tau, results: [const { Vec::new() }; 3], widths: [0; 2] }
    }

    /// Computes all states.
    ///
    /// # Panics
    /// Panics if a state has no result, or the algorithm has no batch function.
    pub fn call(&mut self, algorithm: Quantity) {
        let Self { model, workspace: w, q, v, a, tau, results: [x, y, z], widths } = self;
        let batch = q.len() / model.nq();
        let mut lengths = [0; 3];
        for (length, result) in lengths.iter_mut().zip(algorithm.results()) {
            *length = result.shape.len(model, 0);
        }
        // The third result, M⁻¹, is not compared.
        *widths = [lengths[0], lengths[1]];
        for (table, width) in [&mut *x, &mut *y, &mut *z].into_iter().zip(lengths) {
            table.resize(batch * width, T::zero());
        }
        let inputs = Inputs { q, v, a, tau, frames: &[] };
        let computed = algorithm.compute_batch(model, w, &inputs, [&mut *x, &mut *y, &mut *z]);
        black_box((&*x, &*y, &*z));
        computed.expect("batches of the algorithm").expect("every state has a result");
    }

    /// Number of states in the batch.
    pub fn count(&self) -> usize {
        self.q.len() / self.model.nq()
    }

    /// The results of the last call, one state after the other.
    pub fn result(&self) -> impl Iterator<Item = f64> {
        let ([x, y, _], [width_x, width_y]) = (&self.results, self.widths);
        (0..self.count()).flat_map(move |i| {
            let (x, y) = (&x[i * width_x..][..width_x], &y[i * width_y..][..width_y]);
            x.iter().chain(y).map(|&x| x.into())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Task, robot_by_name};

    #[test]
    fn names_are_read() {
        let name = |text| BatchName::parse(text).map(|x| (x.algorithm, x.single, x.threads, x.repetitions()));
        let inverse = Quantity::InverseDynamics;
        assert_eq!(name("inverse_dynamics_batch_f64"), Some((inverse, false, None, 1)));
        assert_eq!(name("mass_matrix_batch_f32"), Some((Quantity::MassMatrix, true, None, 1)));
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

    /// The batch has the states in order, and each result agrees with the single state's to some thousand
    /// roundings.
    #[test]
    fn a_batch_has_the_single_states() {
        let model = robot_by_name("ur5").expect("ur5");
        let states = StateTable::random(&model, 11, 3);
        let mut batch = BatchTask::<f64>::new(&model, &states, 2, BatchOptions::default());
        let mut single = Task::new(&model, &states);
        assert_eq!(batch.count(), 22);
        for algorithm in [Quantity::InverseDynamics, Quantity::InverseDynamicsDerivatives] {
            batch.call(algorithm);
            let found: Vec<f64> = batch.result().collect();
            let width = found.len() / 22;
            for i in 0..22 {
                single.call(algorithm, i % 11);
                let expected = single.result(algorithm);
                assert_eq!(expected.len(), width);
                for (found, expected) in found[i * width..].iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-11, "state {i}: {found} and {expected}");
                }
            }
        }
    }
}

//! A kernel against its graph.

use expression::{Graph, Operand, Plan, as_traced, interpret};
use number::SplitMix64;

use crate::error::CompileError;
use crate::kernel::{Float, Kernel};

/// States that are compared.
const STATES: usize = 2;

/// Computes random states by a kernel and by its graph, operation by operation.
///
/// # Errors
/// [`CompileError::Differs`].
pub(crate) fn check<T: Float>(
    kernel: &Kernel<T>,
    graph: &Graph,
    results: &[Vec<Operand>],
    lengths: &[usize],
) -> Result<(), CompileError> {
    let mut random = SplitMix64::new(2026);
    let mut states = || -> Vec<Vec<T>> {
        let table =
            |&length: &usize| (0..STATES * length).map(|_| T::nearest(random.uniform(-1.0, 1.0))).collect();
        lengths.iter().map(table).collect()
    };
    let inputs = states();
    let mut outputs: Vec<Vec<T>> =
        results.iter().map(|result| vec![T::nearest(0.0); STATES * result.len()]).collect();
    {
        let inputs: Vec<&[T]> = inputs.iter().map(|input| &input[..]).collect();
        let mut outputs: Vec<&mut [T]> = outputs.iter_mut().map(|output| &mut output[..]).collect();
        let mut scratch = vec![T::nearest(0.0); kernel.scratch_len()];
        kernel.call_rows(STATES, &inputs, &mut outputs, &mut scratch, |_| {});
    }
    let plan = Plan { order: as_traced(graph, results), live: 0 };
    for state in 0..STATES {
        let row = |(input, &length): (&Vec<T>, &usize)| -> Vec<f64> {
            input[state * length..][..length].iter().map(|&x| x.into()).collect()
        };
        let arguments: Vec<Vec<f64>> = inputs.iter().zip(lengths).map(row).collect();
        let (expected, _) = interpret(graph, &plan, results, kernel.target().arithmetic, &arguments);
        for (result, expected) in expected.iter().enumerate() {
            let found = &outputs[result][state * expected.len()..][..expected.len()];
            for (index, (&found, &expected)) in found.iter().zip(expected).enumerate() {
                let found: f64 = found.into();
                if !is_same(found, expected) {
                    return Err(CompileError::Differs { result, index, found, expected });
                }
            }
        }
    }
    Ok(())
}

/// Whether the bits are the same, or both are NaN.
pub(crate) fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

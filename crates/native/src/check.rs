//! Comparison of a kernel with its graph.

use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, as_traced, interpret};
use robot_dynamics_number::SplitMix64;

use crate::error::CompileError;
use crate::float::Float;

/// The number of states to compare.
const STATES: usize = 2;

/// Compares a kernel with its graph, evaluated operation by operation, in random states. `run` computes the
/// results of this number of states from the arguments by the kernel.
///
/// # Errors
/// [`CompileError::Differs`].
pub(crate) fn check<T: Float>(
    graph: &Graph,
    results: &[Vec<Operand>],
    lengths: &[usize],
    arithmetic: Arithmetic,
    run: impl FnOnce(usize, &[&[T]], &mut [&mut [T]]),
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
        run(STATES, &inputs, &mut outputs);
    }
    let plan = Plan { order: as_traced(graph, results), live: 0 };
    for state in 0..STATES {
        let row = |(input, &length): (&Vec<T>, &usize)| -> Vec<f64> {
            input[state * length..][..length].iter().map(|&x| x.into()).collect()
        };
        let arguments: Vec<Vec<f64>> = inputs.iter().zip(lengths).map(row).collect();
        let (expected, _) = interpret(graph, &plan, results, arithmetic, &arguments);
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
fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

#[cfg(test)]
mod tests {
    use robot_dynamics_expression::trace;

    use super::*;
    use crate::Kernel;
    use crate::code::Code;
    use crate::target::{Target, Width, best_instructions};

    /// A constant is changed in the compiled code.
    #[test]
    fn code_with_a_changed_constant_is_rejected() {
        let arithmetic = Arithmetic::default();
        let (graph, results) = trace(arithmetic, &[1], |x| {
            vec![vec![x[0][0] * robot_dynamics_expression::Traced(Operand::constant(3.0))]]
        });
        for width in [Width::One, Width::Lanes] {
            let target = Target { instructions: best_instructions(), width, arithmetic };
            let Ok(mut code) = Code::new(&graph, &results, &[1], target) else {
                return println!("left out: there is no encoder for this processor");
            };
            let check_code = |code: &Code| {
                let kernel = Kernel::<f64>::load(code).unwrap();
                let mut scratch = vec![0.0; kernel.scratch_len()];
                check(&graph, &results, &[1], arithmetic, |states, inputs, outputs| {
                    kernel.call_rows(states, inputs, outputs, &mut scratch, |_| {});
                })
            };
            assert!(check_code(&code).is_ok());
            // A register of constants has a copy for each lane.
            let copies = code.bytes.chunks_exact_mut(8).filter(|bytes| **bytes == 3.0_f64.to_le_bytes());
            let changed = copies.map(|copy| copy.copy_from_slice(&3.0_f64.next_up().to_le_bytes())).count();
            assert!(changed > 0);
            let refused = check_code(&code);
            assert!(matches!(refused, Err(CompileError::Differs { result: 0, index: 0, .. })), "{refused:?}");
        }
    }
}

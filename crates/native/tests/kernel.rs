//! The public behaviour of kernels: lengths, ranges, errors and threads.

use robot_dynamics_expression::{Arithmetic, Graph, Operand, Precision, Sine, Traced, trace};
use robot_dynamics_native::{AngleOutOfRange, Code, CompileError, Kernel, Target, Width, best_instructions};
use robot_dynamics_number::{InstructionSet, Scalar};

/// A kernel, if this processor has an encoder.
fn compiled(
    lengths: &[usize],
    width: Width,
    compute: impl FnOnce(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> Option<Kernel<f64>> {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, lengths, compute);
    match Kernel::compile(&graph, &results, lengths, arithmetic, best_instructions(), width) {
        Ok(kernel) => Some(kernel),
        Err(CompileError::NoEncoder { .. }) => {
            println!("left out: there is no encoder for this processor");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// sin x and cos y.
fn sines(x: &[Vec<Traced>]) -> Vec<Vec<Traced>> {
    vec![vec![x[0][0].sin_cos().0, x[0][1].sin_cos().1]]
}

/// Kernels can be shared between threads.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Kernel<f64>>();
    is_shared::<Kernel<f32>>();
};

#[test]
fn angles_out_of_range_are_reported() {
    let Some(kernel) = compiled(&[2], Width::One, sines) else { return };
    let mut scratch = vec![f64::NAN; kernel.scratch_len()];
    let mut call = |x: f64, y: f64| kernel.call(&[&[x, y]], &mut [&mut [0.0; 2]], &mut scratch);
    for far in [1e5, -1e5, 1e300, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(call(far, 0.0), Err(AngleOutOfRange), "{far}");
        assert_eq!(call(0.0, far), Err(AngleOutOfRange), "{far}");
        // NaN hides no other angle.
        assert_eq!(call(f64::NAN, far), Err(AngleOutOfRange), "{far}");
        assert_eq!(call(far, f64::NAN), Err(AngleOutOfRange), "{far}");
    }
    for near in [1e5_f64.next_down(), -99_999.0, 0.0, f64::NAN] {
        assert_eq!(call(near, near), Ok(()), "{near}");
    }
}

#[test]
fn each_row_with_an_angle_out_of_range_is_reported() {
    for width in [Width::One, Width::Lanes] {
        let Some(kernel) = compiled(&[2], width, sines) else { return };
        let mut scratch = vec![0.0; kernel.scratch_len()];
        for rows in [1, 3, 7, 8, 20, 41] {
            let mut angles: Vec<f64> = (0..2 * rows).map(|k| k as f64).collect();
            let far = [0, rows / 2, rows - 1];
            for row in far {
                angles[2 * row + row % 2] = 2e5;
            }
            let (mut found, mut results) = (Vec::new(), vec![0.0; 2 * rows]);
            kernel.call_rows(rows, &[&angles], &mut [&mut results], &mut scratch, |row| found.push(row));
            let mut expected = far.to_vec();
            expected.dedup();
            assert_eq!(found, expected, "{width:?}, {rows} rows");
            for row in (0..rows).filter(|row| !far.contains(row)) {
                assert!((results[2 * row] - angles[2 * row].sin()).abs() < 1e-15);
                assert!((results[2 * row + 1] - angles[2 * row + 1].cos()).abs() < 1e-15);
            }
        }
    }
}

/// More tables than registers for pointers, and tables without numbers.
#[test]
fn sixteen_tables_are_read_and_written() {
    let lengths: Vec<usize> = (0..9).collect();
    for width in [Width::One, Width::Lanes] {
        let kernel = compiled(&lengths, width, |x| {
            let sum = |k: usize| {
                x.iter().flatten().fold(Traced::zero(), |sum, &y| sum + y * Traced::from_f64(k as f64))
            };
            (0..7).map(|k| vec![sum(k); k]).collect()
        });
        let Some(kernel) = kernel else { return };
        let rows = 21;
        let inputs: Vec<Vec<f64>> =
            lengths.iter().map(|length| (0..rows * length).map(|k| (k / length) as f64).collect()).collect();
        let inputs: Vec<&[f64]> = inputs.iter().map(|input| &input[..]).collect();
        let mut outputs: Vec<Vec<f64>> = (0..7).map(|k| vec![-1.0; rows * k]).collect();
        let mut scratch = vec![0.0; kernel.scratch_len()];
        let mut slices: Vec<&mut [f64]> = outputs.iter_mut().map(|output| &mut output[..]).collect();
        kernel.call_rows(rows, &inputs, &mut slices, &mut scratch, |_| unreachable!("there are no sines"));
        for (k, output) in outputs.iter().enumerate() {
            // The arguments have 36 numbers, each equal to the number of its row.
            assert!(
                output.iter().enumerate().all(|(at, &x)| x == (36 * k * (at / k)) as f64),
                "{width:?}, {k}"
            );
        }
    }
}

/// Sixty thousand operations with a thousand live values: offsets of four bytes, and code of more than one
/// megabyte. Each kernel is compared with its graph when it is compiled.
#[test]
fn large_graphs_are_compiled() {
    for width in [Width::One, Width::Lanes] {
        let kernel = compiled(&[1000, 1000], width, |x| {
            let mut values = x[0].clone();
            for round in 0..60 {
                for k in 0..1000 {
                    let other = values[(k * 7 + round) % 1000];
                    values[k] = values[k] * x[1][(k + round) % 1000]
                        - other * Traced::from_f64(0.5 + 0.4 / (1 + k) as f64);
                }
            }
            vec![values]
        });
        let Some(kernel) = kernel else { return };
        assert!(kernel.statistics().code_bytes > 1 << 20 && kernel.statistics().spills > 1000);
    }
}

#[test]
fn wrong_lengths_panic_before_anything_is_written() {
    let Some(kernel) = compiled(&[2], Width::One, sines) else { return };
    let needed = kernel.scratch_len();
    let refused = |input: usize, output: usize, scratch: usize| {
        let (input, mut output, mut scratch) = (vec![0.0; input], vec![7.0; output], vec![0.0; scratch]);
        let call = || kernel.call(&[&input], &mut [&mut output], &mut scratch);
        let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(call)).expect_err("a panic");
        assert!(output.iter().all(|&x| x == 7.0));
        assert!(panic.is::<String>(), "a message with both lengths");
    };
    refused(1, 2, needed);
    refused(3, 2, needed);
    refused(2, 1, needed);
    refused(2, 2, needed - 1);
}

#[test]
fn invalid_graphs_are_rejected() {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] + x[0][1]]]);
    let target = Target { instructions: InstructionSet::Avx2, width: Width::One, arithmetic };
    let refused = |graph: &Graph, results: &[Vec<Operand>], lengths: &[usize], target| {
        Code::new(graph, results, lengths, target).expect_err("refused")
    };
    let portable = Target { instructions: InstructionSet::Portable, ..target };
    assert!(matches!(refused(&graph, &results, &[2], portable), CompileError::NoEncoder { .. }));
    let platform = Target { arithmetic: arithmetic.with_sine(Sine::Platform), ..target };
    assert!(matches!(refused(&graph, &results, &[2], platform), CompileError::PlatformSine));
    let single = Target { arithmetic: Arithmetic::new(Precision::Single), ..target };
    assert!(matches!(refused(&graph, &results, &[2], single), CompileError::Precision { .. }));
    assert!(matches!(
        refused(&graph, &results, &[1], target),
        CompileError::Argument { argument: 0, index: 1, length: 1 }
    ));
    assert!(matches!(refused(&graph, &results, &[], target), CompileError::Argument { length: 0, .. }));
    let many = vec![results[0].clone(); 16];
    assert!(matches!(
        refused(&graph, &many, &[2], target),
        CompileError::TooManyTables { count: 17, most: 16 }
    ));
    assert!(matches!(refused(&graph, &results, &[usize::MAX], target), CompileError::TooLarge { .. }));
    let code = Code::new(&graph, &results, &[2], target).unwrap();
    assert!(matches!(Kernel::<f32>::load(&code), Err(CompileError::Precision { .. })));
    let elsewhere = [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon];
    for instructions in elsewhere.into_iter().filter(|set| !set.is_available()) {
        let code = Code::new(&graph, &results, &[2], Target { instructions, ..target }).unwrap();
        assert!(matches!(Kernel::<f64>::load(&code), Err(CompileError::NotOnThisProcessor { .. })));
    }
}

/// Threads call one kernel while they compile others.
#[test]
fn threads_call_a_kernel_while_others_are_compiled() {
    let square = |x: &[Vec<Traced>]| vec![vec![x[0][0] * x[0][0]]];
    let Some(kernel) = compiled(&[1], Width::One, square) else { return };
    std::thread::scope(|scope| {
        for thread in 0..32 {
            let kernel = &kernel;
            scope.spawn(move || {
                let mut scratch = vec![0.0; kernel.scratch_len()];
                for k in 0..200 {
                    let (x, mut y) = (f64::from(thread * 1000 + k), [0.0]);
                    kernel.call(&[&[x]], &mut [&mut y], &mut scratch).unwrap();
                    assert_eq!(y[0], x * x);
                    if k % 20 == 0 {
                        let plus = move |v: &[Vec<Traced>]| vec![vec![v[0][0] + Traced::from_f64(x)]];
                        let other = compiled(&[1], Width::One, plus).expect("there is an encoder");
                        let mut scratch = vec![0.0; other.scratch_len()];
                        other.call(&[&[1.5]], &mut [&mut y], &mut scratch).unwrap();
                        assert_eq!(y[0], 1.5 + x);
                    }
                }
            });
        }
    });
}

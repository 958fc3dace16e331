//! Comparison of machine code made in memory with generated C, by bits.

use std::fmt::Write;

use robot_dynamics::model::{InstructionSet, Model, RandomState, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_generate::{Arithmetic, Function, Precision};
use robot_dynamics_native::{Code, CompileError, Float, Kernel, Target, Width};

/// The number of states of each function.
const STATES: usize = 3;

/// The numbers of each argument.
type Arguments = Vec<Vec<f64>>;

/// A C program that calls each function in some states, the same in each run, and prints the bits of all
/// results.
pub(crate) fn caller(model: &Model, functions: &[Function], arithmetic: Arithmetic) -> String {
    let (number, bits, suffix) = match arithmetic.precision {
        Precision::Double => ("double", "uint64_t", ""),
        Precision::Single => ("float", "uint32_t", "f"),
    };
    let mut text = format!(
        "#include <inttypes.h>\n#include <stdio.h>\n#include <string.h>\n#include \"robot.h\"\n\n\
         static void show(const {number} *x, int count) {{\n    for (int i = 0; i < count; i++) {{\n        {bits} n;\n        \
         memcpy(&n, x + i, sizeof n);\n        printf(\"%\" PRIx64 \"\\n\", (uint64_t)n);\n    }}\n}}\n\nint main(void) {{\n"
    );
    for function in functions {
        let results = function.results(model);
        for arguments in states(model, function, arithmetic) {
            text += "    {\n";
            for (k, argument) in arguments.iter().enumerate() {
                let numbers: Vec<String> = argument.iter().map(|x| format!("{x:e}{suffix}")).collect();
                let (count, numbers) = (argument.len(), numbers.join(", "));
                let _ = writeln!(text, "        static const {number} x{k}[{count}] = {{{numbers}}};");
            }
            for (k, result) in results.iter().enumerate() {
                let _ = writeln!(text, "        static {number} y{k}[{}];", result.rows * result.columns);
            }
            let names = (0..arguments.len()).map(|k| format!("x{k}"));
            let names: Vec<String> = names.chain((0..results.len()).map(|k| format!("y{k}"))).collect();
            let _ = writeln!(text, "        robot_{}({});", function.symbol(), names.join(", "));
            for (k, result) in results.iter().enumerate() {
                let _ = writeln!(text, "        show(y{k}, {});", result.rows * result.columns);
            }
            text += "    }\n";
        }
    }
    text + "    return 0;\n}\n"
}

/// Compares machine code, on every set of instructions of this machine, for one state and for several at
/// once, with the output of the program.
pub(crate) fn check(
    name: &str,
    model: &Model,
    functions: &[Function],
    arithmetic: Arithmetic,
    printed: &str,
) {
    let bits: Vec<u64> = printed.lines().map(|line| u64::from_str_radix(line, 16).unwrap()).collect();
    match arithmetic.precision {
        Precision::Double => check_numbers::<f64>(name, model, functions, arithmetic, &bits, f64::from_bits),
        Precision::Single => {
            let number = |bits| f64::from(f32::from_bits(u32::try_from(bits).unwrap()));
            check_numbers::<f32>(name, model, functions, arithmetic, &bits, number);
        }
    }
}

fn check_numbers<T: Float>(
    name: &str,
    model: &Model,
    functions: &[Function],
    arithmetic: Arithmetic,
    mut printed: &[u64],
    number: impl Fn(u64) -> f64,
) {
    for function in functions {
        let traced = function.trace(model, arithmetic).unwrap();
        let states = states(model, function, arithmetic);
        let count: usize = traced.results.iter().map(Vec::len).sum();
        let (here, others) = printed.split_at(STATES * count);
        printed = others;
        let expected: Vec<f64> = here.iter().map(|&bits| number(bits)).collect();
        let lengths: Vec<usize> = states[0].iter().map(Vec::len).collect();
        for &instructions in InstructionSet::ALL {
            for width in [Width::One, Width::Lanes] {
                let what = format!("{name}, {function}, {instructions:?}, {width:?}");
                let target = Target { instructions, width, arithmetic };
                let loaded = Code::new(&traced.graph, &traced.results, &lengths, target)
                    .and_then(|code| Kernel::<T>::load(&code));
                let kernel = match loaded {
                    Ok(kernel) => kernel,
                    Err(CompileError::NoEncoder { .. } | CompileError::NotOnThisProcessor { .. }) => continue,
                    Err(error) => panic!("{what}: {error}"),
                };
                let found =
                    results(&kernel, &states, &traced.results.iter().map(Vec::len).collect::<Vec<_>>());
                assert_eq!(found.len(), expected.len(), "{what}");
                for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let (state, at) = (at / count, at % count);
                    assert_eq!(found.to_bits(), expected.to_bits(), "{what}: number {at} of state {state}");
                }
            }
        }
    }
    assert!(printed.is_empty(), "{name}: the program prints {} numbers more", printed.len());
}

/// The results of a kernel, by state.
fn results<T: Float>(kernel: &Kernel<T>, states: &[Arguments], lengths: &[usize]) -> Vec<f64> {
    let table = |argument: usize| -> Vec<T> {
        states.iter().flat_map(|state| &state[argument]).map(|&x| T::nearest(x)).collect()
    };
    let inputs: Vec<Vec<T>> = (0..states[0].len()).map(table).collect();
    let inputs: Vec<&[T]> = inputs.iter().map(|input| &input[..]).collect();
    let mut found: Vec<Vec<T>> =
        lengths.iter().map(|length| vec![T::nearest(0.0); STATES * length]).collect();
    let mut outputs: Vec<&mut [T]> = found.iter_mut().map(|output| &mut output[..]).collect();
    let mut scratch = vec![T::nearest(0.0); kernel.scratch_len()];
    kernel
        .call_rows(STATES, &inputs, &mut outputs, &mut scratch, |row| panic!("an angle of row {row} is far"));
    let of_state = |state: usize| {
        found.iter().zip(lengths).flat_map(move |(found, length)| &found[state * length..][..*length])
    };
    (0..STATES).flat_map(of_state).map(|&x| x.into()).collect()
}

/// The arguments of a function in random states.
fn states(model: &Model, function: &Function, arithmetic: Arithmetic) -> Vec<Arguments> {
    let mut random = SplitMix64::new(44);
    let mut state = || {
        let RandomState { q, v, a, tau } = random_state(model, &mut random);
        let mut numbers = |name: &str, length: usize| match name {
            "q" => q.clone(),
            "v" => v.clone(),
            "a" => a.clone(),
            "tau" => tau.clone(),
            "h" => vec![random.uniform(1e-4, 1e-2)],
            _ => (0..length).map(|_| random.uniform(-1.0, 1.0)).collect(),
        };
        let rounded = |row: Vec<f64>| row.into_iter().map(|x| arithmetic.precision.round(x)).collect();
        let arguments = function.arguments(model);
        arguments.iter().map(|argument| rounded(numbers(argument.name, argument.length))).collect()
    };
    (0..STATES).map(|_| state()).collect()
}

//! Machine code made in memory beside the library's own calls: time of a state, and time to compile.
//!
//! `cargo run --release -p bench --bin measure_native [ROBOT…]`
//!
//! Each function is traced on a model with exact right angles and regrouped masses, as generated code is, and compiled for one state and for
//! the lanes of the newest registers. The library and the code run on the same 1024 random states in turns, by one thread; each number is the median of
//! the rounds. The largest difference between both is relative to the largest number of a result.

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use bench::{StateTable, robot_by_name};
use expression::{Arithmetic, Graph, Operand, Precision, Traced, trace};
use multibody::batch::{BatchFloat, BatchOptions, BatchWorkspace};
use multibody::{InstructionSet, Model, Workspace};
use native::{Code, Float, Kernel, Target, Width, best_instructions};

const ROBOTS: [&str; 5] = ["two_r", "ur5", "panda", "humanoid", "talos"];
const STATES: usize = 1024;
const ROUNDS: usize = 15;

/// A function that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    InverseDynamics,
    ForwardDynamics,
    MassMatrix,
}

impl Function {
    const ALL: [Self; 3] = [Self::InverseDynamics, Self::ForwardDynamics, Self::MassMatrix];

    fn lengths(self, model: &Model) -> Vec<usize> {
        match self {
            Self::MassMatrix => vec![model.nq()],
            _ => vec![model.nq(), model.nv(), model.nv()],
        }
    }

    fn result(self, model: &Model) -> usize {
        match self {
            Self::MassMatrix => model.nv() * model.nv(),
            _ => model.nv(),
        }
    }

    /// The columns of a table of states that are its arguments.
    fn arguments(self) -> &'static [usize] {
        match self {
            Self::InverseDynamics => &[0, 1, 2],
            Self::ForwardDynamics => &[0, 1, 3],
            Self::MassMatrix => &[0],
        }
    }
}

fn main() -> ExitCode {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let names: Vec<&str> =
        if named.is_empty() { ROBOTS.to_vec() } else { named.iter().map(String::as_str).collect() };
    println!(
        "{:?}, {STATES} states, median of {ROUNDS} rounds; ns a state (share of the library's)",
        best_instructions()
    );
    for name in names {
        match robot_by_name(name) {
            Ok(model) => measure(name, &model),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn measure(name: &str, model: &Model) {
    let states = StateTable::random(model, STATES, 1);
    for function in Function::ALL {
        println!("{name} {function:?}");
        compile_times(model, function);
        one_state(model, &states, function);
        batches::<f64>(model, &states, function);
        batches::<f32>(model, &states, function);
    }
}

fn traced(model: &Model, function: Function, arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    let model = &model.with_right_angles().regrouped();
    trace(arithmetic, &function.lengths(model), |arguments| {
        let w = &mut Workspace::<Traced>::limited(model, InstructionSet::Portable);
        let mut result = vec![Traced(Operand::ZERO); function.result(model)];
        match (function, arguments) {
            (Function::InverseDynamics, [q, v, a]) => {
                multibody::inverse_dynamics(model, w, q, v, a, &mut result);
            }
            (Function::ForwardDynamics, [q, v, tau]) => {
                multibody::forward_dynamics(model, w, q, v, tau, &mut result);
            }
            (Function::MassMatrix, [q]) => multibody::mass_matrix(model, w, q, &mut result),
            _ => unreachable!("a function has its arguments"),
        }
        vec![result]
    })
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Milliseconds, the median of some runs.
fn milliseconds<R>(mut run: impl FnMut() -> R) -> f64 {
    let time = |_| {
        let begin = Instant::now();
        black_box(run());
        begin.elapsed().as_secs_f64() * 1e3
    };
    median((0..9).map(time).collect())
}

fn compile_times(model: &Model, function: Function) {
    let arithmetic = Arithmetic::default().with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = function.lengths(model);
    let of_trace = milliseconds(|| traced(model, function, arithmetic));
    for width in [Width::One, Width::Lanes] {
        let target = Target { instructions: best_instructions(), width, arithmetic };
        let code = Code::new(&graph, &results, &lengths, target).expect("code");
        let of_code = milliseconds(|| Code::new(&graph, &results, &lengths, target));
        let of_map = milliseconds(|| Kernel::<f64>::load(&code));
        let whole = milliseconds(|| {
            Kernel::<f64>::compile(&graph, &results, &lengths, arithmetic, target.instructions, width)
        });
        println!(
            "  compile {width:?}: trace {of_trace:.2} ms, lower, allocate and encode {:.2}, map {of_map:.3}, check {:.2}; {:?}",
            of_code,
            whole - of_code - of_map,
            code.statistics()
        );
    }
}

fn one_state(model: &Model, states: &StateTable, function: Function) {
    let arithmetic = Arithmetic::default().with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = function.lengths(model);
    let w = &mut Workspace::<f64>::new(model);
    let mut by_library = vec![0.0; function.result(model)];
    let mut library = |state: usize, result: &mut [f64]| {
        let [q, v, a, tau] = states.get(state);
        match function {
            Function::InverseDynamics => multibody::inverse_dynamics(model, w, q, v, a, result),
            Function::ForwardDynamics => multibody::forward_dynamics(model, w, q, v, tau, result),
            Function::MassMatrix => multibody::mass_matrix(model, w, q, result),
        }
    };
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon] {
        let compiled =
            Kernel::<f64>::compile(&graph, &results, &lengths, arithmetic, instructions, Width::One);
        let Ok(kernel) = compiled else { continue };
        let mut scratch = vec![0.0; kernel.scratch_len()];
        let mut by_code = vec![0.0; function.result(model)];
        let mut code = |state: usize, result: &mut [f64]| {
            let all = states.get(state);
            let mut arguments = [&[][..]; 3];
            let columns = function.arguments();
            arguments.iter_mut().zip(columns).for_each(|(argument, &column)| *argument = all[column]);
            let ran = kernel.call(&arguments[..columns.len()], &mut [result], &mut scratch);
            ran.expect("angles in range");
        };
        let (mut of_library, mut of_code, mut off) = (Vec::new(), Vec::new(), 0.0_f64);
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            (0..STATES).for_each(|state| library(state, black_box(&mut by_library)));
            of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let begin = Instant::now();
            (0..STATES).for_each(|state| code(state, black_box(&mut by_code)));
            of_code.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            off = off.max(difference(&by_library, &by_code));
        }
        let (of_library, of_code) = (median(of_library), median(of_code));
        println!(
            "  one state, {instructions:?}: library {of_library:.0}, native {of_code:.0} ({:.2}), off by {off:.0e}",
            of_code / of_library
        );
    }
}

fn batches<T: BatchFloat + Float>(model: &Model, states: &StateTable, function: Function) {
    let arithmetic = Arithmetic::new(T::PRECISION).with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = function.lengths(model);
    let tables = [0, 1, 2, 3].map(|column| -> Vec<T> {
        (0..STATES).flat_map(|state| states.get(state)[column]).map(|&x| T::nearest(x)).collect()
    });
    let [q, v, a, tau] = &tables;
    let mut by_library = vec![T::nearest(0.0); STATES * function.result(model)];
    let mut options = BatchOptions::default();
    options.threads = 1;
    let mut workspace = BatchWorkspace::<T>::with_options(model, options).expect("one thread");
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon] {
        let compiled =
            Kernel::<T>::compile(&graph, &results, &lengths, arithmetic, instructions, Width::Lanes);
        let Ok(kernel) = compiled else { continue };
        let mut scratch = vec![T::nearest(0.0); kernel.scratch_len()];
        let mut by_code = by_library.clone();
        let columns = function.arguments();
        let arguments: Vec<&[T]> = columns.iter().map(|&column| &tables[column][..]).collect();
        let (mut of_library, mut of_code) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            let result = black_box(&mut by_library[..]);
            let ran = match function {
                Function::InverseDynamics => {
                    multibody::batch::inverse_dynamics(model, &mut workspace, q, v, a, result)
                }
                Function::ForwardDynamics => {
                    multibody::batch::forward_dynamics(model, &mut workspace, q, v, tau, result)
                }
                Function::MassMatrix => multibody::batch::mass_matrix(model, &mut workspace, q, result),
            };
            ran.expect("finite results");
            of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let begin = Instant::now();
            let result = black_box(&mut by_code[..]);
            kernel.call_rows(STATES, &arguments, &mut [result], &mut scratch, |row| panic!("row {row}"));
            of_code.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
        }
        let (of_library, of_code) = (median(of_library), median(of_code));
        let double = |x: &Vec<T>| -> Vec<f64> { x.iter().map(|&x| x.into()).collect() };
        let (number, off) = match T::PRECISION {
            Precision::Double => ("f64", difference(&double(&by_library), &double(&by_code))),
            Precision::Single => ("f32", difference(&double(&by_library), &double(&by_code))),
        };
        println!(
            "  rows of {number}, {instructions:?}: library {of_library:.0}, native {of_code:.0} ({:.2}), off by {off:.0e}",
            of_code / of_library
        );
    }
}

/// The largest difference, relative to the largest number.
fn difference(x: &[f64], y: &[f64]) -> f64 {
    let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let off = x.iter().zip(y).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
    off / largest
}

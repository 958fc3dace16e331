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
use dynamics::Scalar;
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
    InverseDynamicsDerivatives,
    ForwardDynamicsDerivatives,
}

impl Function {
    const ALL: [Self; 5] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
    ];

    fn lengths(self, model: &Model) -> Vec<usize> {
        match self {
            Self::MassMatrix => vec![model.nq()],
            _ => vec![model.nq(), model.nv(), model.nv()],
        }
    }

    fn results(self, model: &Model) -> Vec<usize> {
        let (nv, square) = (model.nv(), model.nv() * model.nv());
        match self {
            Self::MassMatrix => vec![square],
            Self::InverseDynamics | Self::ForwardDynamics => vec![nv],
            Self::InverseDynamicsDerivatives => vec![square; 2],
            Self::ForwardDynamicsDerivatives => vec![square; 3],
        }
    }

    /// The columns of a table of states that are its arguments.
    fn arguments(self) -> &'static [usize] {
        match self {
            Self::InverseDynamics | Self::InverseDynamicsDerivatives => &[0, 1, 2],
            Self::ForwardDynamics | Self::ForwardDynamicsDerivatives => &[0, 1, 3],
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
        let zeros = |length| vec![Traced(Operand::ZERO); length];
        let mut results: Vec<Vec<Traced>> = function.results(model).into_iter().map(zeros).collect();
        let arguments: Vec<&[Traced]> = arguments.iter().map(|argument| &argument[..]).collect();
        call(function, model, w, &arguments, &mut results);
        results
    })
}

/// The library's call for one state.
fn call<S: Scalar>(
    function: Function,
    model: &Model,
    w: &mut Workspace<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    match (function, arguments, results) {
        (Function::InverseDynamics, [q, v, a], [x]) => multibody::inverse_dynamics(model, w, q, v, a, x),
        (Function::ForwardDynamics, [q, v, tau], [x]) => {
            multibody::forward_dynamics(model, w, q, v, tau, x);
        }
        (Function::MassMatrix, [q], [x]) => multibody::mass_matrix(model, w, q, x),
        (Function::InverseDynamicsDerivatives, [q, v, a], [x, y]) => {
            multibody::inverse_dynamics_derivatives(model, w, q, v, a, x, y);
        }
        (Function::ForwardDynamicsDerivatives, [q, v, tau], [x, y, z]) => {
            multibody::forward_dynamics_derivatives(model, w, q, v, tau, x, y, z);
        }
        _ => unreachable!("a function has its arguments and results"),
    }
}

/// The library's call for rows.
fn call_rows<T: BatchFloat>(
    function: Function,
    model: &Model,
    w: &mut BatchWorkspace<T>,
    arguments: &[&[T]],
    results: &mut [Vec<T>],
) {
    use multibody::batch;
    let ran = match (function, arguments, results) {
        (Function::InverseDynamics, [q, v, a], [x]) => batch::inverse_dynamics(model, w, q, v, a, x),
        (Function::ForwardDynamics, [q, v, tau], [x]) => batch::forward_dynamics(model, w, q, v, tau, x),
        (Function::MassMatrix, [q], [x]) => batch::mass_matrix(model, w, q, x),
        (Function::InverseDynamicsDerivatives, [q, v, a], [x, y]) => {
            batch::inverse_dynamics_derivatives(model, w, q, v, a, x, y)
        }
        (Function::ForwardDynamicsDerivatives, [q, v, tau], [x, y, z]) => {
            batch::forward_dynamics_derivatives(model, w, q, v, tau, x, y, z)
        }
        _ => unreachable!("a function has its arguments and results"),
    };
    ran.expect("finite results");
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
    let mut by_library: Vec<Vec<f64>> =
        function.results(model).into_iter().map(|length| vec![0.0; length]).collect();
    let mut by_code = by_library.clone();
    let columns = function.arguments();
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon] {
        let compiled =
            Kernel::<f64>::compile(&graph, &results, &lengths, arithmetic, instructions, Width::One);
        let Ok(kernel) = compiled else { continue };
        let mut scratch = vec![0.0; kernel.scratch_len()];
        let (mut of_library, mut of_code, mut off) = (Vec::new(), Vec::new(), 0.0_f64);
        for _ in 0..ROUNDS {
            let arguments = |state| columns.iter().map(move |&column| states.get(state)[column]);
            let begin = Instant::now();
            for state in 0..STATES {
                let mut slices = [&[][..]; 3];
                slices.iter_mut().zip(arguments(state)).for_each(|(slice, argument)| *slice = argument);
                call(function, model, w, &slices[..columns.len()], black_box(&mut by_library));
            }
            of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let begin = Instant::now();
            let mut results: Vec<&mut [f64]> = by_code.iter_mut().map(|result| &mut result[..]).collect();
            for state in 0..STATES {
                let mut slices = [&[][..]; 3];
                slices.iter_mut().zip(arguments(state)).for_each(|(slice, argument)| *slice = argument);
                let ran = kernel.call(&slices[..columns.len()], black_box(&mut results), &mut scratch);
                ran.expect("angles in range");
            }
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
    let mut by_library: Vec<Vec<T>> =
        (function.results(model).into_iter()).map(|length| vec![T::nearest(0.0); STATES * length]).collect();
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
            call_rows(function, model, &mut workspace, &arguments, black_box(&mut by_library));
            of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let mut results: Vec<&mut [T]> = by_code.iter_mut().map(|result| &mut result[..]).collect();
            let begin = Instant::now();
            let far = |row| panic!("row {row} has an angle out of range");
            let is_finite = kernel.call_rows(STATES, &arguments, black_box(&mut results), &mut scratch, far);
            assert!(is_finite);
            of_code.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
        }
        let (of_library, of_code) = (median(of_library), median(of_code));
        let double = |x: &[Vec<T>]| -> Vec<Vec<f64>> {
            x.iter().map(|x| x.iter().map(|&x| x.into()).collect()).collect()
        };
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

/// The largest difference, relative to the largest number of each result.
fn difference(x: &[Vec<f64>], y: &[Vec<f64>]) -> f64 {
    let of_result = |(x, y): (&Vec<f64>, &Vec<f64>)| {
        let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        x.iter().zip(y).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())) / largest
    };
    x.iter().zip(y).map(of_result).fold(0.0, f64::max)
}

//! Machine code beside the library's own calls: time of a state, and time to compile.
//!
//! `cargo run --release -p bench --bin measure_native [ROBOT…] [FUNCTION…]`
//!
//! Each function is traced on a model with exact right angles and regrouped masses, as for generated code. It
//! is compiled for one state and for the lanes of the widest registers. The library and the code run on the
//! same 1024 random states in turns, with one thread; each number is the median of the rounds. The largest
//! difference is relative to the largest number of a result.

mod calls;

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use bench::{StateTable, robot_by_name};
use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchWorkspace};
use robot_dynamics::model::{InstructionSet, Model};
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Precision};
use robot_dynamics_functions::{Argument, Function, Table};
use robot_dynamics_native::{Code, Float, Kernel, Target, Width, best_instructions};
use robot_dynamics_number::SplitMix64;

use self::calls::{Memory, call_rows, integrator};

const ROBOTS: [&str; 5] = ["two_r", "ur5", "panda", "humanoid", "talos"];
const STATES: usize = 1024;
const ROUNDS: usize = 15;
/// Time step \[s\].
const STEP: f64 = 1e-3;

/// The measured functions.
fn functions() -> Vec<Function> {
    vec![
        Function::InverseDynamics,
        Function::ForwardDynamics,
        Function::MassMatrix,
        Function::MassMatrixFactor,
        Function::InverseDynamicsDerivatives,
        Function::ForwardDynamicsDerivatives,
        Function::InverseDynamicsPullback,
        Function::ForwardDynamicsPullback,
        Function::SemiImplicitEulerStep.pullback(),
        Function::Rk4Step.pullback(),
    ]
}

/// Random states, and after q, v, a and τ the cotangents of two vectors and the time step.
struct Tables {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
    cotangents: Vec<f64>,
    steps: Vec<f64>,
}

impl Tables {
    fn random(model: &Model) -> Self {
        let states = StateTable::random(model, STATES, 1);
        let column = |k: usize| (0..STATES).flat_map(|state| states.get(state)[k]).copied().collect();
        let mut random = SplitMix64::new(2);
        let cotangents = (0..STATES * 2 * model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
        let [q, v, a, tau] = [0, 1, 2, 3].map(column);
        Self { q, v, a, tau, cotangents, steps: vec![STEP; STATES] }
    }

    /// The arguments of a function as tables with a row for each state.
    fn arguments(&self, model: &Model, function: &Function) -> Vec<&[f64]> {
        let table = |argument: &Argument| match argument.name {
            "q" => &self.q[..],
            "v" => &self.v,
            "a" => &self.a,
            "tau" => &self.tau,
            "h" => &self.steps,
            "cotangent" => &self.cotangents[..STATES * argument.length],
            other => unreachable!("no argument is called {other}"),
        };
        function.arguments(model).iter().map(table).collect()
    }
}

fn main() -> ExitCode {
    let mut robots: Vec<String> = std::env::args().skip(1).collect();
    let mut functions: Vec<Function> = Vec::new();
    robots.retain(|name| name.parse().map(|function| functions.push(function)).is_err());
    if functions.is_empty() {
        functions = self::functions();
    }
    let names: Vec<&str> =
        if robots.is_empty() { ROBOTS.to_vec() } else { robots.iter().map(String::as_str).collect() };
    println!(
        "{:?}, {STATES} states, median of {ROUNDS} rounds; ns a state (share of the library's)",
        best_instructions()
    );
    for name in names {
        match robot_by_name(name) {
            Ok(model) => measure(name, &model, &functions),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn measure(name: &str, model: &Model, functions: &[Function]) {
    let tables = Tables::random(model);
    for function in functions {
        println!("{name} {function}");
        compile_times(model, function);
        one_state(model, &tables, function);
        batches::<f64>(model, &tables, function);
        batches::<f32>(model, &tables, function);
    }
}

/// The expression, without ∂τ/∂a = M of the derivatives of inverse dynamics, which the library's call does
/// not compute.
fn traced(model: &Model, function: &Function, arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    // The pullbacks of inverse and forward dynamics are derived from the graph.
    let through_graph = match function {
        Function::InverseDynamicsPullback => Function::Pullback(Box::new(Function::InverseDynamics)),
        Function::ForwardDynamicsPullback => Function::Pullback(Box::new(Function::ForwardDynamics)),
        function => function.clone(),
    };
    let traced = through_graph.trace(model, arithmetic).expect("a regular mass matrix");
    let mut results = traced.results;
    if *function == Function::ForwardDynamicsPullback {
        results.splice(..0, traced.primal).for_each(drop);
    }
    results.truncate(results_of(model, function).len());
    (traced.graph, results)
}

fn lengths(model: &Model, function: &Function) -> Vec<usize> {
    function.arguments(model).iter().map(|argument| argument.length).collect()
}

/// The lengths of the results.
fn results_of(model: &Model, function: &Function) -> Vec<usize> {
    let mut lengths: Vec<usize> = function.writes(model).iter().map(Table::width).collect();
    if *function == Function::InverseDynamicsDerivatives {
        lengths.truncate(2);
    }
    lengths
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

fn compile_times(model: &Model, function: &Function) {
    let arithmetic = Arithmetic::default().with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = lengths(model, function);
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

fn one_state(model: &Model, tables: &Tables, function: &Function) {
    let arithmetic = Arithmetic::default().with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = lengths(model, function);
    let memory = &mut Memory::new(model);
    let mut by_library: Vec<Vec<f64>> =
        results_of(model, function).into_iter().map(|length| vec![0.0; length]).collect();
    let mut by_code = by_library.clone();
    let tables = tables.arguments(model, function);
    let (mut given, count): ([&[f64]; 5], usize) = ([&[]; 5], lengths.len());
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon] {
        let compiled =
            Kernel::<f64>::compile(&graph, &results, &lengths, arithmetic, instructions, Width::One);
        let Ok(kernel) = compiled else { continue };
        let mut scratch = vec![0.0; kernel.scratch_len()];
        let (mut of_library, mut of_code, mut off) = (Vec::new(), Vec::new(), 0.0_f64);
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            for state in 0..STATES {
                for k in 0..count {
                    given[k] = &tables[k][state * lengths[k]..(state + 1) * lengths[k]];
                }
                memory.call(model, function, &given[..count], black_box(&mut by_library));
            }
            of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let begin = Instant::now();
            let mut results: Vec<&mut [f64]> = by_code.iter_mut().map(|result| &mut result[..]).collect();
            for state in 0..STATES {
                for k in 0..count {
                    given[k] = &tables[k][state * lengths[k]..(state + 1) * lengths[k]];
                }
                let ran = kernel.call(&given[..count], black_box(&mut results), &mut scratch);
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

fn batches<T: BatchFloat + Float>(model: &Model, tables: &Tables, function: &Function) {
    let arithmetic = Arithmetic::new(T::PRECISION).with_fused();
    let (graph, results) = traced(model, function, arithmetic);
    let lengths = lengths(model, function);
    let nearest = |table: &[f64]| table.iter().map(|&x| T::nearest(x)).collect::<Vec<T>>();
    let mut arguments: Vec<Vec<T>> = tables.arguments(model, function).into_iter().map(nearest).collect();
    // The rollout's pullback takes the cotangents of q and of v separately, the kernel one after the other.
    let of_library = arguments.clone();
    if integrator(function).is_some() {
        let (nv, cotangents) = (model.nv(), &of_library[4]);
        let half = STATES * nv;
        let row = |state: usize| {
            let own = state * nv..(state + 1) * nv;
            let of_v = half + own.start..half + own.end;
            cotangents[own].iter().chain(&cotangents[of_v]).copied().collect::<Vec<T>>()
        };
        arguments[4] = (0..STATES).flat_map(row).collect();
    }
    let [arguments, of_library] =
        [&arguments, &of_library].map(|tables| tables.iter().map(|table| &table[..]).collect::<Vec<&[T]>>());
    let mut by_library: Vec<Vec<T>> = (results_of(model, function).into_iter())
        .map(|length| vec![T::nearest(0.0); STATES * length])
        .collect();
    let mut options = BatchOptions::default();
    options.threads = 1;
    let mut workspace = BatchWorkspace::<T>::with_options(model, options).expect("one thread");
    if !call_rows(function, model, &mut workspace, &of_library, &mut by_library) {
        return;
    }
    for instructions in [InstructionSet::Avx2, InstructionSet::Avx512, InstructionSet::Neon] {
        let compiled =
            Kernel::<T>::compile(&graph, &results, &lengths, arithmetic, instructions, Width::Lanes);
        let Ok(kernel) = compiled else { continue };
        let mut scratch = vec![T::nearest(0.0); kernel.scratch_len()];
        let mut by_code = by_library.clone();
        let (mut times_of_library, mut times_of_code) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            call_rows(function, model, &mut workspace, &of_library, black_box(&mut by_library));
            times_of_library.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
            let mut results: Vec<&mut [T]> = by_code.iter_mut().map(|result| &mut result[..]).collect();
            let begin = Instant::now();
            let far = |row| panic!("row {row} has an angle out of range");
            let is_finite = kernel.call_rows(STATES, &arguments, black_box(&mut results), &mut scratch, far);
            assert!(is_finite);
            times_of_code.push(begin.elapsed().as_secs_f64() * 1e9 / STATES as f64);
        }
        let (of_library, of_code) = (median(times_of_library), median(times_of_code));
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

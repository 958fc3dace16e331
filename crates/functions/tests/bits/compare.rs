//! Comparisons of machine code with its graph, and of the graph with the library.

use robot_dynamics::model::{InstructionSet, Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Plan, Precision, as_traced, interpret};
use robot_dynamics_functions::{Function, TracedFunction};
use robot_dynamics_native::{Code, CompileError, Float, Kernel, Target, Width};

use crate::extent::Extent;

/// States of each robot: fewer than a register has lanes, so that the rows of a table differ within each
/// group of lanes.
const STATES: usize = 3;

/// Graphs with more operations take seconds each. They are compared with or without fused multiply-adds,
/// alternately. One set of instructions is used for one state, another one for rows. The library's values are
/// compared in one state.
const LARGE: usize = 20_000;

/// Counts of comparisons.
#[derive(Debug, Default)]
pub(crate) struct Comparison {
    robots: usize,
    pub(crate) graphs: usize,
    /// Graphs that are too large for this run.
    pub(crate) left_out: usize,
    operations: usize,
    kernels: usize,
    numbers: usize,
    /// The largest difference from the library, relative to the bound on rounding.
    farthest: f64,
}

/// A state, in the order of the functions' arguments by name.
struct State {
    plain: RandomState,
    cotangent: Vec<f64>,
    step: f64,
    /// The condition number of M in the maximum norm, and M's largest entry.
    condition: f64,
    largest_mass: f64,
}

impl State {
    fn random(model: &Model, random: &mut SplitMix64) -> Self {
        let plain = random_state(model, random);
        // Portable workspaces use the recursions, not machine code.
        let (nv, workspace) = (model.nv(), &mut Workspace::limited(model, InstructionSet::Portable));
        let (mut mass, mut inverse) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
        robot_dynamics::algorithms::mass_matrix(model, workspace, &plain.q, &mut mass);
        robot_dynamics::algorithms::inverse_mass_matrix(model, workspace, &plain.q, &mut inverse);
        Self {
            plain,
            cotangent: (0..2 * nv).map(|_| random.uniform(-1.0, 1.0)).collect(),
            step: random.uniform(1e-4, 1e-2),
            condition: norm(&mass, nv) * norm(&inverse, nv),
            largest_mass: largest(&mass),
        }
    }

    /// Its arguments for a function, rounded to a precision.
    fn arguments(&self, model: &Model, function: &Function, precision: Precision) -> Vec<Vec<f64>> {
        let named = |name: &str, length: usize| match name {
            "q" => self.plain.q.clone(),
            "v" => self.plain.v.clone(),
            "a" => self.plain.a.clone(),
            "tau" => self.plain.tau.clone(),
            "h" => vec![self.step],
            "cotangent" => self.cotangent[..length].to_vec(),
            other => panic!("there is no argument {other}"),
        };
        let rounded = |row: Vec<f64>| row.into_iter().map(|x| precision.round(x)).collect();
        let arguments = function.arguments(model);
        arguments.iter().map(|argument| rounded(named(argument.name, argument.length))).collect()
    }
}

/// A graph with several states, and the results in each, operation by operation.
struct Interpreted<'a> {
    name: String,
    graph: &'a Graph,
    results: &'a [Vec<Operand>],
    arithmetic: Arithmetic,
    arguments: &'a [Vec<Vec<f64>>],
    expected: Vec<Vec<Vec<f64>>>,
}

impl Comparison {
    /// Compares every function of a robot.
    pub(crate) fn robot(&mut self, name: &str, model: &Model, extent: Extent) {
        let mut random = SplitMix64::new(2026);
        let states: Vec<State> = (0..STATES).map(|_| State::random(model, &mut random)).collect();
        let frame = &model.frames().last().expect("a robot has a frame").name;
        // The pullbacks through the graph that machine code computes.
        let through_graph = [
            Function::Pullback(Box::new(Function::InverseDynamics)),
            Function::Pullback(Box::new(Function::ForwardDynamics)),
            Function::SemiImplicitEulerStep.pullback(),
            Function::Rk4Step.pullback(),
        ];
        let functions: Vec<Function> =
            Function::PLAIN.into_iter().chain(Function::of_frame(frame)).chain(through_graph).collect();
        let inverse_dynamics = Function::InverseDynamics.trace(model, Arithmetic::default());
        let unit = inverse_dynamics.unwrap_or_else(|error| panic!("{name}: {error}")).plan.steps();
        if extent.is_whole {
            println!("{name}: {} degrees of freedom, {self:?}", model.nv());
        }
        let (first, mut left) = (self.robots, extent.of_robot);
        self.robots += 1;
        for number in 0..functions.len() {
            let function = &functions[(first + number) % functions.len()];
            let [double, single] = [Precision::Double, Precision::Single].map(Arithmetic::new);
            let least = least_operations(function, unit, model.nv());
            let ways = if extent.is_whole && least <= LARGE {
                vec![double, double.with_fused(), single, single.with_fused()]
            } else if (first + number).is_multiple_of(2) {
                vec![double, single.with_fused()]
            } else {
                vec![double.with_fused(), single]
            };
            let most = extent.operations.min(left / ways.len());
            if least > most {
                self.left_out += ways.len();
                continue;
            }
            for arithmetic in ways {
                let traced =
                    function.trace(model, arithmetic).unwrap_or_else(|error| panic!("{name}: {error}"));
                let steps = traced.plan.steps();
                if steps > most {
                    self.left_out += 1;
                    continue;
                }
                left -= steps;
                self.operations += steps;
                self.graphs += 1;
                self.graph(name, model, function, (&traced, arithmetic), &states);
            }
        }
    }

    fn graph(
        &mut self,
        robot: &str,
        model: &Model,
        function: &Function,
        (traced, arithmetic): (&TracedFunction, Arithmetic),
        states: &[State],
    ) {
        let (graph, results) = (&traced.graph, &traced.results[..]);
        let plan = Plan { order: as_traced(graph, results), live: 0 };
        let arguments: Vec<Vec<Vec<f64>>> =
            states.iter().map(|state| state.arguments(model, function, arithmetic.precision)).collect();
        let expected: Vec<Vec<Vec<f64>>> = (arguments.iter())
            .map(|arguments| interpret(graph, &plan, results, arithmetic, arguments).0)
            .collect();
        let name = format!("{robot}, {function}, {arithmetic:?}");
        let interpreted = Interpreted { name, graph, results, arithmetic, arguments: &arguments, expected };
        match arithmetic.precision {
            Precision::Double => {
                self.kernels::<f64>(&interpreted);
                let count = if interpreted.graph.nodes.len() > LARGE { 1 } else { STATES };
                let rows = states.iter().zip(&arguments).zip(&interpreted.expected);
                for ((state, arguments), expected) in rows.take(count) {
                    let by_dual_numbers = function.derivatives_by_dual_numbers(model, arguments).unwrap();
                    let found =
                        by_dual_numbers.unwrap_or_else(|| function.compute::<f64>(model, arguments).unwrap());
                    self.values(&interpreted.name, model, function, state, (expected, &found));
                }
            }
            Precision::Single => self.kernels::<f32>(&interpreted),
        }
    }

    /// Compares the code of a graph on every set of instructions of this machine, for one state and for rows.
    fn kernels<T: Float>(&mut self, interpreted: &Interpreted<'_>) {
        let Interpreted { name, graph, results, arithmetic, arguments, expected } = interpreted;
        let lengths: Vec<usize> = arguments[0].iter().map(Vec::len).collect();
        let is_large = graph.nodes.len() > LARGE;
        for (set, &instructions) in InstructionSet::ALL.iter().enumerate() {
            for width in [Width::One, Width::Lanes] {
                let turn = set + usize::from(width == Width::Lanes) + usize::from(arithmetic.fused);
                if is_large && turn.is_multiple_of(2) {
                    continue;
                }
                let target = Target { instructions, width, arithmetic: *arithmetic };
                let what = || format!("{name}, {instructions:?}, {width:?}");
                // `Kernel::compile` would interpret the graph again for each kernel.
                let loaded =
                    Code::new(graph, results, &lengths, target).and_then(|code| Kernel::<T>::load(&code));
                let kernel = match loaded {
                    Ok(kernel) => kernel,
                    Err(CompileError::NoEncoder { .. } | CompileError::NotOnThisProcessor { .. }) => continue,
                    Err(CompileError::TooLarge { .. }) => {
                        println!("left out: {} has {} operations", what(), graph.nodes.len());
                        continue;
                    }
                    Err(error) => panic!("{}: {error}", what()),
                };
                // A full group of lanes, and one more row.
                let rows = kernel.lanes() + 1;
                let input = |argument: usize| -> Vec<T> {
                    (0..rows)
                        .flat_map(|row| &arguments[row % STATES][argument])
                        .map(|&x| T::nearest(x))
                        .collect()
                };
                let inputs: Vec<Vec<T>> = (0..lengths.len()).map(input).collect();
                let inputs: Vec<&[T]> = inputs.iter().map(|input| &input[..]).collect();
                let mut found: Vec<Vec<T>> =
                    results.iter().map(|result| vec![T::nearest(f64::NAN); rows * result.len()]).collect();
                let mut outputs: Vec<&mut [T]> = found.iter_mut().map(|output| &mut output[..]).collect();
                let mut scratch = vec![T::nearest(f64::NAN); kernel.scratch_len()];
                let far = |row| panic!("{}: an angle of row {row} is out of range", what());
                kernel.call_rows(rows, &inputs, &mut outputs, &mut scratch, far);
                for (result, found) in found.iter().enumerate() {
                    let width = results[result].len();
                    for (at, &x) in found.iter().enumerate() {
                        let (row, index) = (at / width, at % width);
                        let (x, y) = (x.into(), expected[row % STATES][result][index]);
                        let is_same = x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan();
                        assert!(
                            is_same,
                            "{}: row {row}, number {index} of result {result} is {x:e}, not {y:e}",
                            what()
                        );
                    }
                }
                self.kernels += 1;
                self.numbers += found.iter().map(Vec::len).sum::<usize>();
            }
        }
    }

    /// Compares the values of a graph with those of the library.
    ///
    /// Each number of a recursion is a sum over bodies, and passes through at most n of them outwards and n
    /// inwards. A body adds some eight roundings: a rotation, a cross product, a sum. So the error of each is
    /// at most 16 n ε of the largest number, and they differ by 32 n ε. Where M is inverted, the condition
    /// number of M multiplies that. Forces may cancel in a result; they have the size of M's entries, as
    /// velocities and accelerations are of order one.
    fn values(
        &mut self,
        name: &str,
        model: &Model,
        function: &Function,
        state: &State,
        (graph, library): (&[Vec<f64>], &[Vec<f64>]),
    ) {
        let all = library.iter().map(|result| largest(result)).fold(state.largest_mass, f64::max);
        let condition = if function.inverts_mass() { state.condition } else { 1.0 };
        let allowed = 32.0 * model.joints().len() as f64 * condition * f64::EPSILON * all;
        for (result, (graph, library)) in graph.iter().zip(library).enumerate() {
            for (index, (x, y)) in graph.iter().zip(library).enumerate() {
                let off = (x - y).abs() / allowed;
                self.farthest = self.farthest.max(off);
                assert!(
                    off <= 1.0,
                    "{name}: number {index} of result {result} is {x:e} by the graph and {y:e} by the library, off by {off} of what rounding can do; condition {:e}",
                    state.condition
                );
            }
        }
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// The maximum norm of a square matrix: the largest sum of a row's magnitudes.
fn norm(matrix: &[f64], rows: usize) -> f64 {
    matrix.chunks(rows).map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max)
}

/// A lower bound on the operations of a function, from those of inverse dynamics, so that no graph is traced
/// in vain.
fn least_operations(function: &Function, inverse_dynamics: usize, nv: usize) -> usize {
    let tenths = match function {
        Function::Pullback(of) if **of == Function::InverseDynamics => 20,
        Function::Pullback(of) if **of == Function::Rk4Step => 160 + 2 * nv,
        Function::Pullback(_) => 40,
        Function::InverseDynamics => 10,
        Function::Bias => 8,
        Function::VelocityProduct => 6,
        Function::Momentum => 11,
        Function::MassMatrix | Function::MassMatrixRelated => 5 + nv / 10,
        Function::MassMatrixFactor => 5 + nv / 8,
        Function::InverseMassMatrix => 5 + nv / 2,
        Function::ForwardDynamics | Function::SemiImplicitEulerStep => 20,
        Function::CoriolisMatrix | Function::JointTorqueRegressor => 25,
        Function::InverseDynamicsPullback => 34,
        Function::ForwardDynamicsPullback => 50,
        Function::Rk4Step => 80,
        Function::InverseDynamicsDerivatives => 40 + nv,
        Function::ForwardDynamicsDerivatives => 50 + 2 * nv,
        Function::CenterOfMassJacobian => 5,
        Function::Gravity | Function::KineticEnergy | Function::PotentialEnergy | Function::CenterOfMass => 4,
        _ => 0,
    };
    inverse_dynamics * tenths / 10
}

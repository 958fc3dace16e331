//! A function of one robot: traced, scheduled, and with expected values.

use robot_dynamics::model::{Model, RandomState, random_state};
use robot_dynamics_expression::{Arithmetic, Graph, Operand, Operation, Plan, Sine, interpret};
use robot_dynamics_number::SplitMix64;

use crate::layout::Layout;
use crate::{Function, GenerateError};

pub(crate) use robot_dynamics_functions::Argument;
use robot_dynamics_functions::FunctionResult;

/// A result, a matrix by rows.
#[derive(Clone, Debug)]
pub(crate) struct ProgramResult {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) what: &'static str,
}

impl ProgramResult {
    pub(crate) fn length(&self) -> usize {
        self.rows * self.columns
    }
}

/// A function, ready to be written in any language.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) function: Function,
    /// Its name in the generated code.
    pub(crate) symbol: String,
    pub(crate) arguments: Vec<Argument>,
    pub(crate) outcomes: Vec<ProgramResult>,
    pub(crate) graph: Graph,
    pub(crate) results: Vec<Vec<Operand>>,
    pub(crate) plan: Plan,
    pub(crate) cases: Vec<Case>,
    /// Row and column of each number of the result, if that is a matrix without its zeros.
    pub(crate) entries: Vec<(usize, usize)>,
    /// The tolerance of results: 0, or the effect of another sine or another order of operations.
    pub(crate) tolerance: f64,
    /// The stages that compute it, if it is not one expression.
    pub(crate) stages: Option<Stages>,
}

/// A function in stages, with the tables that these pass on, and the order in which they are called.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    pub(crate) stages: Vec<Stage>,
    /// The tables in a thread's own memory, with their lengths.
    pub(crate) locals: Vec<(&'static str, usize)>,
    pub(crate) body: Vec<Instruction>,
}

/// A stage of a function.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) program: Program,
    pub(crate) layout: Layout,
}

/// A table, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// An argument or a result of the function.
    State(&'static str),
    /// A part of a table in the thread's own memory.
    Local { table: &'static str, offset: usize },
}

impl Place {
    pub(crate) const fn table(&self) -> &'static str {
        match self {
            Self::State(table) | Self::Local { table, .. } => table,
        }
    }

    pub(crate) const fn offset(&self) -> usize {
        match self {
            Self::State(_) => 0,
            Self::Local { offset, .. } => *offset,
        }
    }

    /// A later part of a table.
    pub(crate) const fn shifted(self, by: usize) -> Self {
        Self::Local { table: self.table(), offset: self.offset() + by }
    }
}

/// An instruction of a function in stages.
#[derive(Clone, Debug)]
pub(crate) enum Instruction {
    Call(Call),
    Clear {
        place: Place,
        count: usize,
    },
    Copy {
        from: Place,
        to: Place,
        count: usize,
    },
    /// to += from.
    Add {
        from: Place,
        to: Place,
        count: usize,
    },
    Repeat {
        count: usize,
        body: Vec<Self>,
    },
}

/// A call of a stage, by its index.
#[derive(Clone, Debug)]
pub(crate) struct Call {
    pub(crate) stage: usize,
    pub(crate) arguments: Vec<Place>,
    pub(crate) results: Vec<Place>,
}

impl Stages {
    /// All calls with their numbers of repetitions, in order.
    pub(crate) fn calls(&self) -> Vec<(&Call, usize)> {
        fn collect<'a>(body: &'a [Instruction], times: usize, calls: &mut Vec<(&'a Call, usize)>) {
            for instruction in body {
                match instruction {
                    Instruction::Call(call) => calls.push((call, times)),
                    Instruction::Repeat { count, body } => collect(body, times * count, calls),
                    Instruction::Clear { .. } | Instruction::Copy { .. } | Instruction::Add { .. } => {}
                }
            }
        }
        let mut calls = Vec::new();
        collect(&self.body, 1, &mut calls);
        calls
    }
}

/// A state, with the library's results.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) arguments: Vec<Vec<f64>>,
    pub(crate) results: Vec<Vec<f64>>,
}

impl Program {
    /// # Errors
    /// [`GenerateError::Function`], [`GenerateError::Differs`], [`GenerateError::NotFinite`].
    pub(crate) fn new(
        function: &Function,
        model: &Model,
        arithmetic: Arithmetic,
        states: usize,
    ) -> Result<Self, GenerateError> {
        let traced = function.trace(model, arithmetic)?;
        let arguments = function.arguments(model);
        let outcomes = outcomes(function, model);
        let (mut cases, mut tolerance) = (Vec::new(), 0.0_f64);
        for inputs in random_arguments(function, model, arithmetic, states) {
            if let Some(expected) = function.derivatives_by_dual_numbers(model, &inputs)? {
                let (found, bounds) =
                    interpret(&traced.graph, &traced.plan, &traced.results, arithmetic, &inputs);
                let values = traced.evaluate(&inputs);
                if !is_within(arithmetic, model.nv(), &values, (&found, &bounds), &expected) {
                    return Err(GenerateError::Differs {
                        robot: model.name().into(),
                        function: function.to_string(),
                    });
                }
                let rounded = |row: Vec<f64>| row.iter().map(|&x| arithmetic.precision.round(x)).collect();
                let expected: Vec<Vec<f64>> = expected.into_iter().map(rounded).collect();
                tolerance = tolerance.max(uncertainty(arithmetic, &expected, &found));
                cases.push(Case { arguments: inputs, results: expected });
                continue;
            }
            let results = traced.evaluate(&inputs);
            if arithmetic.sine == Sine::Platform {
                let own = traced.evaluate_in(arithmetic.with_sine(Sine::Own), &inputs);
                tolerance = tolerance.max(uncertainty(arithmetic, &results, &own));
            }
            cases.push(Case { arguments: inputs, results });
        }
        let entries = match function {
            Function::MassMatrixRelated => robot_dynamics::algorithms::mass_matrix_related_entries(model),
            _ => Vec::new(),
        };
        let program = Self {
            function: function.clone(),
            symbol: function.symbol(),
            arguments,
            outcomes,
            graph: traced.graph,
            results: traced.results,
            plan: traced.plan,
            cases,
            entries,
            tolerance,
            stages: None,
        };
        program.check_finite(model)?;
        Ok(program)
    }

    /// Rejects constants and values of the test states that are not finite.
    fn check_finite(&self, model: &Model) -> Result<(), GenerateError> {
        let is_finite = |operand: Operand| operand.known().is_none_or(f64::is_finite);
        let mut steps = self.plan.order.iter();
        let is_sound = self.results.iter().flatten().all(|&result| is_finite(result))
            && steps.all(|&node| self.graph.nodes[node].operands().all(is_finite))
            && self.cases.iter().all(|case| case.results.iter().flatten().all(|x| x.is_finite()));
        if is_sound {
            return Ok(());
        }
        Err(GenerateError::NotFinite { robot: model.name().into(), function: self.function.to_string() })
    }

    /// Operations by kind.
    pub(crate) fn counts(&self) -> OperationCounts {
        let mut counts = OperationCounts::default();
        if let Some(stages) = &self.stages {
            for (call, times) in stages.calls() {
                counts.add(stages.stages[call.stage].program.counts(), times);
            }
        }
        for &node in &self.plan.order {
            let count = match self.graph.nodes[node] {
                Operation::Sum(..) | Operation::Difference(..) => &mut counts.additions,
                Operation::Product(..) => &mut counts.multiplications,
                Operation::Fused(..) | Operation::FusedMinus(..) => &mut counts.fused,
                Operation::Quotient(..) => &mut counts.divisions,
                Operation::Root(_) => &mut counts.roots,
                Operation::SineCosine(_) => &mut counts.sines,
                Operation::Input { .. } | Operation::Sign(_) | Operation::Sine(_) | Operation::Cosine(_) => {
                    continue;
                }
            };
            *count += 1;
        }
        counts
    }
}

/// Operations by kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OperationCounts {
    pub(crate) additions: usize,
    pub(crate) multiplications: usize,
    pub(crate) fused: usize,
    pub(crate) divisions: usize,
    pub(crate) roots: usize,
    pub(crate) sines: usize,
}

impl OperationCounts {
    /// Adds the operations of a stage.
    fn add(&mut self, other: Self, repeats: usize) {
        self.additions += other.additions * repeats;
        self.multiplications += other.multiplications * repeats;
        self.fused += other.fused * repeats;
        self.divisions += other.divisions * repeats;
        self.roots += other.roots * repeats;
        self.sines += other.sines * repeats;
    }
}

/// Whether derivatives differ by rounding alone: by the bounds of the operations, and by 16 nv roundings of
/// the function's largest value. The library works in other frames, in which a number that is zero here is a
/// sum of such values.
fn is_within(
    arithmetic: Arithmetic,
    nv: usize,
    values: &[Vec<f64>],
    (found, bounds): (&[Vec<f64>], &[Vec<f64>]),
    expected: &[Vec<f64>],
) -> bool {
    let largest = |rows: &[Vec<f64>]| rows.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    let of_others = 16.0 * nv as f64 * arithmetic.precision.epsilon() * largest(values);
    // Values that are not finite are rejected elsewhere.
    (found.iter().zip(bounds).zip(expected)).all(|((found, bounds), expected)| {
        let allowed = 2.0 * largest(core::slice::from_ref(bounds)) + of_others;
        let is_close = |(x, y): (&f64, &f64)| {
            let off = (x - y).abs();
            off <= allowed || !off.is_finite()
        };
        found.iter().zip(expected).all(is_close)
    })
}

/// The effect of another sine's last digit, or of another order of operations: ten times the effect here, and
/// some roundings.
pub(crate) fn uncertainty(arithmetic: Arithmetic, results: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let epsilon = arithmetic.precision.epsilon();
    let pairs = results.iter().flatten().zip(other.iter().flatten());
    pairs.fold(0.0_f64, |most, (x, y)| most.max(10.0 * (x - y).abs() + 16.0 * epsilon * x.abs()))
}

/// The results of a function.
pub(crate) fn outcomes(function: &Function, model: &Model) -> Vec<ProgramResult> {
    let result = |FunctionResult { name, rows, columns, what }| ProgramResult {
        name: String::from(name),
        rows,
        columns,
        what,
    };
    function.results(model).into_iter().map(result).collect()
}

/// Arguments of random states, rounded to the arithmetic's precision, the same in each call.
pub(crate) fn random_arguments(
    function: &Function,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Vec<Vec<Vec<f64>>> {
    if function.arguments(model).iter().any(|argument| argument.name == "problem") {
        return arguments_of_stage(function, model, arithmetic, states);
    }
    let mut random = SplitMix64::new(2026);
    let mut state = || {
        let RandomState { q, v, a, tau } = random_state(model, &mut random);
        let cotangent: Vec<f64> = v.iter().map(|_| random.uniform(-1.0, 1.0)).collect();
        let arguments = function.arguments(model);
        let has_step = arguments.iter().any(|argument| argument.name == "h");
        let h = if has_step { vec![random.uniform(1e-4, 1e-2)] } else { Vec::new() };
        let is_of_derivatives = function.is_through_graph();
        let mut named = |argument: &Argument| match argument.name {
            "q" => q.clone(),
            "v" => v.clone(),
            "a" => a.clone(),
            "tau" => tau.clone(),
            "h" => h.clone(),
            "friction" | "impulses" => (0..argument.length).map(|_| random.uniform(0.0, 1.0)).collect(),
            _ if !is_of_derivatives => cotangent.clone(),
            _ => (0..argument.length).map(|_| random.uniform(-1.0, 1.0)).collect(),
        };
        let rounded = |row: Vec<f64>| row.iter().map(|&x| arithmetic.precision.round(x)).collect();
        arguments.iter().map(|argument| rounded(named(argument))).collect()
    };
    (0..states).map(|_| state()).collect()
}

/// Arguments of a later stage of a step with contact: the results of the first stage in random states.
fn arguments_of_stage(
    function: &Function,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Vec<Vec<Vec<f64>>> {
    let first = Function::ContactProblem;
    let names: Vec<&str> = first.arguments(model).iter().map(|argument| argument.name).collect();
    let mut random = SplitMix64::new(2027);
    let of_state = |arguments: Vec<Vec<f64>>| {
        // A robot without this function is rejected when it is traced.
        let results = first.compute(model, &arguments).unwrap_or_default();
        let mut named = |argument: Argument| match argument.name {
            "problem" => results.first().cloned().unwrap_or_default(),
            "velocity" => results.get(1).cloned().unwrap_or_default(),
            name => match names.iter().position(|other| *other == name) {
                Some(k) => arguments[k].clone(),
                None => (0..argument.length).map(|_| random.uniform(0.0, 1.0)).collect(),
            },
        };
        let rounded = |row: Vec<f64>| row.iter().map(|&x| arithmetic.precision.round(x)).collect();
        function.arguments(model).into_iter().map(|argument| rounded(named(argument))).collect()
    };
    random_arguments(&first, model, arithmetic, states).into_iter().map(of_state).collect()
}

#[cfg(test)]
mod derivative_tests;
#[cfg(test)]
mod tests;

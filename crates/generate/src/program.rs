//! A function of one robot, traced, ordered, and with values that it must give.

use multibody::{Model, MotionError, RandomState, random_state};
use number::SplitMix64;

use crate::graph::{Graph, Operand, Operation};
use crate::plan::Plan;
use crate::traced::{Traced, evaluate, trace};
use crate::{Arithmetic, Function, GenerateError, Sine, call};

/// An argument.
#[derive(Clone, Debug)]
pub(crate) struct Argument {
    pub(crate) name: &'static str,
    pub(crate) length: usize,
    pub(crate) unit: &'static str,
}

/// A result, a matrix by rows.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) what: &'static str,
}

impl Outcome {
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
    pub(crate) outcomes: Vec<Outcome>,
    pub(crate) graph: Graph,
    pub(crate) results: Vec<Vec<Operand>>,
    pub(crate) plan: Plan,
    pub(crate) cases: Vec<Case>,
    /// Row and column of each number of the result, where that is a matrix without its zeros.
    pub(crate) entries: Vec<(usize, usize)>,
    /// What results may be off: 0, or what the platform's sine may change.
    pub(crate) tolerance: f64,
}

/// A state, and what the library gives for it.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) arguments: Vec<Vec<f64>>,
    pub(crate) results: Vec<Vec<f64>>,
}

impl Program {
    /// # Errors
    /// [`GenerateError::NoSuchFrame`], [`GenerateError::Singular`], [`GenerateError::NotFinite`].
    pub(crate) fn new(
        function: &Function,
        model: &Model,
        arithmetic: Arithmetic,
        states: usize,
    ) -> Result<Self, GenerateError> {
        check_mass(function, model)?;
        let compute = call::call::<Traced>(function, model)?;
        let arguments: Vec<Argument> = (function.arguments().iter())
            .map(|&(name, size, unit)| Argument { name, length: size.of(model), unit })
            .collect();
        let outcomes: Vec<Outcome> = (function.results().iter())
            .map(|&(name, rows, columns, what)| Outcome {
                name: name.into(),
                rows: rows.of(model),
                columns: columns.of(model),
                what,
            })
            .collect();
        let lengths: Vec<usize> = arguments.iter().map(|argument| argument.length).collect();
        let (graph, results) = trace(arithmetic, &lengths, &compute);
        let plan = Plan::new(&graph, &results);
        let (mut cases, mut tolerance) = (Vec::new(), 0.0_f64);
        for inputs in random_arguments(function, model, arithmetic, states) {
            let results = evaluate(arithmetic, &inputs, &compute);
            if arithmetic.sine == Sine::Platform {
                let own = evaluate(arithmetic.with_sine(Sine::Own), &inputs, &compute);
                tolerance = tolerance.max(doubt(arithmetic, &results, &own));
            }
            cases.push(Case { arguments: inputs, results });
        }
        let entries = match function {
            Function::MassMatrixRelated => multibody::mass_matrix_related_entries(model),
            _ => Vec::new(),
        };
        let program = Self {
            function: function.clone(),
            symbol: symbol(function),
            arguments,
            outcomes,
            graph,
            results,
            plan,
            cases,
            entries,
            tolerance,
        };
        program.check_finite(model)?;
        Ok(program)
    }

    /// Refuses constants, and values of the test states, that are not finite.
    fn check_finite(&self, model: &Model) -> Result<(), GenerateError> {
        let is_finite = |operand: Operand| operand.known().is_none_or(f64::is_finite);
        let steps = self.plan.parts.iter().flatten();
        let is_sound = self.results.iter().flatten().all(|&result| is_finite(result))
            && steps.clone().all(|&node| self.graph.nodes[node].operands().all(is_finite))
            && self.cases.iter().all(|case| case.results.iter().flatten().all(|x| x.is_finite()));
        if is_sound {
            return Ok(());
        }
        Err(GenerateError::NotFinite { robot: model.name().into(), function: self.function.to_string() })
    }

    /// Operations by kind.
    pub(crate) fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for &node in self.plan.parts.iter().flatten() {
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
pub(crate) struct Counts {
    pub(crate) additions: usize,
    pub(crate) multiplications: usize,
    pub(crate) fused: usize,
    pub(crate) divisions: usize,
    pub(crate) roots: usize,
    pub(crate) sines: usize,
}

/// Refuses to invert a singular M, as it is in a random state.
fn check_mass(function: &Function, model: &Model) -> Result<(), GenerateError> {
    let RandomState { q, .. } = random_state(model, &mut SplitMix64::new(1));
    match model.check_rank(&q) {
        Err(MotionError::SingularMass(cause)) if function.inverts_mass() => {
            Err(GenerateError::Singular { robot: model.name().into(), function: function.to_string(), cause })
        }
        _ => Ok(()),
    }
}

/// What a sine of the last digit's doubt can change: ten times what the other sine changes, and a few roundings.
fn doubt(arithmetic: Arithmetic, results: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let epsilon = if arithmetic.precision.bytes() == 8 { f64::EPSILON } else { f64::from(f32::EPSILON) };
    let pairs = results.iter().flatten().zip(other.iter().flatten());
    pairs.fold(0.0_f64, |most, (x, y)| most.max(10.0 * (x - y).abs() + 16.0 * epsilon * x.abs()))
}

/// Letters, digits and underscores.
pub(crate) fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let text: String = name.chars().map(plain).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) || text.is_empty() {
        format!("robot_{text}")
    } else {
        text
    }
}

/// The name in generated code, after the robot's.
pub(crate) fn symbol(function: &Function) -> String {
    match function.frame() {
        Some(frame) => format!("{}_{}", function.stem(), identifier(frame)),
        None => function.stem().into(),
    }
}

/// Arguments of random states, in the arithmetic's precision, always the same.
fn random_arguments(
    function: &Function,
    model: &Model,
    arithmetic: Arithmetic,
    states: usize,
) -> Vec<Vec<Vec<f64>>> {
    let mut random = SplitMix64::new(2026);
    let mut state = || {
        let RandomState { q, v, a, tau } = random_state(model, &mut random);
        let cotangent: Vec<f64> = v.iter().map(|_| random.uniform(-1.0, 1.0)).collect();
        let h = if function.integrator().is_some() { vec![random.uniform(1e-4, 1e-2)] } else { Vec::new() };
        let named = |name: &str| match name {
            "q" => &q,
            "v" => &v,
            "a" => &a,
            "tau" => &tau,
            "h" => &h,
            _ => &cotangent,
        };
        let rounded = |x: &f64| arithmetic.precision.round(*x);
        let arguments = function.arguments().iter();
        arguments.map(|(name, ..)| named(name).iter().map(rounded).collect()).collect()
    };
    (0..states).map(|_| state()).collect()
}

#[cfg(test)]
mod interpreter;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) use interpreter::interpret;

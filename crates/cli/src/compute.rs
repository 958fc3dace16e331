//! `dynamics compute`: the terms of the equation of motion for states read as JSON lines.

use std::io::{BufRead, BufReader, BufWriter, ErrorKind, Write};
use std::process::ExitCode;

use robot_dynamics::json::{Object, StateLine, Value};
use robot_dynamics::model::{FrameId, Model, Workspace};
use robot_dynamics::quantity::{Input, Inputs, Quantity, QuantityMemory, ResultShape};
use robot_dynamics::text::json;

use crate::failure::{CommandResult, Context, Failure};
use crate::joint_values::UNIT_TOLERANCE;
use crate::output::print_line;
use crate::robot_file::RobotFile;
use crate::singular_poses::advice;
use crate::table::count;

/// Compute M, C, g, torques and accelerations for states read as JSON lines.
///
/// Reads one state per line from standard input, {"q":[..],"v":[..],"a":[..],"tau":[..]}, and writes one
/// result per line. q and v have the order that `dynamics inspect` shows. A floating base has q = [x y z, qx
/// qy qz qw] and v = [linear, angular] in the base frame. If the line has "a", the result has
/// "inverse_dynamics" = M a + C v + g. If it has "tau", the result has "forward_dynamics" = M⁻¹(tau − C v −
/// g). If M is singular, it has "forward_dynamics_error" instead, with the joints that move no inertia.
/// --terms selects other terms.
///
/// An invalid line gives {"error":..,"line":..}, and the next line is read. The exit code is then 1. A
/// quaternion whose length is within 1e-3 of 1 is normalised, with a note for the first one.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Include joint damping and friction: added in inverse_dynamics, subtracted in forward_dynamics.
    #[arg(long)]
    dissipation: bool,
    /// Terms to compute, in this order. Terms that need "a" or "tau" are left out on lines without it.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = quantity_parser())]
    #[arg(default_values = DEFAULT.map(Quantity::name))]
    terms: Vec<String>,
    /// Frame or link of Jacobians.
    #[arg(long, value_name = "NAME")]
    frame: Option<String>,
}

/// Suffix of a term's name if the term has no value in a state.
const NO_VALUE: &str = "_error";

/// Default terms.
const DEFAULT: [Quantity; 8] = [
    Quantity::MassMatrix,
    Quantity::Bias,
    Quantity::Gravity,
    Quantity::CoriolisMatrix,
    Quantity::InverseDynamics,
    Quantity::ForwardDynamics,
    Quantity::KineticEnergy,
    Quantity::PotentialEnergy,
];

fn quantity_parser() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(Quantity::ALL.map(Quantity::name))
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_to_compute()?.model;
    let mut computer = Computer::new(&model, arguments)?;
    let mut input = BufReader::new(std::io::stdin());
    let mut output = BufWriter::new(std::io::stdout());
    let (mut lines, mut bad, mut singular) = (0, 0, 0);
    let mut bytes = Vec::new();
    loop {
        // A program that waits for each answer gets it at once; a long input is not flushed line by line.
        if input.buffer().is_empty() && !written(output.flush())? {
            return Ok(ExitCode::SUCCESS);
        }
        bytes.clear();
        if input.read_until(b'\n', &mut bytes).context("cannot read standard input")? == 0 {
            break;
        }
        lines += 1;
        if bytes.trim_ascii().is_empty() {
            continue;
        }
        let answer = match StateLine::parse(&bytes).and_then(|mut state| {
            computer.normalize(&mut state.q, lines);
            computer.terms(&state, lines)
        }) {
            Ok(terms) => {
                singular += usize::from(terms.0.iter().any(|(name, _)| name.ends_with(NO_VALUE)));
                terms
            }
            Err(error) => {
                bad += 1;
                Object(vec![("error".into(), Value::Text(error)), ("line".into(), Value::Count(lines))])
            }
        };
        if !written(writeln!(output, "{}", json(&answer.to_line())))? {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let lines = count(lines, "line");
    let mut failures = Vec::new();
    if bad > 0 {
        failures
            .push(format!("{bad} of {lines} are invalid; the output has an object with \"error\" for each"));
    }
    if singular > 0 {
        failures.push(format!(
            "{singular} of {lines} ask for accelerations where the mass matrix is singular; the output has \
             \"{name}_error\" instead of \"{name}\" for each",
            name = computer.first_inverse()
        ));
    }
    if failures.is_empty() { Ok(ExitCode::SUCCESS) } else { Err(Failure::new(failures.join("; "))) }
}

/// Whether the output still has a reader. A closed pipe, such as that of `head`, is not an error.
fn written(result: std::io::Result<()>) -> Result<bool, Failure> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        result => result.map(|()| true).context("cannot write to standard output"),
    }
}

struct Computer<'a> {
    model: &'a Model,
    workspace: Workspace,
    memory: QuantityMemory,
    quantities: Vec<Quantity>,
    frames: Vec<FrameId>,
    dissipation: bool,
    /// Whether the note on normalised quaternions was printed.
    has_noted: bool,
}

/// Largest deviation of a quaternion's length from 1 that rounded digits explain; a larger one is an error.
const NORMALIZATION_TOLERANCE: f64 = 1e-3;

impl<'a> Computer<'a> {
    fn new(model: &'a Model, arguments: &Arguments) -> Result<Self, Failure> {
        let quantities: Vec<_> = arguments.terms.iter().filter_map(|name| Quantity::named(name)).collect();
        let frames = match &arguments.frame {
            Some(name) => vec![model.frame_named(name).map_err(Failure::new)?],
            None => Vec::new(),
        };
        if let Some(quantity) = quantities.iter().find(|quantity| quantity.reads(Input::Frame))
            && frames.is_empty()
        {
            return Err(Failure::new(format!("{} needs a frame; name it with --frame", quantity.name())));
        }
        if let Some(quantity) = quantities.iter().find(|quantity| is_derivative(**quantity))
            && arguments.dissipation
        {
            let name = quantity.name();
            return Err(Failure::new(format!(
                "{name} does not include damping and friction; omit --dissipation"
            )));
        }
        let (workspace, memory) = (Workspace::new(model), QuantityMemory::new(model));
        let dissipation = arguments.dissipation;
        Ok(Self { model, workspace, memory, quantities, frames, dissipation, has_noted: false })
    }

    /// The first requested term that needs M⁻¹.
    fn first_inverse(&self) -> &'static str {
        self.quantities.iter().find(|quantity| quantity.inverts_mass()).map_or("", |quantity| quantity.name())
    }

    /// Normalises quaternions whose length is close to 1, with a note for the first. Other errors in q are
    /// left to the check.
    fn normalize(&mut self, q: &mut [f64], line: usize) {
        if q.len() != self.model.nq() {
            return;
        }
        for joint in self.model.joints().iter().filter(|joint| joint.nq > joint.nv) {
            let first = joint.q_index + joint.nq - 4;
            let quaternion = &mut q[first..first + 4];
            let norm = quaternion.iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
            if !(UNIT_TOLERANCE..=NORMALIZATION_TOLERANCE).contains(&(norm - 1.0).abs()) {
                continue;
            }
            for x in quaternion {
                *x /= norm;
            }
            if !std::mem::replace(&mut self.has_noted, true) {
                print_line(format_args!(
                    "note: line {line}: q[{first}..{}] (joint `{}`) is a quaternion x y z w of length {norm}; quaternions \
                     within {NORMALIZATION_TOLERANCE} of unit length are normalised",
                    first + 4,
                    joint.name
                ));
            }
        }
    }

    fn terms(&mut self, state: &StateLine, line: usize) -> Result<Object, String> {
        let Self { model, workspace, memory, quantities, frames, dissipation, .. } = self;
        let n = model.nv();
        let StateLine { q, v, a, tau, .. } = state;
        robot_dynamics::model::check_configuration(model, q).map_err(|error| error.to_string())?;
        check("v", v, n)?;
        for (name, values) in [("a", a), ("tau", tau)] {
            values.as_ref().map_or(Ok(()), |values| check(name, values, n))?;
        }
        let mut loss = vec![0.0; n];
        if *dissipation {
            robot_dynamics::algorithms::dissipation(model, v, &mut loss);
        }
        let net =
            tau.as_ref().map(|tau| tau.iter().zip(&loss).map(|(tau, loss)| tau - loss).collect::<Vec<_>>());
        let inputs = Inputs {
            q,
            v,
            a: a.as_deref().unwrap_or_default(),
            tau: net.as_deref().unwrap_or_default(),
            frames,
        };
        let mut terms = Object(Vec::new());
        for &quantity in &*quantities {
            let lacks = (quantity.reads(Input::Acceleration) && a.is_none())
                || (quantity.reads(Input::Force) && tau.is_none());
            if lacks {
                continue;
            }
            if quantity.inverts_mass()
                && let Err(mass) = robot_dynamics::algorithms::check_rank(model, workspace, q)
            {
                let joints = mass.joints().into_iter().map(Into::into).collect();
                let none = Object(vec![
                    ("message".into(), Value::Text(advice(&mass, model))),
                    ("joints".into(), Value::Texts(joints)),
                    ("line".into(), Value::Count(line)),
                ]);
                terms.0.push((format!("{}{NO_VALUE}", quantity.name()).into(), Value::Object(none)));
                continue;
            }
            quantity.compute(model, workspace, &inputs, memory);
            let results = memory.results(quantity);
            // JSON has no number for infinities and NaN, and a state that overflows has no result.
            if !results.iter().copied().flatten().all(|x| x.is_finite()) {
                return Err(format!(
                    "{} is not finite; the numbers of the state are too large",
                    quantity.name()
                ));
            }
            let mut value = value(model, quantity, results);
            if quantity == Quantity::InverseDynamics
                && let Value::Numbers(force) = &mut value
            {
                force.iter_mut().zip(&loss).for_each(|(force, loss)| *force += loss);
            }
            terms.0.push((quantity.name().into(), value));
        }
        Ok(terms)
    }
}

/// Whether the quantity is a derivative by v, to which damping would contribute.
fn is_derivative(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::InverseDynamicsDerivatives | Quantity::ForwardDynamicsDerivatives)
}

/// The results of a quantity as JSON values.
fn value(model: &Model, quantity: Quantity, results: [&[f64]; 3]) -> Value {
    let rows = |numbers: &[f64], width: usize| numbers.chunks(width.max(1)).map(<[f64]>::to_vec).collect();
    let one = |shape: ResultShape, numbers: &[f64]| match shape {
        ResultShape::Scalar => Value::Number(numbers[0]),
        ResultShape::Square | ResultShape::Rows(_) => Value::Rows(rows(numbers, model.nv())),
        ResultShape::Poses => {
            let frame = |pose: &[f64]| {
                Value::Object(Object(vec![
                    ("rotation".into(), Value::Rows(rows(&pose[..9], 3))),
                    ("translation".into(), Value::Numbers(pose[9..].to_vec())),
                ]))
            };
            let names = model.frames().iter().map(|frame| frame.name.clone().into());
            Value::Object(Object(names.zip(numbers.chunks(12).map(frame)).collect()))
        }
        _ => Value::Numbers(numbers.to_vec()),
    };
    match quantity.results() {
        [result] => one(result.shape, results[0]),
        several => {
            let values = several.iter().zip(results);
            Value::Object(Object(
                values.map(|(result, numbers)| (result.name.into(), one(result.shape, numbers))).collect(),
            ))
        }
    }
}

fn check(name: &str, values: &[f64], expected: usize) -> Result<(), String> {
    if values.len() != expected {
        return Err(format!("{name} has {} numbers instead of {expected}", values.len()));
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(format!("{name}[{index}] is not finite")),
        None => Ok(()),
    }
}

//! `dynamics compute`: the terms of the equation of motion for states read as JSON lines.

use std::io::{BufRead, BufReader, BufWriter, ErrorKind, Write};
use std::process::ExitCode;

use multibody::{Model, Workspace};
use serde::{Deserialize, Serialize};

use crate::failure::{Context, Failure, Outcome};
use crate::inspect::count;
use crate::joint_values::UNIT;
use crate::robot_file::RobotFile;
use crate::singular_poses::advice;

/// Compute M, C, g, torques and accelerations for states read as JSON lines.
///
/// Reads one state a line from standard input, {"q":[..],"v":[..],"a":[..],"tau":[..]}, and writes one
/// result a line. q and v are in the order that `dynamics inspect` shows; a floating base is q = [x y z, qx qy qz qw],
/// v = [linear, angular] in the base frame. With "a" the result has "inverse_dynamics"
/// = M a + C v + g, with "tau" it has "forward_dynamics" = M⁻¹(tau − C v − g), or, where M is
/// singular, "forward_dynamics_error" with the joints that move no inertia. A line that cannot be used gives
/// {"error":..,"line":..} and the stream goes on; the exit code is 1 if there was any such line. A quaternion of
/// a length within 1e-3 of 1 is normalised, which is said once.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Count the joints' damping and friction: added to inverse_dynamics, taken off in forward_dynamics.
    #[arg(long)]
    dissipation: bool,
}

/// A state as it comes in.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Option<Vec<f64>>,
    tau: Option<Vec<f64>>,
}

/// The terms of the equation of motion in that state.
#[derive(Serialize)]
struct Terms {
    mass_matrix: Vec<Vec<f64>>,
    /// C v + g.
    bias: Vec<f64>,
    gravity: Vec<f64>,
    coriolis_matrix: Vec<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inverse_dynamics: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    forward_dynamics: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    forward_dynamics_error: Option<NoAcceleration>,
    kinetic_energy: f64,
    potential_energy: f64,
}

/// Why no acceleration follows from "tau" in that state.
#[derive(Serialize)]
struct NoAcceleration {
    message: String,
    /// The joints that move no inertia.
    joints: Vec<String>,
    line: usize,
}

/// A line that could not be used.
#[derive(Serialize)]
struct BadLine {
    error: String,
    line: usize,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let model = arguments.robot.load_to_compute()?;
    let mut computer = Computer::new(&model, arguments.dissipation);
    let mut input = BufReader::new(std::io::stdin());
    let mut output = BufWriter::new(std::io::stdout());
    let (mut lines, mut bad, mut singular) = (0, 0, 0);
    let mut bytes = Vec::new();
    loop {
        // Whoever waits for an answer before the next question gets it; a long file is not flushed by line.
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
        let text = match parse(&bytes).and_then(|mut state| {
            computer.normalize(&mut state.q, lines);
            computer.terms(&state, lines)
        }) {
            Ok(terms) => {
                singular += usize::from(terms.forward_dynamics_error.is_some());
                serde_json::to_string(&terms)
            }
            Err(error) => {
                bad += 1;
                serde_json::to_string(&BadLine { error, line: lines })
            }
        };
        if !written(writeln!(output, "{}", text.map_err(Failure::new)?))? {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let lines = count(lines, "line");
    let mut failures = Vec::new();
    if bad > 0 {
        failures.push(format!(
            "{bad} of {lines} could not be used; each has an object with \"error\" in the output"
        ));
    }
    if singular > 0 {
        failures.push(format!(
            "{singular} of {lines} asked for accelerations where the mass matrix is singular; each has \
             \"forward_dynamics_error\" in place of \"forward_dynamics\""
        ));
    }
    if failures.is_empty() { Ok(ExitCode::SUCCESS) } else { Err(Failure::new(failures.join("; "))) }
}

/// Whether the output still has a reader: one that has seen enough (`head`, for one) is no failure.
fn written(result: std::io::Result<()>) -> Result<bool, Failure> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        result => result.map(|()| true).context("cannot write to standard output"),
    }
}

fn parse(line: &[u8]) -> Result<State, String> {
    let wanted = "expected {\"q\":[..],\"v\":[..]} with \"a\" and \"tau\" optional";
    let line = line.trim_ascii();
    if line.first() != Some(&b'{') {
        return Err(format!("{wanted}; the line is no JSON object"));
    }
    // The text is one line, whose number in the stream is given beside the error.
    serde_json::from_slice(line)
        .map_err(|error| format!("{wanted}: {}", error.to_string().replace("line 1 column", "column")))
}

struct Computer<'a> {
    model: &'a Model,
    workspace: Workspace,
    dissipation: bool,
    /// Whether it was said that a quaternion was normalised.
    has_noted: bool,
}

/// How far from 1 the length of a quaternion may be, as of rounded digits; beyond, it is more likely a mistake.
const NEARLY_UNIT: f64 = 1e-3;

impl<'a> Computer<'a> {
    fn new(model: &'a Model, dissipation: bool) -> Self {
        Self { model, workspace: Workspace::new(model), dissipation, has_noted: false }
    }

    /// Scales quaternions that are nearly of unit length to it, and says so the first time. Other faults of q are left
    /// to the check.
    fn normalize(&mut self, q: &mut [f64], line: usize) {
        if q.len() != self.model.nq() {
            return;
        }
        for joint in self.model.joints().iter().filter(|joint| joint.nq > joint.nv) {
            let first = joint.q_index + joint.nq - 4;
            let quaternion = &mut q[first..first + 4];
            let norm = quaternion.iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
            if !(UNIT..=NEARLY_UNIT).contains(&(norm - 1.0).abs()) {
                continue;
            }
            for x in quaternion {
                *x /= norm;
            }
            if !std::mem::replace(&mut self.has_noted, true) {
                eprintln!(
                    "note: line {line}: q[{first}..{}] (joint `{}`) is a quaternion x y z w of length {norm}; it is \
                     normalised, and so is every other within {NEARLY_UNIT} of 1",
                    first + 4,
                    joint.name
                );
            }
        }
    }

    fn terms(&mut self, state: &State, line: usize) -> Result<Terms, String> {
        let (model, n) = (self.model, self.model.nv());
        let State { q, v, a, tau } = state;
        multibody::check_configuration(model, q).map_err(|error| error.to_string())?;
        check("v", v, n)?;
        let workspace = &mut self.workspace;
        let vector = |compute: &mut dyn FnMut(&mut [f64])| {
            let mut out = vec![0.0; n];
            compute(&mut out);
            out
        };
        let matrix = |compute: &mut dyn FnMut(&mut [f64])| {
            let mut out = vec![0.0; n * n];
            compute(&mut out);
            out.chunks(n.max(1)).map(<[f64]>::to_vec).collect::<Vec<_>>()
        };
        let loss = vector(&mut |out| {
            if self.dissipation {
                multibody::dissipation(model, v, out);
            }
        });
        let inverse_dynamics = match a {
            Some(a) => {
                check("a", a, n)?;
                let mut force =
                    vector(&mut |out| multibody::inverse_dynamics(model, workspace, q, v, a, out));
                force.iter_mut().zip(&loss).for_each(|(force, loss)| *force += loss);
                Some(force)
            }
            None => None,
        };
        let (mut forward_dynamics, mut forward_dynamics_error) = (None, None);
        if let Some(tau) = tau {
            check("tau", tau, n)?;
            let net: Vec<f64> = tau.iter().zip(&loss).map(|(tau, loss)| tau - loss).collect();
            match multibody::check_rank(model, workspace, q) {
                Ok(()) => {
                    let solve = &mut |out: &mut [f64]| {
                        multibody::forward_dynamics(model, workspace, q, v, &net, out);
                    };
                    forward_dynamics = Some(vector(solve));
                }
                Err(mass) => {
                    let joints = mass.joints().into_iter().map(Into::into).collect();
                    let message = advice(&mass, model);
                    forward_dynamics_error = Some(NoAcceleration { message, joints, line });
                }
            }
        }
        let terms = Terms {
            mass_matrix: matrix(&mut |out| multibody::mass_matrix(model, workspace, q, out)),
            bias: vector(&mut |out| multibody::bias(model, workspace, q, v, out)),
            gravity: vector(&mut |out| multibody::gravity(model, workspace, q, out)),
            coriolis_matrix: matrix(&mut |out| multibody::coriolis_matrix(model, workspace, q, v, out)),
            inverse_dynamics,
            forward_dynamics,
            forward_dynamics_error,
            kinetic_energy: multibody::kinetic_energy(model, workspace, q, v),
            potential_energy: multibody::potential_energy(model, workspace, q),
        };
        terms.check()?;
        Ok(terms)
    }
}

impl Terms {
    /// JSON has no number for what is not finite, and a state that overflows has no answer.
    fn check(&self) -> Result<(), String> {
        let rows = |matrix: &[Vec<f64>]| matrix.iter().flatten().all(|x| x.is_finite());
        let row = |vector: &[f64]| vector.iter().all(|x| x.is_finite());
        let terms = [
            ("mass_matrix", rows(&self.mass_matrix)),
            ("bias", row(&self.bias)),
            ("gravity", row(&self.gravity)),
            ("coriolis_matrix", rows(&self.coriolis_matrix)),
            ("inverse_dynamics", self.inverse_dynamics.as_deref().is_none_or(row)),
            ("kinetic_energy", self.kinetic_energy.is_finite()),
            ("potential_energy", self.potential_energy.is_finite()),
        ];
        if let Some((term, _)) = terms.iter().find(|(_, is_finite)| !is_finite) {
            return Err(format!("{term} is not finite: the state's numbers are too large"));
        }
        if !self.forward_dynamics.as_deref().is_none_or(row) {
            return Err("forward_dynamics is not finite: the state's numbers are too large".into());
        }
        Ok(())
    }
}

fn check(name: &str, values: &[f64], expected: usize) -> Result<(), String> {
    if values.len() != expected {
        return Err(format!("{name} has {} numbers, the robot needs {expected}", values.len()));
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(format!("{name}[{index}] is not finite")),
        None => Ok(()),
    }
}

//! The generation of code: programs are traced, laid out and written.

use std::collections::BTreeSet;

use robot_dynamics::model::Model;
use robot_dynamics_expression::{Precision, Sine};

use crate::generated_files::{GeneratedFile, GeneratedFiles};
use crate::layout::Layout;
use crate::program::Program;
use crate::writers::{self, Context};
use crate::{GenerateError, Request, Target, heading, names, stages};

/// Generates the functions for one robot. The same request gives the same bytes on every machine.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_generate::{Function, Request, Target, generate};
/// let model = Model::new(pendulum(2.0, 0.5))?; // 2 kg on 0.5 m: g(q) = −m g l cos q = −9.81 cos q
/// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
/// let code = &generated.file("pendulum.c").ok_or("no code")?.text;
/// assert!(code.contains("* 9.81") || code.contains("9.81 *"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`GenerateError`]: a missing frame, a robot without moving joints, a singular mass matrix, unsupported
/// numbers.
pub fn generate(model: &Model, request: &Request) -> Result<GeneratedFiles, GenerateError> {
    Ok(prepare(model, request)?.written(model, request))
}

/// Traces and lays out the functions of a request.
pub(crate) fn prepare(model: &Model, request: &Request) -> Result<TracedPrograms, GenerateError> {
    if model.nv() == 0 {
        return Err(GenerateError::Motionless { robot: model.name().into() });
    }
    let precision = request.arithmetic.precision;
    if request.target == Target::Wgsl && precision == Precision::Double {
        let remedy = "request single precision (`--single`)";
        return Err(GenerateError::NotInTarget { target: "WGSL", what: "double precision", remedy });
    }
    if request.target == Target::Wgsl && request.arithmetic.sine == Sine::Platform {
        let remedy = "its sine has errors up to 2^-11; use the code's own sine";
        return Err(GenerateError::NotInTarget { target: "WGSL", what: "the platform's sine", remedy });
    }
    if request.target == Target::Casadi && precision == Precision::Single {
        let remedy = "request double precision";
        return Err(GenerateError::NotInTarget { target: "CasADi", what: "single precision", remedy });
    }
    if request.lanes && request.target != Target::Rust {
        let (target, remedy) = (request.target.name(), "they require the target rust");
        return Err(GenerateError::NotInTarget { target, what: "lanes", remedy });
    }
    if request.lanes && request.arithmetic.sine == Sine::Platform {
        let remedy = "it computes one angle at a time; use the code's own sine";
        return Err(GenerateError::NotInTarget {
            target: "Rust over lanes",
            what: "the platform's sine",
            remedy,
        });
    }
    let states = request.states.max(1);
    let programs: Vec<Program> = (request.functions.iter())
        .map(|function| {
            // Devices loop over sweeps. Other targets write them as one expression.
            let has_stages = matches!(request.target, Target::Cuda | Target::Wgsl);
            let staged =
                if has_stages { stages::staged(function, model, request.arithmetic, states) } else { None };
            staged.unwrap_or_else(|| Program::new(function, model, request.arithmetic, states))
        })
        .collect::<Result<_, _>>()?;
    let mut symbols = BTreeSet::new();
    for program in &programs {
        if !symbols.insert(&program.symbol) {
            return Err(GenerateError::SameName { symbol: program.symbol.clone() });
        }
    }
    let layouts = programs.iter().map(|program| writers::layout(request, program)).collect();
    let (name, _) = names::of_robot(request.target, request.name.as_deref().unwrap_or(model.name()));
    Ok(TracedPrograms { name, programs, layouts })
}

/// Traced functions with their layouts, and the name of the files.
pub(crate) struct TracedPrograms {
    pub(crate) name: String,
    pub(crate) programs: Vec<Program>,
    pub(crate) layouts: Vec<Layout>,
}

impl TracedPrograms {
    pub(crate) fn written(&self, model: &Model, request: &Request) -> GeneratedFiles {
        let Self { name, programs, layouts } = self;
        let context = Context { model, request, name, programs, layouts };
        let mut files = writers::files(&context);
        files.push(GeneratedFile::new("REPORT.md", heading::report(&context)));
        files.sort_by(|a, b| a.name.cmp(&b.name));
        GeneratedFiles { files, renamed: heading::renamed(model, request) }
    }
}

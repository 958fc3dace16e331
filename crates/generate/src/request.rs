//! Requests for generated code, and the generated files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use robot_dynamics::model::Model;
use robot_dynamics::output::{NotWritten, write_files};
use robot_dynamics_expression::{Arithmetic, Precision, Sine};

use crate::layout::Layout;
use crate::program::Program;
use crate::{Function, GenerateError, Target, heading, names, target};

/// A request for generated code.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Request {
    /// The language and the caller.
    pub target: Target,
    /// The functions.
    pub functions: Vec<Function>,
    /// The arithmetic.
    pub arithmetic: Arithmetic,
    /// In Rust, whether to add each function for many states at once, over the vector registers of the
    /// machine that runs it.
    pub lanes: bool,
    /// Whether to write straight code without loops for bodies that are alike. C, CasADi and Rust have loops
    /// where these make the code shorter.
    pub straight: bool,
    /// The name of files and functions; the robot's by default.
    pub name: Option<String>,
    /// The number of random states, always the same, in which the generated test compares the code with the
    /// library's values.
    pub states: usize,
    /// The command or program that makes the request, for the first line of each file.
    pub command: Option<String>,
}

impl Request {
    /// A request for these functions in double precision, compared with the library's values in five states.
    ///
    /// ```
    /// use robot_dynamics_generate::{Function, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::InverseDynamics]);
    /// assert_eq!(request.states, 5);
    /// ```
    pub fn new(target: Target, functions: Vec<Function>) -> Self {
        Self {
            target,
            functions,
            arithmetic: Arithmetic::default(),
            lanes: false,
            straight: false,
            name: None,
            states: 5,
            command: None,
        }
    }

    /// Sets the arithmetic.
    ///
    /// ```
    /// use robot_dynamics_generate::{Arithmetic, Function, Precision, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::Gravity]);
    /// let request = request.with_arithmetic(Arithmetic::new(Precision::Single));
    /// assert_eq!(request.arithmetic.precision, Precision::Single);
    /// ```
    pub fn with_arithmetic(mut self, arithmetic: Arithmetic) -> Self {
        self.arithmetic = arithmetic;
        self
    }

    /// Adds each function for many states at once: in Rust, in a module `lanes` that needs the crate
    /// `robot-dynamics-number`.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_generate::{Function, Request, Target, generate};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let request = Request::new(Target::Rust, vec![Function::Gravity]).with_lanes();
    /// let generated = generate(&model, &request)?;
    /// let code = &generated.file("src/pendulum.rs").ok_or("no code")?.text;
    /// assert!(code.contains("pub fn gravity(limit: InstructionSet, q: &[f64], gravity: &mut [f64])"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_lanes(mut self) -> Self {
        self.lanes = true;
        self
    }

    /// Writes straight code without loops, even for many bodies that are alike.
    ///
    /// ```
    /// use robot_dynamics_generate::{Function, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::Gravity]);
    /// assert!(!request.straight && request.with_straight().straight);
    /// ```
    pub fn with_straight(mut self) -> Self {
        self.straight = true;
        self
    }

    /// Sets the name of files and functions.
    ///
    /// ```
    /// use robot_dynamics_generate::{Function, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::Gravity]).with_name("arm");
    /// assert_eq!(request.name.as_deref(), Some("arm"));
    /// ```
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    pub(crate) fn command(&self) -> &str {
        self.command.as_deref().unwrap_or("the crate robot-dynamics-generate")
    }
}

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GeneratedFile {
    /// Its name, with slashes between folders.
    pub name: String,
    /// Its contents.
    pub text: String,
}

impl GeneratedFile {
    pub(crate) fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text }
    }
}

/// All files of a request: the code, a test that compares it with the library's values, a build file, and a
/// report.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Generated {
    /// The files, in the order of their names.
    pub files: Vec<GeneratedFile>,
    /// If files and functions cannot have the requested name: their name, and the reason.
    pub renamed: Option<String>,
}

impl Generated {
    /// The file of this name.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_generate::{Function, Request, Target, generate};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.file("pendulum.h").is_some_and(|file| file.text.contains("pendulum_gravity")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn file(&self, name: &str) -> Option<&GeneratedFile> {
        self.files.iter().find(|file| file.name == name)
    }

    /// Writes all files into a folder, which is created if it is missing: all of them or none. Files that
    /// were generated are replaced; if another file has the same name, nothing is written.
    ///
    /// ```no_run
    /// # use robot_dynamics_generate::{Function, Request, Target, generate};
    /// # let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// generated.write("pendulum")?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`GenerateError::Foreign`] and [`GenerateError::File`].
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), GenerateError> {
        let paths = self.paths(folder);
        for path in &paths {
            match fs::read(path) {
                Ok(bytes) => {
                    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(2000)]).into_owned();
                    if !head.contains(heading::MARK) {
                        return Err(GenerateError::Foreign { path: path.clone() });
                    }
                }
                Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => {}
                Err(cause) => return Err(GenerateError::File { path: path.clone(), cause }),
            }
        }
        let files: Vec<_> = paths.into_iter().zip(self.files.iter().map(|file| &file.text)).collect();
        write_files(&files).map_err(|NotWritten { path, cause, .. }| GenerateError::File { path, cause })
    }

    /// The paths of all files in a folder, in their order.
    ///
    /// ```
    /// use robot_dynamics_generate::{Function, Request, Target, generate};
    /// let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.paths("arm").contains(&std::path::Path::new("arm").join("pendulum.h")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn paths(&self, folder: impl AsRef<Path>) -> Vec<PathBuf> {
        self.files.iter().map(|file| folder.as_ref().join(&file.name)).collect()
    }
}

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
pub fn generate(model: &Model, request: &Request) -> Result<Generated, GenerateError> {
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
        .map(|function| Program::new(function, model, request.arithmetic, states))
        .collect::<Result<_, _>>()?;
    let mut symbols = BTreeSet::new();
    for program in &programs {
        if !symbols.insert(&program.symbol) {
            return Err(GenerateError::SameName { symbol: program.symbol.clone() });
        }
    }
    let layouts = programs.iter().map(|program| target::layout(request, program)).collect();
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
    pub(crate) fn written(&self, model: &Model, request: &Request) -> Generated {
        let Self { name, programs, layouts } = self;
        let context = target::Context { model, request, name, programs, layouts };
        let mut files = target::files(&context);
        files.push(GeneratedFile::new("REPORT.md", heading::report(&context)));
        files.sort_by(|a, b| a.name.cmp(&b.name));
        Generated { files, renamed: heading::renamed(model, request) }
    }
}

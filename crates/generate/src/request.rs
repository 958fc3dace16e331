//! What is asked for, and what comes of it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use expression::{Arithmetic, Precision, Sine};
use multibody::Model;
use robot_dynamics::output::{NotWritten, write_files};

use crate::layout::Layout;
use crate::program::Program;
use crate::{Function, GenerateError, Target, heading, names, target};

/// What to generate.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Request {
    /// In which language, for which caller.
    pub target: Target,
    /// Which functions.
    pub functions: Vec<Function>,
    /// How the code computes.
    pub arithmetic: Arithmetic,
    /// In Rust, whether the functions come for many states at once too, over the vector registers of the machine that they run on.
    pub lanes: bool,
    /// Whether loops for bodies that are alike are left out, which C, CasADi and Rust have where they are shorter.
    pub straight: bool,
    /// The name of files and functions; the robot's by default.
    pub name: Option<String>,
    /// Random states, always the same, for which the generated test holds the code to the library's values.
    pub states: usize,
    /// The command or program that asked, for the first line of each file.
    pub command: Option<String>,
}

impl Request {
    /// These functions in double precision, held to the library's values in five states.
    ///
    /// ```
    /// use generate::{Function, Request, Target};
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

    /// With this arithmetic.
    ///
    /// ```
    /// use generate::{Arithmetic, Function, Precision, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::Gravity]);
    /// let request = request.with_arithmetic(Arithmetic::new(Precision::Single));
    /// assert_eq!(request.arithmetic.precision, Precision::Single);
    /// ```
    pub fn with_arithmetic(mut self, arithmetic: Arithmetic) -> Self {
        self.arithmetic = arithmetic;
        self
    }

    /// With each function for many states at once, too: Rust, in a module `lanes` that needs the crate `robot-dynamics-number`.
    ///
    /// ```
    /// use generate::{Function, Request, Target, generate};
    /// use multibody::{Model, pendulum};
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

    /// Without loops: each operation is written where it is done, also those of many bodies that are alike.
    ///
    /// ```
    /// use generate::{Function, Request, Target};
    /// let request = Request::new(Target::C, vec![Function::Gravity]);
    /// assert!(!request.straight && request.with_straight().straight);
    /// ```
    pub fn with_straight(mut self) -> Self {
        self.straight = true;
        self
    }

    /// With this name for files and functions.
    ///
    /// ```
    /// use generate::{Function, Request, Target};
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
    /// Its name, with folders by slashes.
    pub name: String,
    /// What stands in it.
    pub text: String,
}

impl GeneratedFile {
    pub(crate) fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text }
    }
}

/// All files of a request: the code, a test that holds it to the library's values, what builds it, a report.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Generated {
    /// In the order of their names.
    pub files: Vec<GeneratedFile>,
    /// Where files and functions have another name than the one asked for, as the target cannot have that: which, and why.
    pub renamed: Option<String>,
}

impl Generated {
    /// The file of this name.
    ///
    /// ```
    /// use generate::{Function, Request, Target, generate};
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.file("pendulum.h").is_some_and(|file| file.text.contains("pendulum_gravity")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn file(&self, name: &str) -> Option<&GeneratedFile> {
        self.files.iter().find(|file| file.name == name)
    }

    /// Writes all files into a folder, which is made where it is missing: all of them or none. Files that were generated are
    /// replaced; where another file is in the way nothing is written.
    ///
    /// ```no_run
    /// # use generate::{Function, Request, Target, generate};
    /// # let model = multibody::Model::new(multibody::pendulum(2.0, 0.5))?;
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
    /// use generate::{Function, Request, Target, generate};
    /// let model = multibody::Model::new(multibody::pendulum(2.0, 0.5))?;
    /// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
    /// assert!(generated.paths("arm").contains(&std::path::Path::new("arm").join("pendulum.h")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn paths(&self, folder: impl AsRef<Path>) -> Vec<PathBuf> {
        self.files.iter().map(|file| folder.as_ref().join(&file.name)).collect()
    }
}

/// Generates the functions for one robot: the same request gives the same bytes, on every machine.
///
/// ```
/// use generate::{Function, Request, Target, generate};
/// use multibody::{Model, pendulum};
/// let model = Model::new(pendulum(2.0, 0.5))?; // 2 kg on 0.5 m: g(q) = −m g l cos q = −9.81 cos q
/// let generated = generate(&model, &Request::new(Target::C, vec![Function::Gravity]))?;
/// let code = &generated.file("pendulum.c").ok_or("no code")?.text;
/// assert!(code.contains("* 9.81") || code.contains("9.81 *"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`GenerateError`]: no such frame, a robot without moving joints, a singular mass matrix, numbers that the target lacks.
pub fn generate(model: &Model, request: &Request) -> Result<Generated, GenerateError> {
    Ok(prepare(model, request)?.written(model, request))
}

/// What [`generate`] writes, before it is written.
pub(crate) fn prepare(model: &Model, request: &Request) -> Result<Prepared, GenerateError> {
    if model.nv() == 0 {
        return Err(GenerateError::Motionless { robot: model.name().into() });
    }
    let precision = request.arithmetic.precision;
    if request.target == Target::Wgsl && precision == Precision::Double {
        let remedy = "ask for single precision (`--single`)";
        return Err(GenerateError::NotInTarget { target: "WGSL", what: "double precision", remedy });
    }
    if request.target == Target::Wgsl && request.arithmetic.sine == Sine::Platform {
        let remedy = "its own may be off by 2^-11; leave the code its own";
        return Err(GenerateError::NotInTarget { target: "WGSL", what: "exact sine", remedy });
    }
    if request.target == Target::Casadi && precision == Precision::Single {
        let remedy = "ask for double precision";
        return Err(GenerateError::NotInTarget { target: "CasADi", what: "single precision", remedy });
    }
    if request.lanes && request.target != Target::Rust {
        let (target, remedy) = (request.target.name(), "they are for the target rust");
        return Err(GenerateError::NotInTarget { target, what: "lanes", remedy });
    }
    if request.lanes && request.arithmetic.sine == Sine::Platform {
        let remedy = "the platform's takes one angle; leave the code its own";
        return Err(GenerateError::NotInTarget {
            target: "Rust over lanes",
            what: "platform's sine",
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
    Ok(Prepared { name, programs, layouts })
}

/// Traced and arranged functions, and what files are called.
pub(crate) struct Prepared {
    pub(crate) name: String,
    pub(crate) programs: Vec<Program>,
    pub(crate) layouts: Vec<Layout>,
}

impl Prepared {
    pub(crate) fn written(&self, model: &Model, request: &Request) -> Generated {
        let Self { name, programs, layouts } = self;
        let context = target::Context { model, request, name, programs, layouts };
        let mut files = target::files(&context);
        files.push(GeneratedFile::new("REPORT.md", heading::report(&context)));
        files.sort_by(|a, b| a.name.cmp(&b.name));
        Generated { files, renamed: heading::renamed(model, request) }
    }
}

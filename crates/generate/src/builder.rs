//! Code generation in build scripts: from a robot's file to a module that can be included.

use std::path::{Path, PathBuf};

use robot_dynamics_expression::Arithmetic;

use crate::{Function, GenerateError, GeneratedFiles, Request, Target, generate};

/// Generates code from a robot's file; in a `build.rs`, Rust for the crate that is built.
///
/// ```no_run
/// // build.rs
/// use robot_dynamics_generate::{Builder, Function};
/// fn main() -> Result<(), robot_dynamics_generate::GenerateError> {
///     Builder::new("robots/panda.urdf")
///         .functions([Function::InverseDynamics, Function::MassMatrix])
///         .write_module("panda.rs")
/// }
/// // src/lib.rs
/// // mod panda { include!(concat!(env!("OUT_DIR"), "/panda.rs")); }
/// ```
#[derive(Clone, Debug)]
pub struct Builder {
    file: PathBuf,
    floating: bool,
    functions: Vec<Function>,
    arithmetic: Arithmetic,
    lanes: bool,
    straight: bool,
}

impl Builder {
    /// A builder for this file, URDF or MJCF. The defaults are inverse and forward dynamics and M in double
    /// precision.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    /// use robot_dynamics_generate::{Builder, Target};
    /// let generated = Builder::new(file).generate(Target::C)?;
    /// assert!(generated.file("two_r.h").is_some_and(|file| file.text.contains("two_r_forward_dynamics")));
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            floating: false,
            functions: Request::DEFAULT_FUNCTIONS.into(),
            arithmetic: Arithmetic::default(),
            lanes: false,
            straight: false,
        }
    }

    /// Sets the functions.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    /// use robot_dynamics_generate::{Builder, Function, Target};
    /// let generated = Builder::new(file).functions([Function::Gravity]).generate(Target::C)?;
    /// assert!(generated.file("two_r.h").is_some_and(|file| !file.text.contains("forward_dynamics")));
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn functions(mut self, functions: impl IntoIterator<Item = Function>) -> Self {
        self.functions = functions.into_iter().collect();
        self
    }

    /// Sets the arithmetic.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    /// use robot_dynamics_generate::{Arithmetic, Builder, Precision, Target};
    /// let single = Arithmetic::new(Precision::Single);
    /// let generated = Builder::new(file).arithmetic(single).generate(Target::C)?;
    /// assert!(generated.file("two_r.h").is_some_and(|file| file.text.contains("const float q[2]")));
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn arithmetic(mut self, arithmetic: Arithmetic) -> Self {
        self.arithmetic = arithmetic;
        self
    }

    /// Adds each function for many states at once, in a submodule `lanes`; see [`Request::with_lanes`].
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    /// use robot_dynamics_generate::{Builder, Target};
    /// let generated = Builder::new(file).lanes().generate(Target::Rust)?;
    /// assert!(generated.file("src/two_r.rs").is_some_and(|file| file.text.contains("pub mod lanes {")));
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn lanes(mut self) -> Self {
        self.lanes = true;
        self
    }

    /// Writes no loops for bodies that are alike; see [`Request::with_straight`].
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    /// use robot_dynamics_generate::{Builder, Target};
    /// let generated = Builder::new(file).straight().generate(Target::C)?;
    /// // Two links are too few for a loop anyway.
    /// assert_eq!(generated, Builder::new(file).generate(Target::C)?);
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn straight(mut self) -> Self {
        self.straight = true;
        self
    }

    /// Frees the root link: six more degrees of freedom, before all others.
    ///
    /// ```
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
    /// use robot_dynamics_generate::{Builder, Target};
    /// let generated = Builder::new(file).floating_base().generate(Target::C)?;
    /// assert!(generated.file("quadruped.h").is_some_and(|file| file.text.contains("#define QUADRUPED_NQ 19")));
    /// # Ok::<(), robot_dynamics_generate::GenerateError>(())
    /// ```
    pub fn floating_base(mut self) -> Self {
        self.floating = true;
        self
    }

    /// Generates all files for a target, including a test.
    ///
    /// # Errors
    /// [`GenerateError`].
    ///
    /// ```
    /// let missing = robot_dynamics_generate::Builder::new("robots/nowhere.urdf").generate(robot_dynamics_generate::Target::Rust);
    /// assert!(missing.unwrap_err().to_string().contains("nowhere.urdf"));
    /// ```
    pub fn generate(&self, target: Target) -> Result<GeneratedFiles, GenerateError> {
        let mut options = robot_dynamics::LoadOptions::default();
        if self.floating {
            options = options.with_floating_base();
        }
        let model = robot_dynamics::load_with(&self.file, &options)?.model;
        let mut request = Request::new(target, self.functions.clone()).with_arithmetic(self.arithmetic);
        request.lanes = self.lanes;
        request.straight = self.straight;
        request.command = Some(format!("a build script, from {}", self.file.display()));
        generate(&model, &request)
    }

    /// For build scripts: writes the Rust module into `OUT_DIR` under this name, for `include!`. Cargo runs
    /// the script again when the robot's file changes.
    ///
    /// # Errors
    /// [`GenerateError`]; [`GenerateError::NoOutput`] outside a build script.
    ///
    /// ```
    /// let outside = robot_dynamics_generate::Builder::new("robots/panda.urdf").write_module("panda.rs");
    /// assert!(outside.unwrap_err().to_string().contains("OUT_DIR"));
    /// ```
    pub fn write_module(&self, name: &str) -> Result<(), GenerateError> {
        let folder = std::env::var_os("OUT_DIR").ok_or(GenerateError::NoOutput)?;
        println!("cargo::rerun-if-changed={}", self.file.display());
        let generated = self.generate(Target::Rust)?;
        let is_module = |name: &str| name.starts_with("src/") && name != "src/lib.rs";
        let module = generated.files.iter().find(|file| is_module(&file.name));
        let text = module.map_or("", |file| file.text.as_str());
        let path = Path::new(&folder).join(name);
        std::fs::write(&path, text).map_err(|cause| GenerateError::File { path, cause })
    }
}

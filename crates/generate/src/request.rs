//! Requests for generated code.

use robot_dynamics_expression::Arithmetic;

use crate::{Function, Target};

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
    /// The functions that front ends generate unless others are named.
    pub const DEFAULT_FUNCTIONS: [Function; 3] =
        [Function::InverseDynamics, Function::ForwardDynamics, Function::MassMatrix];

    /// The default number of random states of the test.
    pub const DEFAULT_STATES: u16 = 5;

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
            states: Self::DEFAULT_STATES.into(),
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

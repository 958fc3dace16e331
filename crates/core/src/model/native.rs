//! Machine code in place of the recursions, compiled when a function is first called.
//!
//! A `Tracer` returns the expression of a model's function, and the crate `native` compiles it. The tracer
//! belongs to a crate that depends on this one.
//!
//! The model keeps the code, so the results of a function are reproducible bit for bit after the first call.
//! Copies of a model share it. A function keeps its recursion in three cases: its expression is too long, the
//! processor or system does not allow code, or machine code is switched off.

mod function;
#[cfg(feature = "native")]
mod kernels;
mod report;
#[cfg(feature = "native")]
mod size;
#[cfg(feature = "native")]
pub(super) mod slots;
#[cfg(not(feature = "native"))]
pub(super) mod stub;

use crate::Model;
use crate::model::robot::Native;

#[cfg(feature = "native")]
pub use self::function::NativeTrace;
pub use self::function::{NativeFunction, NativeTask};
#[cfg(feature = "native")]
pub use self::kernels::Number;
pub use self::report::{NativeCode, NativeReport, NativeUse};
#[cfg(feature = "native")]
pub use crate::model::robot::Tracer;

impl Model {
    /// This model with machine code, compiled from the tracer's expressions when a function is first called.
    /// The environment variable `ROBOT_DYNAMICS_NATIVE=0` disables it.
    ///
    /// ```
    /// use robot_dynamics::algorithms::mass_matrix;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::{Model, Workspace};
    /// let model = Model::new(pendulum(2.0, 0.5))?.with_tracer(|_, _, _, _| Err("not traced".into()));
    /// let mut mass = [0.0];
    /// mass_matrix(&model, &mut Workspace::new(&model), &[0.3], &mut mass); // by the recursion
    /// assert_eq!(mass, [0.5]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    #[cfg(feature = "native")]
    #[must_use]
    pub fn with_tracer(mut self, tracer: Tracer) -> Self {
        self.native = Native::new(tracer);
        self
    }

    /// This model with or without machine code. Without it the recursions compute everything, and results
    /// differ by rounding. A model without a tracer, such as one from [`Model::new`], never has machine code.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?.with_native(false);
    /// assert!(model.native().reason.is_some()); // the reason for the recursions
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    #[must_use]
    pub fn with_native(mut self, on: bool) -> Self {
        self.native.switch(on);
        self
    }

    /// A copy for changes: the machine code of this model would be wrong for it.
    pub fn without_native_code(&self) -> Self {
        Self { native: Native::default(), ..self.clone() }
    }

    /// This robot without damping and friction of its joints, to trace functions without them.
    #[doc(hidden)]
    #[must_use]
    pub fn without_dissipation(&self) -> Self {
        let mut model = self.without_native_code();
        for dof in &mut model.dofs {
            (dof.passive.damping, dof.passive.friction) = (0.0, 0.0);
        }
        model
    }

    /// The functions that machine code computes, and the reasons why recursions compute the others.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// println!("{}", model.native());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn native(&self) -> NativeReport {
        self.native.report(self)
    }
}

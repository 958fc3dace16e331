//! The languages and callers that code is generated for.

use core::fmt;

/// A language, and the caller of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// A Rust crate without the standard library, whose one module can be included anywhere.
    Rust,
    /// C99: a header and a source that need libc only for roots (and for the platform's sine, if requested).
    C,
    /// C with CasADi's calling convention, for `casadi.external` and acados: sparsity, and Jacobians by the
    /// library's recursions or through the graph, whichever is shorter.
    Casadi,
    /// WGSL compute shaders, a thread for each state, in single precision.
    Wgsl,
    /// CUDA C kernels, a thread for each state, for nvcc or NVRTC.
    Cuda,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 5] = [Self::Rust, Self::C, Self::Casadi, Self::Wgsl, Self::Cuda];

    /// Its name.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_generate::Target::C.name(), "c");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Rust => "rust",
            Self::C => "c",
            Self::Casadi => "casadi",
            Self::Wgsl => "wgsl",
            Self::Cuda => "cuda",
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

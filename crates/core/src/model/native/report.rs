//! A report of how each function is computed.

use core::fmt;

use super::function::NativeFunction;
use crate::InstructionSet;

/// For each called function, whether machine code or a recursion computes it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeReport {
    /// The reason why recursions compute all functions; `None` if machine code is on.
    pub reason: Option<String>,
    /// The functions called since machine code was switched on.
    pub functions: Vec<NativeUse>,
}

/// How a called function is computed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeUse {
    /// The function.
    pub function: NativeFunction,
    /// Its frame, for [`NativeFunction::OF_FRAMES`].
    pub frame: Option<String>,
    /// Its scalar type, `f64` or `f32`.
    pub number: &'static str,
    /// Whether it computes several states at once.
    pub is_batch: bool,
    /// Its machine code, or the reason for the recursion.
    pub route: Result<NativeCode, String>,
}

/// A function's machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeCode {
    /// The instruction set that the code needs.
    pub instructions: InstructionSet,
    /// The number of operations in its expression.
    pub operations: usize,
    /// The size of code and constants in bytes.
    pub bytes: usize,
}

impl NativeReport {
    /// One line: how many functions machine code computes, and which keep their recursions.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(model.native().summary().starts_with("recursions alone"));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn summary(&self) -> String {
        if let Some(reason) = &self.reason {
            return format!("recursions alone: {reason}");
        }
        let names = |is_wanted: fn(&NativeUse) -> bool| {
            let wanted = self.functions.iter().filter(|used| is_wanted(used));
            let mut names: Vec<&str> = wanted.map(|used| used.function.name()).collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        let (compiled, others) = (names(|used| used.route.is_ok()), names(|used| used.route.is_err()));
        let count = |n: usize| format!("{n} function{}", if n == 1 { "" } else { "s" });
        let but = if others.is_empty() { "" } else { "; by recursion, at least in part: " };
        format!("machine code of {}{but}{}", count(compiled.len()), others.join(", "))
    }
}

impl fmt::Display for NativeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(reason) = &self.reason {
            return write!(f, "recursions compute all functions: {reason}");
        }
        if self.functions.is_empty() {
            return write!(f, "machine code is made when a function is first called");
        }
        for (index, used) in self.functions.iter().enumerate() {
            let gap = if index == 0 { "" } else { "\n" };
            write!(f, "{gap}{used}")?;
        }
        Ok(())
    }
}

impl fmt::Display for NativeUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { function, frame, number, is_batch, route } = self;
        let states = if *is_batch { "batches" } else { "one state" };
        write!(f, "{}", function.name())?;
        if let Some(frame) = frame {
            write!(f, " of `{frame}`")?;
        }
        write!(f, ", {number}, {states}: ")?;
        match route {
            Ok(NativeCode { instructions, operations, bytes }) => {
                write!(f, "machine code for {instructions:?}, {operations} operations, {bytes} bytes")
            }
            Err(reason) => write!(f, "recursion, {reason}"),
        }
    }
}

//! The route that computes a function.

use core::fmt;

use crate::{InstructionSet, NativeFunction};

/// The route of each function that was called.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeReport {
    /// Why the recursions compute all functions; `None` where machine code is on.
    pub reason: Option<String>,
    /// The functions that were called since machine code is on.
    pub functions: Vec<NativeUse>,
}

/// How a function that was called is computed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeUse {
    /// The function.
    pub function: NativeFunction,
    /// The frame that it is of, for [`NativeFunction::OF_FRAMES`].
    pub frame: Option<String>,
    /// Its number, `f64` or `f32`.
    pub number: &'static str,
    /// Whether it computes several states at once.
    pub is_batch: bool,
    /// The instructions of its code, or why its recursion computes.
    pub route: Result<NativeCode, String>,
}

/// A function's machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NativeCode {
    /// What the code needs of the processor.
    pub instructions: InstructionSet,
    /// Operations of its expression.
    pub operations: usize,
    /// Bytes of code and constants.
    pub bytes: usize,
}

impl NativeReport {
    /// One line: how many functions machine code computes, and which stay with their recursions.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(model.native().summary().starts_with("recursions alone"));
    /// # Ok::<(), multibody::ModelError>(())
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

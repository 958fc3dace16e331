//! The roles of the tables of a step in a rollout.

use robot_dynamics_generate::{Function, Table};

use crate::DeviceError;

/// The roles of the tables of a step.
pub(crate) struct StepTables {
    /// Read and written tables of the state, by their places in `reads` and `writes`.
    pub(crate) states: Vec<(usize, usize)>,
    /// The other read tables.
    pub(crate) held: Vec<usize>,
    /// The other written tables.
    pub(crate) outputs: Vec<usize>,
    pub(crate) reads: usize,
}

impl StepTables {
    pub(crate) fn of(function: &Function, reads: &[Table], writes: &[Table]) -> Result<Self, DeviceError> {
        let read_of = |write: &Table| {
            let name = write.name.strip_suffix("_next")?;
            reads.iter().position(|read| read.name == name)
        };
        let states: Vec<(usize, usize)> = (writes.iter().enumerate())
            .filter_map(|(written, table)| Some((read_of(table)?, written)))
            .collect();
        if states.is_empty() {
            return Err(wrong(function, "it is not a step, which writes tables such as q_next".into()));
        }
        let held = (0..reads.len()).filter(|at| states.iter().all(|(read, _)| read != at)).collect();
        let outputs =
            (0..writes.len()).filter(|at| states.iter().all(|(_, written)| written != at)).collect();
        Ok(Self { states, held, outputs, reads: reads.len() })
    }
}

/// The error of tables that do not fit a function.
pub(crate) fn wrong(function: &Function, cause: String) -> DeviceError {
    DeviceError::Tables { function: function.to_string(), cause }
}

//! Calls on memory of the caller: their tables and their stream.

use robot_dynamics_generate::Function;

use crate::backend::cuda::{CallerStream, DevicePointer};

/// The order of numbers in the tables of a call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableOrder {
    /// \[batch\]\[numbers\]: the numbers of one state side by side.
    #[default]
    Rows,
    /// \[numbers\]\[batch\]: one number of all states side by side. Neighbouring threads of a card then
    /// access neighbouring memory.
    Columns,
}

/// A call of one function on memory of the caller.
pub(crate) struct Call<'a> {
    pub(crate) stream: CallerStream,
    pub(crate) order: TableOrder,
    pub(crate) function: &'a Function,
    pub(crate) inputs: &'a [DevicePointer],
    pub(crate) outputs: &'a [DevicePointer],
}

/// Steps of states in memory of the caller; see [`Batches::rollout_on`](crate::Batches::rollout_on).
#[derive(Clone, Copy, Debug)]
pub struct DeviceRollout<'a> {
    /// The stream.
    pub stream: CallerStream,
    /// The order of numbers in all tables.
    pub order: TableOrder,
    /// The function of a step, [`Function::SemiImplicitEulerStep`] or [`Function::Rk4Step`] for example.
    pub function: &'a Function,
    /// The number of steps.
    pub steps: usize,
    /// Places for states. Each has the tables that the function writes under a name `x_next` and reads under
    /// the name `x`, in the order of [`Function::writes`]: q and v. Step k reads place k mod n and writes
    /// place k + 1 mod n, n ≥ 2.
    pub states: &'a [Vec<DevicePointer>],
    /// The other tables that the function reads, in the order of [`Function::reads`]: τ and h. A table holds
    /// the numbers of all states, or those of all states for each step, one step after the other.
    pub held: &'a [DevicePointer],
    /// The other tables that the function writes. Each step writes them again.
    pub outputs: &'a [DevicePointer],
}

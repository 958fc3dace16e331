//! Limits on the use of a device.

/// Limits on the use of a device, below its own. Larger batches are computed in several launches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// The largest table, in bytes.
    pub table_bytes: Option<u64>,
    /// The largest number of states of one launch.
    pub launch_states: Option<usize>,
}

impl Limits {
    /// Limits the size of tables.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_gpu::Limits::default().with_table_bytes(1 << 20).table_bytes, Some(1 << 20));
    /// ```
    pub const fn with_table_bytes(self, bytes: u64) -> Self {
        Self { table_bytes: Some(bytes), ..self }
    }

    /// Limits the number of states of a launch; wgpu rounds it down to a multiple of 64.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_gpu::Limits::default().with_launch_states(640).launch_states, Some(640));
    /// ```
    pub const fn with_launch_states(self, states: usize) -> Self {
        Self { launch_states: Some(states), ..self }
    }
}

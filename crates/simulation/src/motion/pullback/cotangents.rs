//! The gradients that the pullback of a step or a rollout reads and writes.

/// The gradients of a loss by the states and inputs of a step or a rollout, as in and out of its pullback.
///
/// Gradients by configurations have nv numbers, along the displacements of
/// [`integrate`](robot_dynamics_core::integrate()). Batches have one row per state.
#[derive(Debug)]
pub struct MotionCotangents<'a, S> {
    /// In: the gradient by the final configuration. Out: by the initial configuration. nv numbers.
    pub by_position: &'a mut [S],
    /// In: the gradient by the final velocity. Out: by the initial velocity. nv numbers.
    pub by_velocity: &'a mut [S],
    /// Out: the gradient by the forces τ, in their shape.
    pub by_force: &'a mut [S],
    /// Out: the gradient by the parameters, in the layout of
    /// [`ParameterCotangents`](robot_dynamics_core::ParameterCotangents); empty if it is not needed.
    pub parameters: &'a mut [S],
}

/// The gradients of a loss by the recorded states of a rollout, \[samples\]\[nv\] each; empty without a
/// stride.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryCotangents<'a, S> {
    /// The gradients by the configurations.
    pub by_position: &'a [S],
    /// The gradients by the velocities.
    pub by_velocity: &'a [S],
}

impl<S> Default for TrajectoryCotangents<'_, S> {
    /// Empty.
    fn default() -> Self {
        Self { by_position: &[], by_velocity: &[] }
    }
}

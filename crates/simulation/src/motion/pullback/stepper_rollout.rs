//! The settings of a rollout by a stepper.

use super::rollout::checkpoint_spacing;

/// The parameters of a rollout by a [`Stepper`](crate::Stepper).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepperRollout<'a, S> {
    /// The stepper that is copied for each state.
    pub stepper: &'a S,
    /// The step \[s\].
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// The number of steps between states of the trajectory; 0 for no trajectory.
    pub stride: usize,
    /// Whether each step starts with a copy of the stepper, without the forces of the step before.
    pub restarts: bool,
}

impl<'a, S> StepperRollout<'a, S> {
    /// A rollout of `steps` steps of this length \[s\], with damping and friction, without a trajectory.
    pub const fn new(stepper: &'a S, step: f64, steps: usize) -> Self {
        Self { stepper, step, steps, dissipation: true, stride: 0, restarts: false }
    }

    /// Selects whether the joints' damping and friction act.
    pub const fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// Records every `stride`-th state in the trajectory; 0 for no trajectory.
    pub const fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// Starts each step with a copy of the stepper, without the forces of contacts, friction and stops of the
    /// step before. The next state is then a function of the state and of τ alone, and so is its derivative.
    /// The contact forces are of first order in the step.
    pub const fn with_restarts(self) -> Self {
        Self { restarts: true, ..self }
    }

    /// The number of states in one trajectory: those after every `stride`-th step.
    pub fn samples(&self) -> usize {
        self.steps.checked_div(self.stride).unwrap_or(0)
    }

    /// The number of steps between checkpoints: the requested number, or √steps for 0.
    pub fn spacing(&self, asked: usize) -> usize {
        checkpoint_spacing(self.steps, asked)
    }
}

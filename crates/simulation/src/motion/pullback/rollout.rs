//! The settings of a rollout.

use robot_dynamics_integrators::Integrator;

/// The parameters of a rollout.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rollout {
    /// A row with explicit stages.
    pub integrator: Integrator,
    /// The step \[s\].
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// The number of steps between states of the trajectory; 0 for no trajectory.
    pub stride: usize,
}

impl Rollout {
    /// A rollout of `steps` steps of this length \[s\], with damping and friction, without a trajectory.
    ///
    /// ```
    /// use robot_dynamics::derivatives::Rollout;
    /// use robot_dynamics::simulation::Integrator;
    /// let second = Rollout::new(Integrator::RungeKutta4, 1e-3, 1000).with_stride(10);
    /// assert_eq!(second.samples(), 100);
    /// ```
    pub const fn new(integrator: Integrator, step: f64, steps: usize) -> Self {
        Self { integrator, step, steps, dissipation: true, stride: 0 }
    }

    /// Selects whether the joints' damping and friction act.
    pub const fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// Records every `stride`-th state in the trajectory; 0 for no trajectory.
    pub const fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// The number of states in one trajectory: those after every `stride`-th step.
    pub fn samples(&self) -> usize {
        self.steps.checked_div(self.stride).unwrap_or(0)
    }

    /// The number of steps between checkpoints: the requested number, or √steps, which needs the least
    /// memory.
    pub fn spacing(&self, asked: usize) -> usize {
        checkpoint_spacing(self.steps, asked)
    }

    /// A rollout of one of these steps, without a trajectory.
    #[doc(hidden)]
    #[must_use]
    pub fn one_step(&self) -> Self {
        Self { steps: 1, stride: 0, ..*self }
    }
}

/// The number of steps between the checkpoints of a rollout: the requested number, or √steps for 0.
pub(super) fn checkpoint_spacing(steps: usize, asked: usize) -> usize {
    let least = steps.isqrt();
    let least = if least * least < steps { least + 1 } else { least };
    if asked == 0 { least.max(1) } else { asked.min(steps.max(1)) }
}

//! The derivatives of a step.

/// The derivatives A and B of a step, as the outputs of [`linearize_step`](crate::linearize_step),
/// [`linearize_stepper`](crate::linearize_stepper) and
/// [`linearize_by_differences`](crate::linearize_by_differences).
#[derive(Debug)]
pub struct LinearizedStep<'a> {
    /// A: the derivative of the next state (δq₁, δv₁) by the state (δq₀, δv₀), 2nv×2nv, row-major.
    pub by_state: &'a mut [f64],
    /// B: the derivative of the next state by τ, 2nv×nv, row-major.
    pub by_force: &'a mut [f64],
}

impl LinearizedStep<'_> {
    /// Writes A and B from the changes of q₁ and v₁, whose first columns are those of (δq₀, δv₀, δτ).
    pub(in crate::motion) fn write_changes(&mut self, nv: usize, q_change: &[f64], v_change: &[f64]) {
        for (half, change) in [q_change, v_change].into_iter().enumerate() {
            for (i, row) in change.chunks_exact((change.len() / nv.max(1)).max(1)).enumerate() {
                let to = half * nv + i;
                self.by_state[to * 2 * nv..(to + 1) * 2 * nv].copy_from_slice(&row[..2 * nv]);
                self.by_force[to * nv..(to + 1) * nv].copy_from_slice(&row[2 * nv..3 * nv]);
            }
        }
    }
}

/// The derivatives of a step by its state, forces and parameters, as the output of
/// [`linearize_stepper_with_parameters`](crate::linearize_stepper_with_parameters). An empty slice leaves a
/// group out.
#[derive(Debug)]
pub struct LinearizedStepWithParameters<'a> {
    /// A and B.
    pub step: LinearizedStep<'a>,
    /// By the controls of the actuators, 2nv × controls, row-major.
    pub by_control: &'a mut [f64],
    /// By the inertial parameters, 2nv × 10·links, row-major: m, m c and I of each of
    /// [`Model::moving_links`](robot_dynamics_core::Model::moving_links), in the order of
    /// [`inertial_parameters`](robot_dynamics_core::inertial_parameters).
    pub by_inertial: &'a mut [f64],
    /// By the sliding friction μ of all contacts together, 2nv numbers. Torsional and rolling friction change
    /// in proportion to it.
    pub by_friction: &'a mut [f64],
}

impl<'a> LinearizedStepWithParameters<'a> {
    /// Without parameters.
    pub(in crate::motion) fn of_step(step: LinearizedStep<'a>) -> Self {
        Self { step, by_control: &mut [], by_inertial: &mut [], by_friction: &mut [] }
    }
}

/// The method by which [`linearize_stepper`](crate::linearize_stepper) computed A and B.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinearizationMethod {
    /// The derivative of the step's equations, with the contacts, stops and friction that act in it.
    Analytic {
        /// Whether a contact or a friction force is at a transition, such as from sticking to sliding. A and
        /// B are then the derivatives of one side.
        at_transition: bool,
    },
    /// Central differences.
    Differences {
        /// The part of the step that has no analytic derivative.
        reason: &'static str,
    },
}

/// How the steps of a rollout were differentiated, by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinearizedSteps {
    /// The steps with analytic derivatives.
    pub analytic: usize,
    /// Those of them at a transition, whose derivatives are one-sided.
    pub at_transition: usize,
    /// The steps whose derivatives are central differences.
    pub differences: usize,
    /// The reason for the differences of the first such step.
    pub reason: Option<&'static str>,
}

impl LinearizedSteps {
    /// Counts an earlier step.
    pub(in crate::motion) fn count(&mut self, method: &LinearizationMethod) {
        match *method {
            LinearizationMethod::Analytic { at_transition } => {
                self.analytic += 1;
                self.at_transition += usize::from(at_transition);
            }
            LinearizationMethod::Differences { reason } => {
                self.differences += 1;
                self.reason = Some(reason);
            }
        }
    }

    /// Adds the counts of another rollout.
    ///
    /// ```
    /// use robot_dynamics::derivatives::LinearizedSteps;
    /// let mut sum = LinearizedSteps::default();
    /// sum.add(&LinearizedSteps::default());
    /// assert_eq!(sum.analytic + sum.differences, 0);
    /// ```
    pub fn add(&mut self, other: &Self) {
        self.analytic += other.analytic;
        self.at_transition += other.at_transition;
        self.differences += other.differences;
        self.reason = self.reason.or(other.reason);
    }
}

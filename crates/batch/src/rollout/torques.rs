//! The torques of a rollout.

use core::fmt;

use crate::tables::check_table;

/// Generalized forces of the motors.
#[derive(Clone, Copy)]
pub enum Torques<'a, T> {
    /// Zero.
    Zero,
    /// Held over all steps, \[batch\]\[nv\].
    Held(&'a [T]),
    /// A value for each step, held over the step, \[batch\]\[steps\]\[nv\].
    EachStep(&'a [T]),
    /// A feedback law τ(step, q, v), evaluated at the start of each step and held over the step.
    ///
    /// It is called at every step with the states of one block, from any thread, and writes their torques,
    /// \[states\]\[nv\] \[N·m or N\]. The slice contains zeros at the first step, and then the values that it
    /// wrote last. If results are to be independent of how a batch is divided, each row must depend on its
    /// own state alone. A row that is not finite makes only its own state a bad state, which is NaN in later
    /// calls.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::batch::{BatchWorkspace, PolicyInput, Rollout, RolloutStates, Torques, rollout};
    /// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription};
    /// use robot_dynamics::description::{MassProperties, Pose, RobotDescription};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Integrator;
    /// use std::f64::consts::FRAC_PI_2;
    /// // A pendulum of 1 kg on a rod of 1 m along x, with its axis along y: upright at −π/2.
    /// let mut robot = RobotDescription::new("pendulum");
    /// let bob = MassProperties::new(1.0, Vector3::new(1.0, 0.0, 0.0), Matrix3::zeros())?;
    /// robot.links.push(LinkDescription::new("floor", None));
    /// robot.links.push(LinkDescription::new("rod", bob));
    /// let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    /// robot.joints.push(JointDescription::new("hinge", hinge, "floor", "rod", Pose::IDENTITY));
    /// let model = Model::new(robot)?;
    /// // A spring and a damper balance a thousand pendulums that start up to half a radian off.
    /// let balance = |at: PolicyInput<'_, f64>, tau: &mut [f64]| {
    ///     for i in 0..at.states {
    ///         tau[i] = -50.0 * (at.q[i] + FRAC_PI_2) - 10.0 * at.v[i];
    ///     }
    /// };
    /// let mut q: Vec<f64> = (0..1000).map(|i| -FRAC_PI_2 + 0.001 * f64::from(i - 500)).collect();
    /// let mut v = vec![0.0; 1000];
    /// let how = Rollout::new(Integrator::RungeKutta4, 0.01, 200).with_dissipation(false);
    /// let (mut workspace, policy) = (BatchWorkspace::new(&model), Torques::Policy(&balance));
    /// rollout(&model, &mut workspace, &how, policy, RolloutStates::ends(&mut q, &mut v), None)?;
    /// assert!(q.iter().all(|q| (q + FRAC_PI_2).abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    Policy(&'a (dyn Fn(PolicyInput<'_, T>, &mut [T]) + Sync)),
}

impl<T: Copy> Torques<'_, T> {
    /// Panics with both numbers if a table has the wrong length.
    #[track_caller]
    pub(super) fn check(&self, batch: usize, steps: usize, nv: usize) {
        match self {
            Self::Zero | Self::Policy(_) => {}
            Self::Held(tau) => check_table("tau", tau.len(), batch, nv),
            Self::EachStep(tau) => check_table("tau", tau.len(), batch, steps * nv),
        }
    }

    /// Writes the torques of one state at a step, for a rollout of `steps` steps of length `h` \[s\]; zeros
    /// are not written.
    pub(super) fn at(
        &self,
        state: usize,
        (step, steps): (usize, usize),
        h: f64,
        (q, v): (&[T], &[T]),
        tau: &mut [T],
    ) {
        let nv = tau.len();
        match self {
            Self::Zero => {}
            Self::Held(table) => tau.copy_from_slice(&table[state * nv..(state + 1) * nv]),
            Self::EachStep(table) => {
                let row = state * steps + step;
                tau.copy_from_slice(&table[row * nv..(row + 1) * nv]);
            }
            Self::Policy(policy) => {
                policy(PolicyInput { first: state, states: 1, step, time: step as f64 * h, q, v }, tau);
            }
        }
    }
}

/// The states for which a policy computes torques, one after the other: \[states\]\[nq\] and
/// \[states\]\[nv\].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PolicyInput<'a, T> {
    /// The index of the first of these states in the batch.
    pub first: usize,
    /// The number of states.
    pub states: usize,
    /// Completed steps.
    pub step: usize,
    /// Time since the start \[s\].
    pub time: f64,
    /// The configurations.
    pub q: &'a [T],
    /// The velocities.
    pub v: &'a [T],
}

impl<T: fmt::Debug> fmt::Debug for Torques<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("Zero"),
            Self::Held(tau) => f.debug_tuple("Held").field(tau).finish(),
            Self::EachStep(tau) => f.debug_tuple("EachStep").field(tau).finish(),
            Self::Policy(_) => f.debug_tuple("Policy").finish_non_exhaustive(),
        }
    }
}

/// A block's states and torques in the layout of a policy.
pub(super) struct PolicyRows<T> {
    pub q: Vec<T>,
    pub v: Vec<T>,
    pub tau: Vec<T>,
}

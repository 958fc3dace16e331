//! The interface of integration methods to a run.

use robot_dynamics_core::{Model, SingularMass, Workspace, check_rank};
use robot_dynamics_integrators::{EnergyAccount, Integrator};

use super::gains::add_passive_gains;
use super::{Losses, StepError, record_step};
use crate::motion::RobotState;
use crate::motion::linearize_step::results::{
    LinearizationMethod, LinearizedStep, LinearizedStepWithParameters,
};
use crate::{ActiveSet, ContactLaws, StateTransition, StepForces, StepWorkspace, step};

/// An integration method of a [`Simulation`](crate::simulator::Simulation): a row of the table of integrators
/// or a custom method ([`SimulationBuilder::stepper`](crate::simulator::SimulationBuilder::stepper)).
///
/// ```
/// use robot_dynamics::algorithms::forward_dynamics;
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, integrate};
/// use robot_dynamics::simulation::{RunOptions, SimulationBuilder, StepError, StepForces};
/// use robot_dynamics::simulation::{StepWorkspace, Stepper};
///
/// /// v₁ = v₀ + h a(q₀ ⊕ ½h v₀, v₀), q₁ = q₀ ⊕ ½h v₀ ⊕ ½h v₁: leapfrog.
/// #[derive(Clone)]
/// struct Leapfrog;
///
/// impl Stepper for Leapfrog {
///     fn step(
///         &mut self,
///         model: &Model,
///         workspace: &mut StepWorkspace,
///         forces: &StepForces<'_>,
///         h: f64,
///         q: &mut [f64],
///         v: &mut [f64],
///     ) -> Result<(), StepError> {
///         let half = |q: &[f64], v: &[f64]| {
///             let (mut moved, way) = (q.to_vec(), v.iter().map(|v| 0.5 * h * v).collect::<Vec<_>>());
///             integrate(model, q, &way, &mut moved);
///             moved
///         };
///         let middle = half(q, v);
///         let mut a = vec![0.0; v.len()];
///         forward_dynamics(model, workspace.dynamics(), &middle, v, forces.tau, &mut a);
///         v.iter_mut().zip(&a).for_each(|(v, a)| *v += h * a);
///         q.copy_from_slice(&half(&middle, v));
///         Ok(())
///     }
/// }
///
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let mut simulation = SimulationBuilder::new(&model).stepper(Leapfrog).dt(1e-4).build()?;
/// let run = simulation.run(0.01, RunOptions::new())?;
/// assert!(run.energy_account.drift() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Stepper {
    /// The order of the method. From order 3 on, events of v inside a step are located on the derivative of a
    /// cubic through its ends; below, on a line.
    fn order(&self) -> u32 {
        1
    }

    /// Checks the initial state once before the first step; `h` is the run's step \[s\].
    ///
    /// # Errors
    /// The state is an invalid start.
    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), StepError> {
        let _ = (model, workspace, h, q, v);
        Ok(())
    }

    /// Checks before each step that M is regular. It costs one O(n) pass, unless the method checks M itself.
    ///
    /// # Errors
    /// [`SingularMass`] names the joints without inertia.
    fn check_mass(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), SingularMass> {
        check_rank(model, workspace, q)
    }

    /// Advances (q, v) in place by `h` \[s\] with constant forces.
    ///
    /// # Errors
    /// The step failed; q and v are then unspecified. A custom stepper returns any error of its own as
    /// [`StepError::Callback`]: `.map_err(CallbackError::new)?`.
    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError>;

    /// The energy dissipated so far, by cause, if the method separates the causes.
    fn losses(&self) -> Option<Losses> {
        None
    }

    /// The mean force of the ground over the last step on each link that can touch it, if the method computes
    /// contact: [`StepInfo::contact_forces`](crate::StepInfo::contact_forces).
    fn contact_forces(&self) -> &[[f64; 3]] {
        &[]
    }

    /// The force f of each actuator before its gear, as the mean of the last step \[N·m or N\]. There is one
    /// entry per control, in the order of [`Actuation::control_names`](crate::Actuation::control_names). The
    /// slice is empty if the method has no actuators, and zero before the first step.
    ///
    /// The mean is available after [`record`](Self::record). [`MujocoEuler`](crate::MujocoEuler) holds the f
    /// of the step's start, which is its mean. [`ImplicitIntegrator`](crate::ImplicitIntegrator) evaluates f(u, q̄, Δq/h), where
    /// q̄ is the middle of Δq. This is the mean if f is linear in q and v, and it is accurate however stiff a
    /// servo is. Explicit methods apply Simpson's rule over the step's ends and middle.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, SimulationBuilder, Stepper};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0)));
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).method(Method::Implicit).build()?;
    /// simulation.set_controls(&[0.25]);
    /// simulation.step()?;
    /// assert_eq!(simulation.actuator_forces(), [0.25]); // N m at the motor's shaft
    /// assert_eq!(simulation.actuator_torques(), [50.0 * 0.25]); // N m at the joint
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn actuator_forces(&self) -> &[f64] {
        &[]
    }

    /// The generalized force of all actuators after gears and joint bounds, as the mean of the last step
    /// \[N·m or N\]. It has nv entries, or none if the method has no actuators. It includes gravity
    /// compensation by actuators, but not the springs and dampers of tendons.
    /// [`actuator_forces`](Self::actuator_forces) defines the mean and shows an example.
    fn actuator_torques(&self) -> &[f64] {
        &[]
    }

    /// The limits and contacts that acted in the last step. `None` unless the method is discontinuous where
    /// one of them starts or stops to act, as [`MujocoEuler`](crate::MujocoEuler).
    fn active_set(&self) -> Option<ActiveSet> {
        None
    }

    /// Fixes the limits and contacts that act, which makes the step differentiable; `None` selects those that
    /// are near. Methods without an [`active_set`](Self::active_set) ignore it.
    ///
    /// ```
    /// use robot_dynamics::contact::SoftConstraints;
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{MujocoEuler, StepForces, StepWorkspace, Stepper};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut stepper = MujocoEuler::new(&model, SoftConstraints::new(&model, 1e-3)?);
    /// let (mut w, forces) = (StepWorkspace::new(&model), StepForces::new(&[0.0], true));
    /// let mut speed_after = |stepper: &mut MujocoEuler, q: f64| {
    ///     let mut v = [1.0];
    ///     stepper.step(&model, &mut w, &forces, 1e-3, &mut [q], &mut v).map(|()| v[0])
    /// };
    /// assert!(speed_after(&mut stepper, 0.299)? > 1.0); // moves towards its limit
    /// let (free, mut fixed) = (stepper.active_set(), stepper.clone());
    /// fixed.fix_active_set(free); // no limit acts
    /// assert!(speed_after(&mut stepper, 0.301)? < 0.9 && speed_after(&mut fixed, 0.301)? > 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        let _ = set;
    }

    /// Writes the derivatives A and B of one step from this state, if the method has an analytic derivative
    /// there. Otherwise the result gives the reason, and nothing is written. The state of the method does not
    /// change. [`linearize_stepper`](crate::linearize_stepper) checks the input, and uses differences where
    /// this function has no result.
    ///
    /// # Errors
    /// The step failed.
    fn linearize(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStep<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        let _ = (model, workspace, forces, h, state, out);
        Ok(LinearizationMethod::Differences { reason: "a method without derivatives" })
    }

    /// As [`linearize`](Self::linearize), with the derivatives by the parameters whose slices are not empty.
    /// [`linearize_stepper_with_parameters`](crate::linearize_stepper_with_parameters) checks the input.
    ///
    /// # Errors
    /// The step failed.
    fn linearize_with_parameters(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        let _ = (model, workspace, forces, h, state, out);
        Ok(LinearizationMethod::Differences { reason: "a method without derivatives by parameters" })
    }

    /// The number of controls of the actuators that the method evaluates.
    fn control_count(&self) -> usize {
        0
    }

    /// Adds the nv×nv gains K and D of the forces −K δq − D v that the method treats explicitly. They bound
    /// its step, and a run that diverges derives its suggested step from them
    /// ([`RunError::Diverged`](crate::RunError::Diverged)). By default these are the gains of the joints'
    /// springs and dampers; [`ImplicitIntegrator`](crate::ImplicitIntegrator) adds none.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{ImplicitIntegrator, Integrator, Stepper};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_spring(30.0, 0.0).with_damping(4.0);
    /// let model = Model::new(robot)?;
    /// let gains = |stepper: &dyn Fn(&mut [f64], &mut [f64])| {
    ///     let (mut stiffness, mut damping) = ([0.0], [0.0]);
    ///     stepper(&mut stiffness, &mut damping);
    ///     [stiffness[0], damping[0]]
    /// };
    /// let (row, implicit) = (Integrator::RungeKutta4, ImplicitIntegrator::new(&model));
    /// assert_eq!(gains(&|k, d| row.explicit_gains(&model, true, k, d)), [30.0, 4.0]);
    /// assert_eq!(gains(&|k, d| implicit.explicit_gains(&model, true, k, d)), [0.0, 0.0]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    fn explicit_gains(&self, model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        add_passive_gains(model, dissipation, stiffness, damping);
    }

    /// The accuracy of the solutions of rigid contact so far, if the method solves for them:
    /// [`Run::contact_laws`](crate::Run::contact_laws).
    fn contact_laws(&self) -> Option<ContactLaws> {
        None
    }

    /// Energy that the step's forces store in addition to K + V \[J\]: springs of tendons, gravity
    /// compensation.
    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        let _ = q;
        0.0
    }

    /// Records a step in the energy account, by [`record_step`] unless forces other than the
    /// held τ act.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        record_step(model, workspace, energy_account, transition);
    }
}

impl Stepper for Integrator {
    fn order(&self) -> u32 {
        Self::order(*self)
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        Ok(step(model, *self, workspace, forces, h, q, v)?)
    }
}

//! What takes the steps of a run.

use std::error::Error;

use dynamics::{DynamicsError, EnergyLedger, Integrator, IntegratorError};

use super::divergence::add_passive_gains;
use super::{CallbackError, Losses, record_step};
use crate::algorithms::rank::check_rank;
use crate::{ActiveSet, ContactLaws, Model, SingularMass, StepForces, StepWorkspace, Workspace, step};

/// The method that takes the steps of a [`Simulation`](crate::simulator::Simulation): a row of the table of integrators, or one of your
/// own ([`SimulationBuilder::stepper`](crate::simulator::SimulationBuilder::stepper)).
///
/// ```
/// use multibody::{CallbackError, Model, StepForces, Stepper, StepWorkspace};
/// use multibody::{RandomRobotOptions, forward_dynamics, integrate, random_robot};
/// use multibody::simulator::{RunOptions, SimulationBuilder};
///
/// /// v₁ = v₀ + h a(q₀ ⊕ ½h v₀, v₀), q₁ = q₀ ⊕ ½h v₀ ⊕ ½h v₁: leapfrog.
/// #[derive(Clone)]
/// struct Leapfrog;
///
/// impl Stepper for Leapfrog {
///     type Error = CallbackError;
///     fn step(
///         &mut self,
///         model: &Model,
///         workspace: &mut StepWorkspace,
///         forces: &StepForces<'_>,
///         h: f64,
///         q: &mut [f64],
///         v: &mut [f64],
///     ) -> Result<(), CallbackError> {
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
/// let mut simulation = SimulationBuilder::new(&model).stepper(Leapfrog).step(1e-4).build()?;
/// let run = simulation.run(100, RunOptions::new())?;
/// assert!(run.ledger.drift() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Stepper {
    /// Why a step could not be taken.
    type Error: StepError;

    /// The order of the method, as far as it is known: from the third on, events of v inside a step are located on the
    /// slope of a cubic through its ends, before on a line.
    fn order(&self) -> u32 {
        1
    }

    /// Refuses a state to start from, once before the first step; `h` is the run's step \[s\].
    ///
    /// # Errors
    /// Why no step can be taken from there.
    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), Self::Error> {
        let _ = (model, workspace, h, q, v);
        Ok(())
    }

    /// Refuses a configuration in which no acceleration follows from the forces; before each step. One O(n) pass,
    /// unless the method looks itself.
    ///
    /// # Errors
    /// The joints that move no inertia.
    fn check_mass(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), SingularMass> {
        check_rank(model, workspace, q)
    }

    /// Advances (q, v) in place by `h` \[s\], the forces held.
    ///
    /// # Errors
    /// Why not; q and v are then not read.
    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), Self::Error>;

    /// What took energy out so far, by cause, where the method tells them apart.
    fn losses(&self) -> Option<Losses> {
        None
    }

    /// The ground's force on each link that can touch it, the mean of the last step, where the method computes contact:
    /// [`StepInfo::contact_forces`](crate::StepInfo::contact_forces).
    fn contact_forces(&self) -> &[[f64; 3]] {
        &[]
    }

    /// The force f of each actuator, before its gear, the mean of the last step \[N·m or N\]: one entry a control, in the order of
    /// [`Actuation::control_names`](crate::Actuation::control_names). Empty where the method has no actuators; zeros before the first step.
    ///
    /// The mean is known after [`record`](Self::record). [`MujocoEuler`](crate::MujocoEuler) holds f of the step's start; so that is its mean.
    /// [`Implicit`](crate::Implicit) takes f(u, q̄, Δq/h), with q̄ half the way Δq: the mean where f is linear in q and v, which keeps its digits however
    /// stiff a servo is. Explicit methods take Simpson's rule over the step's ends and middle.
    ///
    /// ```
    /// use multibody::{ActuatorDescription, Model, Stepper, Transmission, pendulum};
    /// use multibody::simulator::{Method, SimulationBuilder};
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

    /// The generalized forces of the actuators together, after gears and the bounds of joints, the mean of the last step \[N·m or N\]: nv
    /// entries, or none where the method has no actuators. Weight that actuators carry is part of it; tendons' springs and dampers are not.
    /// When it is known and what the mean is: [`actuator_forces`](Self::actuator_forces), with the example there.
    fn actuator_torques(&self) -> &[f64] {
        &[]
    }

    /// The limits and contacts that acted in the last step, where the method has jumps where one of them begins or ends to act: as
    /// [`MujocoEuler`](crate::MujocoEuler).
    fn active_set(&self) -> Option<ActiveSet> {
        None
    }

    /// From now on exactly these limits and contacts act, which makes the step differentiable; `None`: those that are near. Methods without
    /// an [`active_set`](Self::active_set) ignore it.
    ///
    /// ```
    /// use multibody::{Limits, Model, MujocoEuler, SoftConstraints, StepForces, StepWorkspace, Stepper, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut stepper = MujocoEuler::new(&model, SoftConstraints::new(&model, 1e-3)?);
    /// let (mut w, forces) = (StepWorkspace::new(&model), StepForces::new(&[0.0], true));
    /// let mut speed_after = |stepper: &mut MujocoEuler, q: f64| {
    ///     let mut v = [1.0];
    ///     stepper.step(&model, &mut w, &forces, 1e-3, &mut [q], &mut v).map(|()| v[0])
    /// };
    /// assert!(speed_after(&mut stepper, 0.299)? > 1.0); // it falls towards its limit
    /// let (free, mut fixed) = (stepper.active_set(), stepper.clone());
    /// fixed.fix_active_set(free); // no limit acts
    /// assert!(speed_after(&mut stepper, 0.301)? < 0.9 && speed_after(&mut fixed, 0.301)? > 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        let _ = set;
    }

    /// Adds K and D, nv×nv, of the forces −K δq − D v that the method takes explicitly: they bound its step, which is suggested by them where a
    /// run grows without bound ([`RunError::Diverged`](crate::RunError::Diverged)). Unless a method knows better, those of the joints' springs and
    /// dampers; none for [`Implicit`](crate::Implicit).
    ///
    /// ```
    /// use dynamics::Integrator;
    /// use multibody::{Implicit, Model, PassiveForces, Stepper, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_spring(30.0, 0.0).with_damping(4.0);
    /// let model = Model::new(robot)?;
    /// let gains = |stepper: &dyn Fn(&mut [f64], &mut [f64])| {
    ///     let (mut stiffness, mut damping) = ([0.0], [0.0]);
    ///     stepper(&mut stiffness, &mut damping);
    ///     [stiffness[0], damping[0]]
    /// };
    /// let (row, implicit) = (Integrator::RungeKutta4, Implicit::new(&model));
    /// assert_eq!(gains(&|k, d| row.explicit_gains(&model, true, k, d)), [30.0, 4.0]);
    /// assert_eq!(gains(&|k, d| implicit.explicit_gains(&model, true, k, d)), [0.0, 0.0]);
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    fn explicit_gains(&self, model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        add_passive_gains(model, dissipation, stiffness, damping);
    }

    /// How well the laws of contact were kept so far, where the method solves for them: [`Run::contact_laws`](crate::Run::contact_laws).
    fn contact_laws(&self) -> Option<ContactLaws> {
        None
    }

    /// Energy that the step's forces store beside K + V \[J\]: springs of tendons, weight that is carried.
    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        let _ = q;
        0.0
    }

    /// Enters a step of `h` \[s\] into the books: as [`record_step`], unless other forces than the held τ act.
    #[allow(clippy::too_many_arguments)] // those of `record_step`
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        ledger: &mut EnergyLedger,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) {
        record_step(model, workspace, ledger, from, to, forces, h);
    }
}

impl Stepper for Integrator {
    type Error = IntegratorError;

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
    ) -> Result<(), IntegratorError> {
        step(model, *self, workspace, forces, h, q, v)
    }
}

/// What a run makes of the error of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum StepFault<E> {
    /// A number became NaN or infinite: at a coordinate, or, where the quantity's name starts with q, at an entry of q.
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
        /// Which entry.
        index: usize,
    },
    /// M is singular there.
    SingularMass(SingularMass),
    /// Anything else.
    Other(E),
}

/// An error of a step; `impl StepError for MyError {}` is enough.
pub trait StepError: Error + Sized {
    /// What it says, so that a run can name time, coordinate and joints.
    fn fault(self, model: &Model) -> StepFault<Self> {
        let _ = model;
        StepFault::Other(self)
    }

    /// Whether the step was interrupted from outside: then a run ends there as one that its observer broke off.
    fn is_interruption(&self) -> bool {
        false
    }
}

impl StepError for CallbackError {}

impl StepError for IntegratorError {
    fn is_interruption(&self) -> bool {
        *self == Self::Interrupted
    }

    fn fault(self, model: &Model) -> StepFault<Self> {
        match self {
            Self::Dynamics(DynamicsError::NonFinite { quantity, index }) => {
                StepFault::NotFinite { quantity, index }
            }
            Self::Dynamics(DynamicsError::SingularMass { coordinate, pivot }) => {
                StepFault::SingularMass(SingularMass::at(model, coordinate, pivot))
            }
            other => StepFault::Other(other),
        }
    }
}

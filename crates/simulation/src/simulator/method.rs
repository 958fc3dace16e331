//! The integration methods of a simulation.

use core::fmt;
use core::str::FromStr;

use robot_dynamics_core::{Model, SingularMass, Workspace};
use robot_dynamics_integrators::{EnergyAccount, Integrator};
use thiserror::Error;

use super::own_stepper::OwnStepper;
use crate::constraints::ConstrainedStepper;
#[cfg(feature = "adaptive")]
use crate::motion::simulate::AdaptiveStepper;
use crate::motion::simulate::{ActuatedStepper, Losses, StateTransition, Stepper};
use crate::{
    ActiveSet, ConstraintRecord, ContactLaws, ContactPoint, ContactProblem, ImplicitIntegrator,
    LinearizationMethod, LinearizeStepWorkspace, LinearizedStep, LinearizedStepWithParameters, MujocoEuler,
    RobotState, StepError, StepForces, StepWorkspace, linearize_step,
};

/// The integration method of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// A row of the table of integrators.
    Fixed(Integrator),
    /// Steps that remain stable for stiff joints, with static friction, stops, equalities and rigid contact:
    /// [`ImplicitIntegrator`].
    Implicit,
    /// MuJoCo's Euler steps with its soft constraints: [`MujocoEuler`].
    Mujoco,
    /// Adaptive steps of high order: [`AdaptiveOptions`](crate::AdaptiveOptions). The simulation's step is
    /// the interval between samples.
    #[cfg(feature = "adaptive")]
    Adaptive,
    /// A custom method: [`SimulationBuilder::stepper`](super::SimulationBuilder::stepper).
    Own,
}

impl Method {
    /// The name of the method in the command and in Python.
    ///
    /// ```
    /// use robot_dynamics::simulation::Method;
    /// assert_eq!(Method::Implicit.name(), "implicit");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed(row) => row.name(),
            Self::Implicit => "implicit",
            Self::Mujoco => "mujoco",
            #[cfg(feature = "adaptive")]
            Self::Adaptive => "adaptive",
            Self::Own => "own",
        }
    }

    /// The names of all methods that can be selected by name.
    ///
    /// ```
    /// use robot_dynamics::simulation::Method;
    /// assert!(Method::names().all(|name| name.parse::<Method>().is_ok_and(|method| method.name() == name)));
    /// ```
    pub fn names() -> impl Iterator<Item = &'static str> {
        let rows = Integrator::ALL.into_iter().map(Integrator::name);
        rows.chain([
            Self::Implicit.name(),
            Self::Mujoco.name(),
            #[cfg(feature = "adaptive")]
            Self::Adaptive.name(),
        ])
    }
}

/// The error for an unknown name of a method.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no method `{name}`; there are {}", Method::names().collect::<Vec<_>>().join(", "))]
pub struct UnknownMethod {
    /// The unknown name.
    pub name: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;
    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        match name {
            "implicit" => Ok(Self::Implicit),
            "mujoco" => Ok(Self::Mujoco),
            #[cfg(feature = "adaptive")]
            "adaptive" => Ok(Self::Adaptive),
            _ => Integrator::from_name(name)
                .map(Self::Fixed)
                .map_err(|_| UnknownMethod { name: name.to_owned() }),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Takes the steps of a simulation; a [`Stepper`] for batches and linearized steps.
#[derive(Debug)]
pub struct SimulationStepper {
    pub(super) kind: StepperKind,
}

impl Clone for SimulationStepper {
    fn clone(&self) -> Self {
        Self { kind: self.kind.clone() }
    }

    /// Reuses the memory of `self` if both are steppers of the same kind.
    fn clone_from(&mut self, source: &Self) {
        match (&mut self.kind, &source.kind) {
            (StepperKind::Actuated(own), StepperKind::Actuated(source)) => own.clone_from(source),
            (StepperKind::Implicit(own), StepperKind::Implicit(source)) => own.clone_from(source),
            (StepperKind::Mujoco(own), StepperKind::Mujoco(source)) => own.clone_from(source),
            (own, source) => *own = source.clone(),
        }
    }
}

/// The stepper of each method.
#[derive(Clone, Debug)]
pub(super) enum StepperKind {
    Row(Integrator),
    Actuated(Box<ActuatedStepper>),
    Constrained(Box<ConstrainedStepper>),
    Implicit(Box<ImplicitIntegrator>),
    Mujoco(Box<MujocoEuler>),
    #[cfg(feature = "adaptive")]
    Adaptive(Box<AdaptiveStepper>),
    Own(OwnStepper),
}

/// Calls a method on the stepper of any kind.
macro_rules! each {
    ($kind:expr, $own:ident => $call:expr) => {
        match $kind {
            StepperKind::Row($own) => $call,
            StepperKind::Actuated($own) => $call,
            StepperKind::Constrained($own) => $call,
            StepperKind::Implicit($own) => $call,
            StepperKind::Mujoco($own) => $call,
            #[cfg(feature = "adaptive")]
            StepperKind::Adaptive($own) => $call,
            StepperKind::Own($own) => $call,
        }
    };
}

impl SimulationStepper {
    /// The row of the table of integrators, if that row alone takes the steps; batches then advance many
    /// states at once.
    pub fn row(&self) -> Option<Integrator> {
        match self.kind {
            StepperKind::Row(row) => Some(row),
            _ => None,
        }
    }

    /// Whether the stepper evaluates actuators, and springs other than those of joints.
    pub(super) fn drives(&self) -> bool {
        match &self.kind {
            StepperKind::Actuated(_) | StepperKind::Implicit(_) | StepperKind::Mujoco(_) => true,
            #[cfg(feature = "adaptive")]
            StepperKind::Adaptive(stepper) => stepper.is_driven(),
            _ => false,
        }
    }

    /// The contacts at the end of the last step, with their forces.
    pub fn contacts(&self) -> Vec<ContactPoint<'_>> {
        match &self.kind {
            StepperKind::Implicit(stepper) => stepper.contact_points().collect(),
            StepperKind::Mujoco(stepper) => stepper.law().contact_points().collect(),
            _ => Vec::new(),
        }
    }

    /// The links that can touch a ground.
    pub(super) fn ground_links(&self) -> &[String] {
        match &self.kind {
            StepperKind::Implicit(stepper) => stepper.ground_links(),
            StepperKind::Mujoco(stepper) => stepper.law().ground_links(),
            _ => &[],
        }
    }

    /// The contacts of the last step as one complementarity problem with the computed solution, for
    /// comparison with other methods. `None` if nothing touched, or if the method does not solve such a
    /// problem. If the step was divided, the problem is that of its last part and of the components that
    /// moved in it.
    ///
    /// ```
    /// use robot_dynamics::contact::Ground;
    /// use robot_dynamics::description::{Base, LinkDescription, LinkShape, Pose, RobotDescription};
    /// use robot_dynamics::description::{Shape, ShapeRole};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// use robot_dynamics::verification::admm;
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build()?;
    /// // The cube lies flat and slides along y.
    /// simulation.reset(&[0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], &[0.0, 0.5, 0.0, 0.0, 0.0, 0.0])?;
    /// simulation.step()?;
    /// let problem = simulation.contact_problem().unwrap();
    /// let other = admm::solve(&problem, &admm::Options::default());
    /// assert!((problem.velocity - other.velocity).amax() < 1e-9); // both solvers agree
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contact_problem(&self) -> Option<ContactProblem> {
        match &self.kind {
            StepperKind::Implicit(stepper) => stepper.contact_problem(),
            _ => None,
        }
    }

    /// The generalized forces of position limits and the forces of tendon limits in the last step \[N·m or
    /// N\]. They are zero if the method has no limits.
    pub(super) fn limit_forces(&self, model: &Model) -> [Vec<f64>; 2] {
        let mut forces = [vec![0.0; model.nv], vec![0.0; model.description.tendon_names().count()]];
        let [coordinates, tendons] = &mut forces;
        match &self.kind {
            StepperKind::Implicit(stepper) => stepper.add_limit_forces(coordinates, tendons),
            StepperKind::Mujoco(stepper) => stepper.law().add_limit_forces(coordinates, tendons),
            _ => {}
        }
        forces
    }

    pub(super) fn constraint_record(&self) -> Option<&ConstraintRecord> {
        match &self.kind {
            StepperKind::Constrained(stepper) => Some(&stepper.record),
            _ => None,
        }
    }

    /// The multiplier of each row of the equalities by name, as the mean over the last step \[N, or N·m for a
    /// rotation\]. Empty if the method does not compute them.
    pub fn constraint_forces(&self) -> Vec<(&str, f64)> {
        match &self.kind {
            StepperKind::Implicit(stepper) => stepper.constraint_forces().collect(),
            _ => Vec::new(),
        }
    }
}

// The stepper of one kind already returns the errors of a simulation.
#[allow(clippy::useless_conversion)]
impl Stepper for SimulationStepper {
    fn order(&self) -> u32 {
        each!(&self.kind, own => own.order())
    }

    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), StepError> {
        each!(&mut self.kind, own => own.check_start(model, workspace, h, q, v))
    }

    fn check_mass(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), SingularMass> {
        each!(&mut self.kind, own => own.check_mass(model, workspace, q))
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
        each!(&mut self.kind, own => own.step(model, workspace, forces, h, q, v))
    }

    fn losses(&self) -> Option<Losses> {
        each!(&self.kind, own => own.losses())
    }

    fn contact_forces(&self) -> &[[f64; 3]] {
        each!(&self.kind, own => own.contact_forces())
    }

    fn actuator_forces(&self) -> &[f64] {
        each!(&self.kind, own => own.actuator_forces())
    }

    fn actuator_torques(&self) -> &[f64] {
        each!(&self.kind, own => own.actuator_torques())
    }

    fn explicit_gains(&self, model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        each!(&self.kind, own => own.explicit_gains(model, dissipation, stiffness, damping));
    }

    fn active_set(&self) -> Option<ActiveSet> {
        each!(&self.kind, own => own.active_set())
    }

    fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        each!(&mut self.kind, own => own.fix_active_set(set));
    }

    fn linearize(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStep<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        if let Some(row) = self.row().filter(|row| row.is_explicit()) {
            let memory = &mut LinearizeStepWorkspace::new(model);
            linearize_step(model, row, memory, forces, h, state, out)?;
            return Ok(LinearizationMethod::Analytic { at_transition: false });
        }
        each!(&mut self.kind, own => own.linearize(model, workspace, forces, h, state, out))
    }

    fn linearize_with_parameters(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        each!(&mut self.kind, own => own.linearize_with_parameters(model, workspace, forces, h, state, out))
    }

    fn control_count(&self) -> usize {
        each!(&self.kind, own => own.control_count())
    }

    fn contact_laws(&self) -> Option<ContactLaws> {
        each!(&self.kind, own => own.contact_laws())
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        each!(&mut self.kind, own => own.stored_energy(q))
    }

    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        each!(&mut self.kind, own => own.record(model, workspace, energy_account, transition));
    }
}

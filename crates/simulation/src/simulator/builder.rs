//! The builder of a simulation: selects the effects and the integration method.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use robot_dynamics_core::Model;
use robot_dynamics_description::LinkShape;

#[cfg(doc)]
use super::Simulation;
use super::own_stepper::OwnStepper;
use super::{Effect, Method};
#[cfg(feature = "adaptive")]
use crate::AdaptiveOptions;
use crate::constraints::{ConstraintOptions, DriftCorrection};
use crate::{ConstraintSet, ContactSet, Ground, HeightField, Stepper};

/// Returns the points of a mesh, or why they are missing.
type PointsOf<'a> = Box<dyn FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String> + Send + 'a>;

/// Returns the height field of a shape, or why it is missing.
type FieldOf<'a> = Box<dyn FnMut(&LinkShape) -> Result<HeightField, String> + Send + 'a>;

/// Selects the effects that act in a [`Simulation`] and the integration method.
///
/// **Effects**: every effect that the description states acts, unless [`without`](Self::without) or
/// [`conservative`](Self::conservative) switches it off. Effects that the method does not support are left
/// out; [`Simulation::left_out`] lists them.
///
/// **Method**: by default `rk4` if every force is smooth and not stiff, otherwise `implicit`.
/// [`Simulation::reason`] states why.
///
/// ```
/// use robot_dynamics::description::{Limits, PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3);
/// robot.joints[0].limits = Limits::new(-0.5, 0.5);
/// let model = Model::new(robot)?;
/// let mut simulation = SimulationBuilder::new(&model).build()?; // damping and limits act
/// assert_eq!(simulation.method(), Method::Implicit);
/// simulation.run_for(3.0)?;
/// assert!((simulation.q()[0] - 0.5).abs() < 1e-9); // at rest at the upper limit
/// let free = SimulationBuilder::new(&model).conservative().build()?;
/// assert_eq!(free.method().name(), "rk4");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SimulationBuilder<'a> {
    pub(super) model: Arc<Model>,
    pub(super) dt: f64,
    pub(super) method: Option<Method>,
    pub(super) switched_off: Vec<Effect>,
    pub(super) grounds: Vec<Ground>,
    pub(super) fields: Vec<HeightField>,
    pub(super) points_of: PointsOf<'a>,
    pub(super) field_of: FieldOf<'a>,
    pub(super) contacts: Option<ContactSet>,
    pub(super) constraints: Option<ConstraintSet>,
    pub(super) options: ConstraintOptions,
    pub(super) correction: DriftCorrection,
    #[cfg(feature = "adaptive")]
    pub(super) adaptive: AdaptiveOptions,
    pub(super) own: Option<OwnStepper>,
    pub(super) interrupt: Option<Arc<AtomicBool>>,
    pub(super) ignored_pairs: Vec<(String, String)>,
    pub(super) only_pairs: Option<Vec<(String, String)>>,
    pub(super) is_ground_given: bool,
    pub(super) are_constraints_given: bool,
}

impl<'a> SimulationBuilder<'a> {
    /// The default step \[s\].
    pub const DEFAULT_DT: f64 = 1e-3;

    /// The default tolerance of the projection onto the equalities after each step \[m or rad\].
    pub const EQUALITY_TOLERANCE: f64 = 1e-12;

    /// Creates a builder for a copy of this robot.
    pub fn new(model: &Model) -> Self {
        Self::shared(Arc::new(model.clone()))
    }

    /// Creates a builder for a shared robot, without a copy.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// use std::sync::Arc;
    /// let model = Arc::new(Model::new(pendulum(2.0, 0.5))?);
    /// let simulation = SimulationBuilder::shared(Arc::clone(&model)).build()?;
    /// assert_eq!(simulation.model().name(), model.name());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn shared(model: Arc<Model>) -> Self {
        Self {
            model,
            dt: Self::DEFAULT_DT,
            method: None,
            switched_off: Vec::new(),
            grounds: Vec::new(),
            fields: Vec::new(),
            points_of: Box::new(|_| Err("meshes are not opened".into())),
            field_of: Box::new(|_| Err("files of height fields are not opened".into())),
            contacts: None,
            constraints: None,
            options: ConstraintOptions::of_files(),
            correction: DriftCorrection::Position { tolerance: Self::EQUALITY_TOLERANCE },
            #[cfg(feature = "adaptive")]
            adaptive: AdaptiveOptions::default(),
            own: None,
            interrupt: None,
            ignored_pairs: Vec::new(),
            only_pairs: None,
            is_ground_given: false,
            are_constraints_given: false,
        }
    }

    /// Sets the step \[s\]; the default is [`DEFAULT_DT`](Self::DEFAULT_DT).
    #[must_use]
    #[doc(alias("step", "step_size"))]
    pub fn dt(self, dt: f64) -> Self {
        Self { dt, ..self }
    }

    /// Sets the integration method.
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Self { method: Some(method), ..self }
    }

    /// Sets a custom stepper, which evaluates the forces other than τ. The builder applies effort limits and
    /// [`StepForces::dissipation`](crate::StepForces::dissipation), the switch of damping and friction.
    ///
    /// ```
    /// use robot_dynamics::algorithms::forward_dynamics;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::{Model, integrate};
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder, StepError, StepForces};
    /// use robot_dynamics::simulation::{StepWorkspace, Stepper};
    ///
    /// /// v₁ = v₀ + h a(q₀, v₀), q₁ = q₀ ⊕ h v₁.
    /// #[derive(Clone)]
    /// struct Euler;
    ///
    /// impl Stepper for Euler {
    ///     fn step(
    ///         &mut self,
    ///         model: &Model,
    ///         workspace: &mut StepWorkspace,
    ///         forces: &StepForces<'_>,
    ///         h: f64,
    ///         q: &mut [f64],
    ///         v: &mut [f64],
    ///     ) -> Result<(), StepError> {
    ///         let mut a = vec![0.0; v.len()];
    ///         forward_dynamics(model, workspace.dynamics(), q, v, forces.tau, &mut a);
    ///         v.iter_mut().zip(&a).for_each(|(v, a)| *v += h * a);
    ///         let (start, way) = (q.to_vec(), v.iter().map(|v| h * v).collect::<Vec<_>>());
    ///         integrate(model, &start, &way, q);
    ///         Ok(())
    ///     }
    /// }
    ///
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).stepper(Euler).dt(1e-4).build()?;
    /// let run = simulation.run(0.1, RunOptions::new())?;
    /// assert!(run.energy_account.drift() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn stepper<S>(self, stepper: S) -> Self
    where
        S: Stepper + Clone + Send + Sync + 'static,
    {
        Self { own: Some(OwnStepper::new(stepper)), method: Some(Method::Own), ..self }
    }

    /// Selects adaptive steps of high order. The state at each
    /// [`step`](crate::simulator::Simulation::step) meets the tolerance whatever the step's length, and so do
    /// the times of events. Supported effects are rigid bodies, springs and damping of joints, torques and
    /// wrenches. Other effects are left out, and so is the damping of a
    /// joint with dry friction.
    ///
    /// A [run](Simulation::run) takes steps longer than the interval between samples. Without an observer it
    /// evaluates only the samples that are kept.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
    /// use robot_dynamics::model::{Model, neutral};
    /// use robot_dynamics::simulation::{AdaptiveOptions, Event, RunOptions, SimulationBuilder};
    /// // Throw a brick up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let options = AdaptiveOptions { tolerance: 1e-12, ..AdaptiveOptions::default() };
    /// let mut simulation = SimulationBuilder::new(&model).adaptive(options).dt(0.1).build()?;
    /// simulation.reset(&q, &[0.0, 0.0, 3.0, 0.0, 0.0, 0.0])?;
    /// let run = simulation.run(10.0, RunOptions::new().events(&mut events))?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "adaptive")]
    #[must_use]
    pub fn adaptive(self, options: AdaptiveOptions) -> Self {
        Self { adaptive: options, method: Some(Method::Adaptive), ..self }
    }

    /// Switches off one effect.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Effect, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_friction(0.3);
    /// let model = Model::new(robot)?;
    /// let simulation = SimulationBuilder::new(&model).without(Effect::Dissipation).build()?;
    /// assert_eq!(simulation.method().name(), "rk4"); // every force is smooth without dry friction
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn without(mut self, effect: Effect) -> Self {
        self.switched_off.push(effect);
        self
    }

    /// Switches off damping, friction, limits, actuators and contact. Springs and equalities act, and K + V
    /// is conserved.
    #[must_use]
    pub fn conservative(mut self) -> Self {
        let lossy =
            [Effect::Dissipation, Effect::Limits, Effect::EffortLimits, Effect::Actuators, Effect::Contacts];
        self.switched_off.extend(lossy);
        self
    }

    /// Adds a half-space to the ground planes of the description.
    #[must_use]
    pub fn ground(mut self, ground: Ground) -> Self {
        self.grounds.push(ground);
        self
    }

    /// Adds a height field to those of the description.
    #[must_use]
    pub fn height_field(mut self, field: HeightField) -> Self {
        self.fields.push(field);
        self
    }

    /// Represents each mesh by the convex hull of the points that `points_of` returns for it, in the shape's
    /// frame \[m\].
    #[must_use]
    pub fn meshes(
        self,
        points_of: impl FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String> + Send + 'a,
    ) -> Self {
        Self { points_of: Box::new(points_of), ..self }
    }

    /// Provides the height fields of the description.
    #[must_use]
    pub fn height_fields(
        self,
        field_of: impl FnMut(&LinkShape) -> Result<HeightField, String> + Send + 'a,
    ) -> Self {
        Self { field_of: Box::new(field_of), ..self }
    }

    /// Replaces the contacts of the description.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, Ground};
    /// use robot_dynamics::description::{Base, LinkDescription, LinkShape, Pose, RobotDescription};
    /// use robot_dynamics::description::{Shape, ShapeRole};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder};
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let ground = ContactSet::new(&model, &[Ground::level(0.0)])?;
    /// let mut simulation = SimulationBuilder::new(&model).contacts(ground).build()?;
    /// // Drop the cube from 20 cm while it turns.
    /// let (q, v) = ([0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0], [0.3, 0.0, 0.0, 1.0, 2.0, 0.0]);
    /// let run = simulation.run_from(&q, &v, 2.0, RunOptions::new())?;
    /// assert!((run.q[2] - 0.05).abs() < 1e-9 && run.v.iter().all(|v| v.abs() < 1e-9)); // at rest on a face
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn contacts(self, contacts: ContactSet) -> Self {
        Self { contacts: Some(contacts), ..self }
    }

    /// Replaces the equalities of the description ([`ConstraintSet::from_equalities`]). At the end of each
    /// step A v = 0, and φ = 0 to 1e-12 m or rad. The constraint forces do no work. A start that violates the
    /// constraints is an error.
    ///
    /// ```
    /// use robot_dynamics::constraints::{ConstraintSet, Coupling};
    /// use robot_dynamics::description::{JointDescription, JointKind, Limits, LinkDescription};
    /// use robot_dynamics::description::{Pose, RobotDescription};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder};
    /// // Two sleds of 1 kg fall. A gear lifts one by half the distance that the other falls, until the
    /// // falling sled meets its stop.
    /// let mut robot = RobotDescription::new("hoist");
    /// robot.links.push(LinkDescription::new("world", None));
    /// for (name, lower) in [("left", -0.2), ("right", -10.0)] {
    ///     let mass = robot_dynamics::description::MassProperties::point(1.0, nalgebra::Vector3::zeros())?;
    ///     robot.links.push(LinkDescription::new(name, mass));
    ///     let kind = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
    ///     let slide = JointDescription::new(name, kind, "world", name, Pose::IDENTITY);
    ///     robot.joints.push(slide.with_limits(Limits::new(lower, 10.0)));
    /// }
    /// let model = Model::new(robot)?;
    /// let gear = Coupling::new(&model, &[("left", 0.5), ("right", 1.0)], 0.0)?;
    /// let gear = ConstraintSet::new(&model, [("gear", gear.into())])?;
    /// let mut simulation = SimulationBuilder::new(&model).constraints(gear).build()?;
    /// let run = simulation.run(1.0, RunOptions::new())?;
    /// assert!((run.q[0] + 0.2).abs() < 1e-8 && (run.q[1] + 0.5 * run.q[0]).abs() < 1e-12); // at rest on the stop, and the gear ratio holds
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn constraints(self, constraints: ConstraintSet) -> Self {
        Self { constraints: Some(constraints), ..self }
    }

    /// Sets the options of explicit and variational steps under equalities.
    #[must_use]
    pub fn constraint_options(self, options: ConstraintOptions, correction: DriftCorrection) -> Self {
        Self { options, correction, ..self }
    }

    /// Sets a flag that interrupts steps and runs, for use by another thread or a signal handler. Soon after
    /// the flag is set, the current step returns
    /// [`IntegratorError::Interrupted`](robot_dynamics_integrators::IntegratorError::Interrupted), and a run
    /// ends. The solvers of implicit, adaptive and MuJoCo's steps check the flag in every loop. The state is
    /// then that of the start of the step; after the flag is cleared, the same step can be taken again.
    /// Copies of the simulation share the flag.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, SimulationBuilder};
    /// use std::sync::Arc;
    /// use std::sync::atomic::{AtomicBool, Ordering};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let flag = Arc::new(AtomicBool::new(true));
    /// let builder = SimulationBuilder::new(&model).method(Method::Implicit);
    /// let mut simulation = builder.interrupt(Arc::clone(&flag)).build()?;
    /// assert!(simulation.step().is_err() && simulation.q() == [0.0]);
    /// flag.store(false, Ordering::Relaxed);
    /// simulation.step()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn interrupt(self, flag: Arc<AtomicBool>) -> Self {
        Self { interrupt: Some(flag), ..self }
    }

    pub(super) fn acts(&self, effect: Effect) -> bool {
        !self.switched_off.contains(&effect)
    }
}

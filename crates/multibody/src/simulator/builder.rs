//! The builder of a simulation: the effects that act, and the method that takes the steps.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[cfg(doc)]
use super::Simulation;
use super::own_stepper::OwnStepper;
use super::{Effect, Method};
#[cfg(feature = "adaptive")]
use crate::AdaptiveOptions;
use crate::constraint::{ConstraintOptions, DriftCorrection};
use crate::{ConstraintSet, ContactSet, Ground, HeightField, LinkShape, Model, Stepper};

/// The step where none is given \[s\].
const STEP: f64 = 1e-3;

/// The projection after each step under equalities leaves less than this \[m or rad\].
const ON_EQUALITIES: f64 = 1e-12;

/// The points of a mesh, or why there are none.
type PointsOf<'a> = Box<dyn FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String> + Send + 'a>;

/// The height field of a shape, or why there is none.
type FieldOf<'a> = Box<dyn FnMut(&LinkShape) -> Result<HeightField, String> + Send + 'a>;

/// Decides what acts in a [`Simulation`] and by which method.
///
/// **What acts**: everything that the description states, unless it is switched off by name ([`without`](Self::without)) or by
/// [`conservative`](Self::conservative). Effects that the chosen method does not support are left out; [`Simulation::left_out`] lists them.
///
/// **The method**, unless one is given: `rk4` where everything is smooth and not stiff, `implicit` elsewhere. [`Simulation::reason`] says why.
///
/// ```
/// use multibody::{Limits, Model, PassiveForces, pendulum};
/// use multibody::simulator::{Method, SimulationBuilder};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3);
/// robot.joints[0].limits = Limits::new(-0.5, 0.5);
/// let model = Model::new(robot)?;
/// let mut simulation = SimulationBuilder::new(&model).build()?; // damping and limits act
/// assert_eq!(simulation.method(), Method::Implicit);
/// simulation.run_for(3.0)?;
/// assert!((simulation.q()[0] - 0.5).abs() < 1e-9); // it hangs on its upper limit
/// let free = SimulationBuilder::new(&model).conservative().build()?;
/// assert_eq!(free.method().name(), "rk4");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SimulationBuilder<'a> {
    pub(super) model: Arc<Model>,
    pub(super) step: f64,
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
    /// For this robot, which is copied.
    pub fn new(model: &Model) -> Self {
        Self::shared(Arc::new(model.clone()))
    }

    /// For this robot, which is shared.
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
    /// use std::sync::Arc;
    /// let model = Arc::new(Model::new(pendulum(2.0, 0.5))?);
    /// let simulation = SimulationBuilder::shared(Arc::clone(&model)).build()?;
    /// assert_eq!(simulation.model().name(), model.name());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn shared(model: Arc<Model>) -> Self {
        Self {
            model,
            step: STEP,
            method: None,
            switched_off: Vec::new(),
            grounds: Vec::new(),
            fields: Vec::new(),
            points_of: Box::new(|_| Err("meshes are not opened".into())),
            field_of: Box::new(|_| Err("files of height fields are not opened".into())),
            contacts: None,
            constraints: None,
            options: ConstraintOptions::of_files(),
            correction: DriftCorrection::Position { tolerance: ON_EQUALITIES },
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

    /// With steps of this length \[s\]; 1 ms where nothing is said.
    #[must_use]
    pub fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// By this method.
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Self { method: Some(method), ..self }
    }

    /// By a method of one's own, which knows what acts beside τ: of what the description states, damping and friction are switched by
    /// [`StepForces::dissipation`](crate::StepForces::dissipation), and effort limits hold.
    ///
    /// ```
    /// use multibody::{CallbackError, Model, StepForces, StepWorkspace, Stepper, forward_dynamics, integrate, pendulum};
    /// use multibody::simulator::{RunOptions, SimulationBuilder};
    ///
    /// /// v₁ = v₀ + h a(q₀, v₀), q₁ = q₀ ⊕ h v₁.
    /// #[derive(Clone)]
    /// struct Euler;
    ///
    /// impl Stepper for Euler {
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
    /// let mut simulation = SimulationBuilder::new(&model).stepper(Euler).step(1e-4).build()?;
    /// let run = simulation.run(1000, RunOptions::new())?;
    /// assert!(run.ledger.drift() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn stepper<S>(self, stepper: S) -> Self
    where
        S: Stepper<Error: Send + Sync + 'static> + Clone + Send + Sync + 'static,
    {
        Self { own: Some(OwnStepper::new(stepper)), method: Some(Method::Own), ..self }
    }

    /// By adaptive steps of high order: the state at each [`step`](Self::step) is as accurate as the tolerance, whatever the step's length, and
    /// events are located as accurately. They know rigid bodies, springs and damping of joints, torques and wrenches; all else is left out, and damping too
    /// where a joint has dry friction.
    ///
    /// A [run](Simulation::run) takes steps across its samples. Without an observer it evaluates the samples alone that are kept.
    ///
    /// ```
    /// use multibody::{AdaptiveOptions, Base, Event, LinkDescription, Model, RobotDescription, neutral};
    /// use multibody::simulator::{RunOptions, SimulationBuilder};
    /// use nalgebra::Vector3;
    /// // A brick thrown up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let options = AdaptiveOptions { tolerance: 1e-12, ..AdaptiveOptions::default() };
    /// let mut simulation = SimulationBuilder::new(&model).adaptive(options).step(0.1).build()?;
    /// simulation.reset(&q, &[0.0, 0.0, 3.0, 0.0, 0.0, 0.0])?;
    /// let run = simulation.run(100, RunOptions::new().events(&mut events))?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "adaptive")]
    #[must_use]
    pub fn adaptive(self, options: AdaptiveOptions) -> Self {
        Self { adaptive: options, method: Some(Method::Adaptive), ..self }
    }

    /// Without this effect.
    ///
    /// ```
    /// use multibody::{Model, PassiveForces, pendulum};
    /// use multibody::simulator::{Effect, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].passive = PassiveForces::default().with_friction(0.3);
    /// let model = Model::new(robot)?;
    /// let simulation = SimulationBuilder::new(&model).without(Effect::Dissipation).build()?;
    /// assert_eq!(simulation.method().name(), "rk4"); // without dry friction all is smooth
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn without(mut self, effect: Effect) -> Self {
        self.switched_off.push(effect);
        self
    }

    /// The textbook's free motion: no damping, friction, limits, actuators or contact. Springs and equalities act, so that K + V is conserved.
    #[must_use]
    pub fn conservative(mut self) -> Self {
        let lossy =
            [Effect::Dissipation, Effect::Limits, Effect::EffortLimits, Effect::Actuators, Effect::Contacts];
        self.switched_off.extend(lossy);
        self
    }

    /// With this half-space under the robot, beside the planes that the description has.
    #[must_use]
    pub fn ground(mut self, ground: Ground) -> Self {
        self.grounds.push(ground);
        self
    }

    /// With this height field under the robot, beside those that the description has.
    #[must_use]
    pub fn height_field(mut self, field: HeightField) -> Self {
        self.fields.push(field);
        self
    }

    /// With meshes as the convex hulls of the points that this gives for a shape, in the shape's frame \[m\].
    #[must_use]
    pub fn meshes(
        self,
        points_of: impl FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String> + Send + 'a,
    ) -> Self {
        Self { points_of: Box::new(points_of), ..self }
    }

    /// With the height fields of the description as this gives them.
    #[must_use]
    pub fn height_fields(
        self,
        field_of: impl FnMut(&LinkShape) -> Result<HeightField, String> + Send + 'a,
    ) -> Self {
        Self { field_of: Box::new(field_of), ..self }
    }

    /// With these contacts instead of those of the description.
    ///
    /// ```
    /// use multibody::{Base, ContactSet, Ground, LinkDescription, LinkShape, Model, Pose, RobotDescription, Shape, ShapeRole};
    /// use multibody::simulator::{RunOptions, SimulationBuilder};
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let ground = ContactSet::new(&model, &[Ground::level(0.0)])?;
    /// let mut simulation = SimulationBuilder::new(&model).contacts(ground).build()?;
    /// // Dropped from 20 cm, turning.
    /// let (q, v) = ([0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0], [0.3, 0.0, 0.0, 1.0, 2.0, 0.0]);
    /// let run = simulation.run_from(&q, &v, 2000, RunOptions::new())?;
    /// assert!((run.q[2] - 0.05).abs() < 1e-9 && run.v.iter().all(|v| v.abs() < 1e-9)); // it lies on its face
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn contacts(self, contacts: ContactSet) -> Self {
        Self { contacts: Some(contacts), ..self }
    }

    /// With these constraints instead of the equalities of the description ([`ConstraintSet::from_equalities`]). At the end of a step A v = 0, and φ = 0 to 1e-12 m or
    /// rad; they do no work. A start that is off is refused.
    ///
    /// ```
    /// use multibody::{ConstraintSet, Coupling, JointDescription, JointKind, Limits, LinkDescription, Model, Pose, RobotDescription};
    /// use multibody::simulator::{RunOptions, SimulationBuilder};
    /// // Two sleds of 1 kg fall, geared so that one rises as the other falls half as far, until the falling one meets its stop.
    /// let mut robot = RobotDescription::new("hoist");
    /// robot.links.push(LinkDescription::new("world", None));
    /// for (name, lower) in [("left", -0.2), ("right", -10.0)] {
    ///     let mass = dynamics::MassProperties::point(1.0, nalgebra::Vector3::zeros())?;
    ///     robot.links.push(LinkDescription::new(name, mass));
    ///     let kind = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
    ///     let slide = JointDescription::new(name, kind, "world", name, Pose::IDENTITY);
    ///     robot.joints.push(slide.with_limits(Limits::new(lower, 10.0)));
    /// }
    /// let model = Model::new(robot)?;
    /// let gear = Coupling::new(&model, &[("left", 0.5), ("right", 1.0)], 0.0)?;
    /// let gear = ConstraintSet::new(&model, [("gear", gear.into())])?;
    /// let mut simulation = SimulationBuilder::new(&model).constraints(gear).build()?;
    /// let run = simulation.run(1000, RunOptions::new())?;
    /// assert!((run.q[0] + 0.2).abs() < 1e-8 && (run.q[1] + 0.5 * run.q[0]).abs() < 1e-12); // at rest on the stop, the gear held
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn constraints(self, constraints: ConstraintSet) -> Self {
        Self { constraints: Some(constraints), ..self }
    }

    /// With these options of explicit and variational steps under equalities.
    #[must_use]
    pub fn constraint_options(self, options: ConstraintOptions, correction: DriftCorrection) -> Self {
        Self { options, correction, ..self }
    }

    /// A step ends with [`IntegratorError::Interrupted`](dynamics::IntegratorError::Interrupted) soon after this flag is set, by another thread or a signal's handler, and a run ends
    /// there. Every loop of the solvers of implicit, adaptive and MuJoCo's steps looks at it. The state is then that of the step's start: with the flag cleared the
    /// same step can be taken again. Copies of the simulation share the flag.
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::{Method, SimulationBuilder}};
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

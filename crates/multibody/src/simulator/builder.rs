//! What acts in a simulation, and by which method its steps are taken.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::acting::Kinds;
use super::method::{SimulationStepper, StepperKind};
use super::{Effect, Method, Simulation, SimulationError};
use crate::constraint::{ConstrainedStepper, ConstraintOptions, DriftCorrection};
use crate::motion::simulate::ActuatedStepper;
use crate::{
    Actuation, ConstraintSet, ContactSet, Ground, HeightField, Implicit, LinkShape, Model, MujocoEuler,
    SoftConstraints,
};

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
/// [`conservative`](Self::conservative). What the chosen method cannot do is left out and listed in [`Simulation::left_out`].
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
    method: Option<Method>,
    switched_off: Vec<Effect>,
    grounds: Vec<Ground>,
    fields: Vec<HeightField>,
    points_of: PointsOf<'a>,
    field_of: FieldOf<'a>,
    contacts: Option<ContactSet>,
    constraints: Option<ConstraintSet>,
    options: ConstraintOptions,
    correction: DriftCorrection,
    interrupt: Option<Arc<AtomicBool>>,
    pub(super) ignored_pairs: Vec<(String, String)>,
    pub(super) only_pairs: Option<Vec<(String, String)>>,
    is_ground_given: bool,
    are_constraints_given: bool,
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
    #[must_use]
    pub fn contacts(self, contacts: ContactSet) -> Self {
        Self { contacts: Some(contacts), ..self }
    }

    /// With these constraints instead of the equalities of the description.
    #[must_use]
    pub fn constraints(self, constraints: ConstraintSet) -> Self {
        Self { constraints: Some(constraints), ..self }
    }

    /// With these options of explicit and variational steps under equalities.
    #[must_use]
    pub fn constraint_options(self, options: ConstraintOptions, correction: DriftCorrection) -> Self {
        Self { options, correction, ..self }
    }

    /// A run ends soon after this flag is set, even in the middle of a long step, which is taken back: as [`Implicit::with_interrupt`].
    #[must_use]
    pub fn interrupt(self, flag: Arc<AtomicBool>) -> Self {
        Self { interrupt: Some(flag), ..self }
    }

    pub(super) fn acts(&self, effect: Effect) -> bool {
        !self.switched_off.contains(&effect)
    }

    /// Sets the simulation up, at the [configuration of the file](Model::initial_configuration) and at rest.
    ///
    /// # Errors
    /// [`SimulationError`]: the step, a ground, a surface or a set of constraints is invalid, or the method does not know what was given.
    pub fn build(mut self) -> Result<Simulation, SimulationError> {
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(SimulationError::Step { step: self.step });
        }
        let model = Arc::clone(&self.model);
        let mut left_out = Vec::new();
        let contacts = self.contact_set(&mut left_out)?;
        self.are_constraints_given = self.constraints.is_some();
        let constraints = match self.constraints.take() {
            Some(constraints) => constraints,
            None if self.acts(Effect::Equalities) => ConstraintSet::from_equalities(&model)?,
            None => ConstraintSet::default(),
        };
        let constraints = Some(constraints).filter(|set| !set.is_empty());
        let actuation = self.actuation()?;
        let link_contacts = contacts.as_ref().is_some_and(|set| set.pairs().next().is_some());
        let touch = (contacts.is_some(), link_contacts);
        let kinds = Kinds::of(&self, touch, constraints.is_some(), actuation.as_ref());
        let (method, reason) = match self.method {
            Some(method) => (method, "as asked for".to_owned()),
            None => kinds.method(&model),
        };
        if let Method::Fixed(row) = method {
            kinds.list_left_out(row, &mut left_out);
        }
        self.check_method(method)?;
        let stepper = self.stepper(method, (contacts.clone(), constraints), actuation.as_ref())?;
        let effort = self
            .acts(Effect::EffortLimits)
            .then(|| model.coordinate_limits().iter().map(|limits| limits.effort).collect::<Vec<f64>>());
        let dissipates = self.acts(Effect::Dissipation);
        // Explicit rows that hold their forces over a step leave the actuators out.
        let actuation =
            actuation.filter(|_| !matches!(stepper.kind, StepperKind::Row(_) | StepperKind::Constrained(_)));
        let acting = kinds.acting(&stepper, effort.as_deref());
        let parts = super::stepping::Parts {
            acting,
            model,
            step: self.step,
            method: (method, reason),
            dissipates,
            effort,
            stepper,
            actuation,
            left_out,
            contacts,
        };
        Ok(Simulation::of_parts(parts))
    }

    /// Refuses a method that does not know what was asked for.
    fn check_method(&self, method: Method) -> Result<(), SimulationError> {
        let problem = match method {
            Method::Fixed(_) if self.is_ground_given => "knows no contact; `implicit` and `mujoco` do",
            Method::Mujoco if self.are_constraints_given => {
                "holds the equalities of the file alone; `implicit` and `rk4` hold others"
            }
            Method::Mujoco if !self.acts(Effect::Limits) => {
                "holds position limits by its law; `implicit` can leave them out"
            }
            Method::Mujoco if !self.acts(Effect::Equalities) => {
                "holds the equalities of the file by its law; `implicit` can leave them out"
            }
            _ => return Ok(()),
        };
        Err(SimulationError::Method { method: method.name(), problem: problem.into() })
    }

    /// The contacts that there can be; `None` where there are none.
    fn contact_set(&mut self, left_out: &mut Vec<String>) -> Result<Option<ContactSet>, SimulationError> {
        let has_ground = !(self.grounds.is_empty() && self.fields.is_empty());
        self.is_ground_given = has_ground || self.contacts.is_some();
        if !self.acts(Effect::Contacts) {
            return if self.is_ground_given { Err(SimulationError::GroundWithoutContacts) } else { Ok(None) };
        }
        let set = if let Some(set) = self.contacts.take() {
            set
        } else {
            let description = self.model.description();
            if description.shapes.is_empty() && !has_ground {
                let set = ContactSet::new(&self.model, &[])?;
                return self.of_pairs(set).map(|_| None);
            }
            let mut set = ContactSet::with_meshes(&self.model, &self.grounds, &mut self.points_of)?
                .with_described_planes(&self.model)?
                .with_described_height_fields(&self.model, &mut self.field_of)?;
            for field in &self.fields {
                set = set.with_height_field(field)?;
            }
            if self.acts(Effect::LinkContacts) { set.with_links(&self.model) } else { set }
        };
        let set = self.of_pairs(set)?;
        if has_ground && !set.has_shapes() {
            let (robot, left_out) = (self.model.name().to_owned(), set.left_out().to_vec());
            return Err(SimulationError::NothingTouches { robot, left_out });
        }
        let has_support = set.ground_count() + set.height_field_count() > 0;
        if has_support {
            left_out.extend(set.left_out().iter().map(|shape| format!("contact with the ground of {shape}")));
        }
        left_out.extend(set.left_out_pairs().iter().map(|pair| format!("contact of {pair}")));
        let touches = (has_support && set.has_shapes()) || set.pairs().next().is_some();
        Ok(Some(set).filter(|_| touches))
    }

    /// What drives the robot beside τ; `None` where nothing does.
    fn actuation(&self) -> Result<Option<Actuation>, SimulationError> {
        let all = Actuation::new(&self.model)?;
        let all = if self.acts(Effect::Actuators) { all } else { all.without_actuators() };
        let all = if self.acts(Effect::Springs) { all } else { all.without_springs() };
        let all = if self.acts(Effect::Dissipation) { all } else { all.without_dissipation() };
        Ok(Some(all).filter(|actuation| !actuation.is_empty()))
    }

    fn stepper(
        &self,
        method: Method,
        (contacts, constraints): (Option<ContactSet>, Option<ConstraintSet>),
        actuation: Option<&Actuation>,
    ) -> Result<SimulationStepper, SimulationError> {
        let model = &*self.model;
        let at_zero = |actuation: &Actuation| vec![0.0; actuation.control_count()];
        let kind = match method {
            Method::Fixed(row) => match (constraints, actuation) {
                (Some(constraints), _) => {
                    let options = ConstraintOptions { integrator: row, ..self.options };
                    let stepper = ConstrainedStepper::new(constraints, options, self.correction);
                    StepperKind::Constrained(Box::new(stepper))
                }
                (None, Some(actuation)) if row.is_explicit() => {
                    StepperKind::Actuated(Box::new(ActuatedStepper::new(actuation.clone(), model.nv(), row)))
                }
                (None, _) => StepperKind::Row(row),
            },
            Method::Implicit => {
                let mut implicit = Implicit::new(model);
                if let Some(flag) = &self.interrupt {
                    implicit = implicit.with_interrupt(Arc::clone(flag));
                }
                if !self.acts(Effect::Limits) {
                    implicit = implicit.without_stops();
                }
                if let Some(contacts) = contacts {
                    implicit = implicit.with_contacts(model, contacts);
                }
                if let Some(constraints) = &constraints {
                    implicit = implicit.with_constraints(model, constraints);
                }
                if let Some(actuation) = actuation {
                    implicit = implicit.with_actuation(actuation, &at_zero(actuation));
                }
                StepperKind::Implicit(Box::new(implicit))
            }
            Method::Mujoco => {
                let impratio = model.description().impratio.unwrap_or(1.0);
                let mut law = SoftConstraints::new(model, self.step)?.with_impratio(impratio);
                if let Some(contacts) = contacts {
                    law = law.with_ground(model, contacts)?;
                }
                let mut stepper = MujocoEuler::new(model, law);
                if let Some(flag) = &self.interrupt {
                    stepper = stepper.with_interrupt(Arc::clone(flag));
                }
                if let Some(actuation) = actuation {
                    stepper = stepper.with_actuation(actuation, &at_zero(actuation));
                }
                StepperKind::Mujoco(Box::new(stepper))
            }
        };
        Ok(SimulationStepper { kind })
    }
}

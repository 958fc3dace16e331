//! Assembles a simulation from its builder.

use robot_dynamics_number::check_positive;
use std::sync::Arc;

use super::active_effects::Kinds;
use super::method::{SimulationStepper, StepperKind};
use super::{Effect, Method, Simulation, SimulationBuilder, SimulationError};
use crate::constraints::{ConstrainedStepper, ConstraintOptions};
use crate::motion::simulate::ActuatedStepper;
#[cfg(feature = "adaptive")]
use crate::motion::simulate::AdaptiveStepper;
use crate::{Actuation, ConstraintSet, ContactSet, ImplicitIntegrator, MujocoEuler, SoftConstraints};

impl SimulationBuilder<'_> {
    /// Builds the simulation at rest in the [initial
    /// configuration](robot_dynamics_core::Model::initial_configuration) of the file.
    ///
    /// # Errors
    /// [`SimulationError`] if the step, a ground, a surface or a set of constraints is invalid, or if the
    /// method does not support a request.
    pub fn build(mut self) -> Result<Simulation, SimulationError> {
        check_positive("the step", self.dt, "s")?;
        let model = Arc::clone(&self.model);
        let mut left_out = Vec::new();
        #[cfg_attr(not(feature = "adaptive"), allow(unused_mut))]
        let mut contacts = self.contact_set(&mut left_out)?;
        self.are_constraints_given = self.constraints.is_some();
        let constraints = match self.constraints.take() {
            Some(constraints) => constraints,
            None if self.acts(Effect::Equalities) => ConstraintSet::from_equalities(&model)?,
            None => ConstraintSet::default(),
        };
        let constraints = Some(constraints).filter(|set| !set.is_empty());
        #[cfg_attr(not(feature = "adaptive"), allow(unused_mut))]
        let mut actuation = self.actuation()?;
        let link_contacts = contacts.as_ref().is_some_and(|set| set.pairs().next().is_some());
        let touch = (contacts.is_some(), link_contacts);
        #[cfg_attr(not(feature = "adaptive"), allow(unused_mut))]
        let mut kinds = Kinds::of(&self, touch, constraints.is_some(), actuation.as_ref());
        #[cfg_attr(not(feature = "adaptive"), allow(unused_mut))]
        let mut dissipates = self.acts(Effect::Dissipation);
        let (method, reason) = match self.method {
            Some(method) => (method, "as asked for".to_owned()),
            None => kinds.method(&model),
        };
        self.check_method(method)?;
        kinds.list_left_out_beside_mujoco(method, &mut left_out);
        match method {
            Method::Fixed(row) => kinds.list_left_out(row, &mut left_out),
            #[cfg(feature = "adaptive")]
            Method::Adaptive => {
                self.adaptive.check()?;
                kinds.list_left_out_by_adaptive(&mut left_out);
                contacts = None;
                if kinds.has_friction() {
                    (kinds, dissipates) = (kinds.without_dissipation(), false);
                    actuation = actuation.map(Actuation::without_dissipation);
                }
            }
            Method::Implicit | Method::Mujoco | Method::Own => {}
        }
        let stepper = self.make_stepper(method, (contacts.clone(), constraints), actuation.as_ref())?;
        let effort = self
            .acts(Effect::EffortLimits)
            .then(|| model.coordinate_limits().iter().map(|limits| limits.effort).collect::<Vec<f64>>());
        // Rows that hold equalities, and rows that hold forces constant over a step, do not evaluate
        // actuators.
        let actuation = actuation.filter(|_| stepper.drives());
        let acting = kinds.acting(&stepper, effort.as_deref());
        let parts = super::stepping::Parts {
            acting,
            model,
            step: self.dt,
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

    /// Returns an error if the method does not support a request.
    fn check_method(&self, method: Method) -> Result<(), SimulationError> {
        let problem = match method {
            Method::Fixed(_) if self.is_ground_given => "knows no contact; `implicit` and `mujoco` do",
            #[cfg(feature = "adaptive")]
            Method::Adaptive if self.is_ground_given => "knows no contact; `implicit` and `mujoco` do",
            #[cfg(feature = "adaptive")]
            Method::Adaptive if self.are_constraints_given => "holds no constraints; `implicit` and `rk4` do",
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

    /// The shapes and grounds that can touch; `None` if nothing can.
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

    /// The actuation that acts in addition to τ; `None` if it is empty.
    fn actuation(&self) -> Result<Option<Actuation>, SimulationError> {
        let all = Actuation::new(&self.model)?;
        let all = if self.acts(Effect::Actuators) { all } else { all.without_actuators() };
        let all = if self.acts(Effect::Springs) { all } else { all.without_springs() };
        let all = if self.acts(Effect::Dissipation) { all } else { all.without_dissipation() };
        Ok(Some(all).filter(|actuation| !actuation.is_empty()))
    }

    fn make_stepper(
        &self,
        method: Method,
        (contacts, constraints): (Option<ContactSet>, Option<ConstraintSet>),
        actuation: Option<&Actuation>,
    ) -> Result<SimulationStepper, SimulationError> {
        let model = &*self.model;
        let at_zero = |actuation: &Actuation| vec![0.0; actuation.activation_count()];
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
                let mut implicit = ImplicitIntegrator::new(model);
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
                    implicit = implicit.with_actuation(model, actuation, &at_zero(actuation));
                }
                StepperKind::Implicit(Box::new(implicit))
            }
            Method::Mujoco => {
                let impratio = model.description().impratio.unwrap_or(1.0);
                let mut law = SoftConstraints::new(model, self.dt)?.with_impratio(impratio);
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
            Method::Own => {
                let problem = || "is one of your own: give it by SimulationBuilder::stepper".to_owned();
                let own = self.own.clone();
                StepperKind::Own(
                    own.ok_or_else(|| SimulationError::Method { method: method.name(), problem: problem() })?,
                )
            }
            #[cfg(feature = "adaptive")]
            Method::Adaptive => {
                let stepper = AdaptiveStepper::new(self.adaptive, self.interrupt.clone());
                StepperKind::Adaptive(Box::new(match actuation {
                    Some(actuation) => stepper.with_actuation(actuation, model.nv()),
                    None => stepper,
                }))
            }
        };
        Ok(SimulationStepper { kind })
    }
}

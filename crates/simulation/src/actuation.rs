//! Forces on the joints from outside the rigid bodies: tendons, actuators, compensated weight of links,
//! springs of ball and floating joints, nonlinear terms, and a fluid.
//!
//! τ = τ_passive(q, v) + τ_actuators(u, q, v) is an input of forward dynamics. None of it is part of M, C or
//! g. Cost: O(joints of the tendons and actuators). Stiff springs and dampers of this kind need implicit
//! steps.

mod affine_forces;
mod carried_weight;
mod controller_memory;
mod coupling;
mod derivatives;
mod difference;
mod dof_gear;
mod gains;
mod law;
mod measurements;
mod pose_spring;
mod power;
mod spatial_tendon;
mod states;
mod tendon;
mod tendon_law;
mod transmission;
mod workspace;

pub use affine_forces::AffineForces;
pub use derivatives::ActuationDerivatives;
pub use workspace::ActuationWorkspace;

use crate::FluidForces;
use carried_weight::CarriedWeight;
use controller_memory::{ControllerMemory, StatePlaces};
use pose_spring::PoseSpring;
use robot_dynamics_core::Model;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_description::{ActuatorDescription, ModelError};
use spatial_tendon::SpatialTendons;
use tendon::Tendon;
use tendon_law::TendonLaw;
use transmission::Drive;

pub(crate) use coupling::Coupling;

/// The tendons, actuators, carried weight and fluid of one robot, ready to be evaluated.
///
/// ```
/// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Actuation;
/// let mut robot = pendulum(2.0, 0.5);
/// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(100.0, 5.0);
/// robot.actuators.push(servo);
/// let model = Model::new(robot)?;
/// let actuation = Actuation::new(&model)?;
/// let (mut memory, mut tau) = (actuation.workspace(), [0.0]);
/// actuation.forces(&model, &mut memory, &[0.5], &[0.2], &[0.1], &mut tau); // control, q, v
/// assert_eq!(tau, [100.0 * (0.5 - 0.2) - 5.0 * 0.1]);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Actuation {
    robot: Identity,
    /// The tendons of the description, in its order, then the joints of one degree of freedom with nonlinear
    /// terms.
    tendons: Vec<Tendon>,
    /// The spatial tendons, if there are any.
    spatial: Option<SpatialTendons>,
    springs: Vec<PoseSpring>,
    actuators: Vec<(ActuatorDescription, Drive)>,
    /// The actuator to whose force the force of each is added.
    leaders: Vec<Option<usize>>,
    /// The places of the states of each actuator.
    places: Vec<StatePlaces>,
    /// Whether some actuator has an integral term or a motor.
    has_controllers: bool,
    weight: Option<CarriedWeight>,
    /// The forces of the fluid, unless they are empty.
    fluid: Option<FluidForces>,
    /// Coordinates with bounds on the sum of their actuators, and the bounds.
    bounded: Vec<(usize, [f64; 2])>,
    /// Coordinates at which the carried weight comes from the actuators.
    by_actuators: Vec<usize>,
    nv: usize,
}

impl Actuation {
    /// Resolves the actuators, tendons and springs of the robot's description.
    ///
    /// # Errors
    /// [`ModelError`] if the carried parts of the links' weights are an invalid robot. A model from a file
    /// does not cause errors.
    pub fn new(model: &Model) -> Result<Self, ModelError> {
        let description = model.description();
        let joints = description.joints.iter();
        let singles = joints.clone().filter(|joint| {
            joint.kind.nv() == 1 && (!joint.higher_terms.is_zero() || joint.spring_yield > 0.0)
        });
        let tendons = (description.tendons.iter().map(|tendon| Tendon::new(model, tendon)))
            .chain(singles.map(|joint| Tendon::of_joint(model, joint)))
            .collect();
        let springs = joints.filter_map(|joint| PoseSpring::new(model, joint)).collect();
        let index = |name: &String| description.actuators.iter().position(|own| own.name == *name);
        let leaders = description.actuators.iter().map(|own| own.adds_to.as_ref().and_then(index)).collect();
        let actuators = description
            .actuators
            .iter()
            .map(|actuator| (actuator.clone(), Drive::new(model, &actuator.transmission)))
            .collect();
        let (mut bounded, mut by_actuators) = (Vec::new(), Vec::new());
        for joint in model.joints() {
            let Some(own) = description.joints.iter().find(|own| own.name == joint.name) else { continue };
            let coordinates = joint.v();
            if own.actuator_force_range != [f64::NEG_INFINITY, f64::INFINITY] {
                bounded.extend(coordinates.clone().map(|coordinate| (coordinate, own.actuator_force_range)));
            }
            if own.actuator_compensates_gravity {
                by_actuators.extend(coordinates);
            }
        }
        Ok(Self {
            robot: model.identity.clone(),
            tendons,
            spatial: SpatialTendons::new(model),
            springs,
            actuators,
            leaders,
            places: controller_memory::places(description.actuators.iter()),
            has_controllers: (description.actuators.iter())
                .any(|own| own.integral.is_some() || own.motor.is_some()),
            weight: CarriedWeight::new(model)?,
            fluid: Some(FluidForces::new(model)).filter(|fluid| !fluid.is_empty()),
            bounded,
            by_actuators,
            nv: model.nv(),
        })
    }

    /// Removes the actuators: tendons, springs and carried weight remain.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    /// let actuation = Actuation::new(&Model::new(robot)?)?;
    /// assert!(!actuation.is_empty() && actuation.without_actuators().is_empty());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn without_actuators(self) -> Self {
        let (actuators, leaders, places) = Default::default();
        Self { actuators, leaders, places, has_controllers: false, bounded: Vec::new(), ..self }
    }

    /// Removes the dry friction of tendons, for laws that treat it as a constraint, such as
    /// [`SoftConstraints`](crate::SoftConstraints).
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, TendonDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut cable = TendonDescription::new("cable", [("hinge".to_owned(), 0.1)]);
    /// cable.passive = PassiveForces::default().with_friction(3.0);
    /// robot.tendons.push(cable);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let mut tau = [0.0];
    /// actuation.forces(&model, &mut actuation.workspace(), &[], &[0.0], &[1.0], &mut tau);
    /// assert!((tau[0] + 0.3).abs() < 1e-15);
    /// let actuation = actuation.without_tendon_friction();
    /// actuation.forces(&model, &mut actuation.workspace(), &[], &[0.0], &[1.0], &mut tau);
    /// assert_eq!(tau[0], 0.0);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn without_tendon_friction(mut self) -> Self {
        self.laws_mut().for_each(TendonLaw::forget_friction);
        self
    }

    /// Removes the dry friction of tendons over joints alone.
    pub(crate) fn without_joint_tendon_friction(mut self) -> Self {
        self.tendons.iter_mut().for_each(|tendon| tendon.law.forget_friction());
        self
    }

    /// Removes the damping and friction of tendons, the damping of springs, and the forces of the fluid.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, TendonDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut cable = TendonDescription::new("cable", [("hinge".to_owned(), 0.1)]);
    /// cable.passive = PassiveForces::default().with_spring(20.0, 0.0).with_damping(3.0);
    /// robot.tendons.push(cable);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?.without_dissipation();
    /// let mut tau = [0.0];
    /// actuation.forces(&model, &mut actuation.workspace(), &[], &[0.5], &[1.0], &mut tau);
    /// assert!((tau[0] + 20.0 * 0.1 * 0.1 * 0.5).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn without_dissipation(mut self) -> Self {
        self.laws_mut().for_each(TendonLaw::forget_dissipation);
        self.springs.iter_mut().for_each(PoseSpring::forget_dissipation);
        self.without_fluid()
    }

    /// Removes the forces of the fluid.
    pub(crate) fn without_fluid(self) -> Self {
        Self { fluid: None, ..self }
    }

    /// The forces of the fluid, if there is one.
    pub(crate) fn fluid(&self) -> Option<&FluidForces> {
        self.fluid.as_ref()
    }

    /// Whether a fluid exerts forces.
    pub(crate) fn has_fluid(&self) -> bool {
        self.fluid.is_some()
    }

    /// Removes the springs of tendons, ball joints and floating joints, and the compensated weight. Actuators
    /// and dissipation stay.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, TendonDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut cable = TendonDescription::new("cable", [("hinge".to_owned(), 0.1)]);
    /// cable.passive = PassiveForces::default().with_spring(20.0, 0.0).with_damping(3.0);
    /// robot.tendons.push(cable);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?.without_springs();
    /// let mut tau = [0.0];
    /// actuation.forces(&model, &mut actuation.workspace(), &[], &[0.5], &[1.0], &mut tau);
    /// assert!((tau[0] + 3.0 * 0.1 * 0.1).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn without_springs(mut self) -> Self {
        self.laws_mut().for_each(TendonLaw::forget_spring);
        Self { springs: Vec::new(), weight: None, by_actuators: Vec::new(), ..self }
    }

    /// The number of controls: one for each actuator, in the description's order.
    pub fn control_count(&self) -> usize {
        self.actuators.len()
    }

    /// The actuators' names, in the order of the controls.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    /// let actuation = Actuation::new(&Model::new(robot)?)?;
    /// assert_eq!(actuation.control_names().collect::<Vec<_>>(), ["motor"]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn control_names(&self) -> impl Iterator<Item = &str> {
        self.actuators.iter().map(|(actuator, _)| actuator.name.as_str())
    }

    /// Whether no such force acts.
    pub fn is_empty(&self) -> bool {
        let has_springs = !(self.tendons.is_empty() && self.spatial.is_none() && self.springs.is_empty());
        !has_springs && self.actuators.is_empty() && self.weight.is_none() && self.fluid.is_none()
    }

    /// Returns memory for the calls, which then do not allocate.
    pub fn workspace(&self) -> ActuationWorkspace {
        let carried = self.weight.as_ref().map(|weight| &weight.model);
        let (spatial, count) = (self.spatial.as_ref(), self.tendon_count());
        let controlled = if self.has_controllers { self.actuators.len() } else { 0 };
        let controllers = ControllerMemory::new(controlled, self.state_count());
        ActuationWorkspace::new((self.nv, self.actuators.len(), count), spatial, controllers, carried)
    }

    /// The number of tendons over joints and along paths.
    fn tendon_count(&self) -> usize {
        self.tendons.len() + self.spatial.as_ref().map_or(0, SpatialTendons::count)
    }

    /// Whether springs yield.
    pub(crate) fn has_yielding_springs(&self) -> bool {
        (0..self.tendon_count()).any(|tendon| self.law(tendon).yields())
    }

    /// Takes over the rest positions of the springs of the same robot.
    pub(crate) fn copy_rest_positions(&mut self, from: &Self) {
        for (number, law) in self.laws_mut().enumerate() {
            law.copy_dead_band(from.law(number));
        }
    }

    fn laws_mut(&mut self) -> impl Iterator<Item = &mut TendonLaw> {
        let over_joints = self.tendons.iter_mut().map(|tendon| &mut tendon.law);
        over_joints.chain(self.spatial.iter_mut().flat_map(SpatialTendons::laws_mut))
    }
}

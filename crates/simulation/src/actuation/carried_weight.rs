//! Links whose weight is wholly or partly compensated from outside the equations.

use robot_dynamics_core::Model;
use robot_dynamics_description::{Base, MassProperties, ModelError, PassiveForces};

/// The robot with only the carried part of each link's mass: its g is the carrying force.
#[derive(Clone, Debug)]
pub(super) struct CarriedWeight {
    /// Same coordinates, other masses.
    pub(super) model: Model,
}

impl CarriedWeight {
    /// `None` if nothing is carried.
    pub(super) fn new(model: &Model) -> Result<Option<Self>, ModelError> {
        let mut robot = model.description().clone();
        if robot.links.iter().all(|link| link.gravity_compensation == 0.0) {
            return Ok(None);
        }
        for link in &mut robot.links {
            let part = core::mem::take(&mut link.gravity_compensation);
            link.mass_properties = link.mass_properties.as_ref().and_then(|body| {
                let (mass, center) = (part * body.mass(), body.center_of_mass());
                MassProperties::as_written(mass, center, body.inertia_about_center_of_mass() * part).ok()
            });
        }
        for joint in &mut robot.joints {
            joint.passive = PassiveForces::default();
        }
        (robot.tendons, robot.equalities, robot.actuators) = (Vec::new(), Vec::new(), Vec::new());
        robot.sensors.clear();
        debug_assert!(matches!(robot.base, Base::Fixed | Base::Floating));
        Ok(Some(Self { model: Model::new(robot)? }))
    }
}

//! The mass of a robot, and the first moment of what does not move.

use nalgebra::{Matrix3, Vector3};

use crate::model::compile::PlacedLink;
use crate::{Model, RobotDescription};

impl Model {
    /// The mass \[kg\] of the links that [`center_of_mass`](crate::center_of_mass) counts: those that move, or all of a robot whose moving
    /// links have no mass. [`total_mass`](Self::total_mass) is that of all links.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("ceiling", &dynamics::MassProperties::point(7.0, [0.0; 3].into())?)?;
    /// let model = Model::new(robot.clone())?;
    /// assert_eq!((model.mass(), model.total_mass()), (2.0, 9.0));
    /// robot.lock_joint("hinge", &[0.0])?;
    /// assert_eq!(Model::new(robot)?.mass(), 9.0); // nothing moves
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mass(&self) -> f64 {
        let moving = self.moving_mass();
        if moving > 0.0 { moving } else { self.mass }
    }

    /// The mass of all links \[kg\], those fixed to the world included.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.total_mass(), 2.0);
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn total_mass(&self) -> f64 {
        self.mass
    }
}

/// Σ m c of the links fixed to the world.
pub(crate) fn fixed_first_moment(description: &RobotDescription, places: &[PlacedLink]) -> [f64; 3] {
    let mut sum = Vector3::zeros();
    for (link, placed) in description.links.iter().zip(places).filter(|(_, at)| at.body.is_none()) {
        if let Some(properties) = &link.mass_properties {
            let r = &placed.body_from_link.rotation;
            let at = Matrix3::from_fn(|i, j| r[i][j]) * properties.center_of_mass();
            sum += (at + Vector3::from(placed.body_from_link.translation)) * properties.mass();
        }
    }
    sum.into()
}

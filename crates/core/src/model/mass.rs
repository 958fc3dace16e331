//! The mass of a robot, and the first moment of its fixed links.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::RobotDescription;

use crate::Model;
use crate::model::placed_link::PlacedLink;

impl Model {
    /// The mass \[kg\] of the links that [`center_of_mass`](crate::center_of_mass) counts: those of the
    /// moving bodies, or all links if these have no mass. [`total_mass`](Self::total_mass) counts all links.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("ceiling", &robot_dynamics::description::MassProperties::point(7.0, [0.0; 3].into())?)?;
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

    /// The mass of all links \[kg\], including those fixed to the world.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.total_mass(), 2.0);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
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

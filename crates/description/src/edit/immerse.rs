//! Puts a robot into a fluid.

use crate::{FluidShape, Medium, RobotDescription};

impl RobotDescription {
    /// Puts the robot into a fluid. Each link with mass that has no fluid shape gets its inertia box. Later
    /// changes of a link's inertia do not change its box.
    ///
    /// ```
    /// use robot_dynamics::description::{Medium, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.immerse(Medium::still(1000.0, 9e-4)); // water
    /// assert_eq!((robot.fluid_shapes.len(), robot.medium.density), (1, 1000.0));
    /// ```
    pub fn immerse(&mut self, medium: Medium) {
        self.medium = medium;
        for link in &self.links {
            let Some(body) = &link.mass_properties else { continue };
            if !self.fluid_shapes.iter().any(|shape| shape.link == link.name) {
                self.fluid_shapes.extend(FluidShape::inertia_box(&link.name, body));
            }
        }
    }
}

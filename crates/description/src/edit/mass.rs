//! Changes of masses, inertias and gravity.

use robot_dynamics_number::{check_number, check_positive, check_result};

use crate::{LinkDescription, MassProperties, ModelError, RobotDescription};

impl RobotDescription {
    /// Attaches a load rigidly to a link. `load` is in the link's frame.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// // 1 kg more at the tip: (m + 1) g l.
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach_payload("rod", &robot_dynamics::description::MassProperties::point(1.0, [0.5, 0.0, 0.0].into())?)?;
    /// let hold = Model::new(robot)?.gravity_forces(&[0.0])?;
    /// assert!((hold[0] + 3.0 * 9.81 * 0.5).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if there is no such link.
    pub fn attach_payload(&mut self, link: &str, load: &MassProperties) -> Result<(), ModelError> {
        let index = self.link_index(link)?;
        let mass_properties = &mut self.links[index].mass_properties;
        *mass_properties = Some(mass_properties.map_or(*load, |own| own.combine(load)));
        Ok(())
    }

    /// Sets the mass, the centre of mass and the inertia of a link, in the link's frame; `None` for a link
    /// without mass.
    ///
    /// ```
    /// use robot_dynamics::description::{MassProperties, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.set_mass_properties("rod", MassProperties::point(3.0, [0.2, 0.0, 0.0].into())?)?;
    /// assert_eq!(robot.links[1].mass_properties.map(|rod| rod.mass()), Some(3.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if there is no such link.
    pub fn set_mass_properties(
        &mut self,
        link: &str,
        mass_properties: impl Into<Option<MassProperties>>,
    ) -> Result<(), ModelError> {
        let index = self.link_index(link)?;
        self.links[index].mass_properties = mass_properties.into();
        Ok(())
    }

    /// Multiplies the mass and the inertia of one link. Its centre of mass stays.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.scale_mass("rod", 1.5)?;
    /// assert_eq!(robot.links[1].mass_properties.map(|rod| rod.mass()), Some(3.0));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if there is no such link, the factor is not positive and finite, or a result is not
    /// finite. The robot is then unchanged.
    pub fn scale_mass(&mut self, link: &str, factor: f64) -> Result<(), ModelError> {
        let index = self.link_index(link)?;
        self.links[index].mass_properties = scaled(&self.links[index], factor)?;
        Ok(())
    }

    /// Multiplies the masses and the inertias of all links. Inertias of rotors (armatures) stay.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.scale_masses(0.5)?;
    /// assert_eq!(Model::new(robot)?.mass(), 1.0);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// As [`scale_mass`](Self::scale_mass).
    pub fn scale_masses(&mut self, factor: f64) -> Result<(), ModelError> {
        let properties: Result<Vec<_>, _> = self.links.iter().map(|link| scaled(link, factor)).collect();
        for (link, properties) in self.links.iter_mut().zip(properties?) {
            link.mass_properties = properties;
        }
        Ok(())
    }

    /// Multiplies gravity: 0 for free flight, 0.38 for Mars.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.scale_gravity(0.0)?; // free flight
    /// assert_eq!(Model::new(robot)?.gravity_forces(&[0.3])?[0], 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] if the factor or the scaled gravity is not finite.
    pub fn scale_gravity(&mut self, factor: f64) -> Result<(), ModelError> {
        let scaled = self.gravity.map(|g| g * factor);
        check_number("the factor of gravity", factor)?;
        check_result("the scaled gravity", &scaled)?;
        self.gravity = scaled;
        Ok(())
    }
}

/// A link's mass properties with mass and inertia multiplied by a factor.
fn scaled(link: &LinkDescription, factor: f64) -> Result<Option<MassProperties>, ModelError> {
    check_positive("the factor of mass", factor, "")?;
    let body = link.mass_properties.as_ref();
    let scaled = body.map(|body| {
        MassProperties::as_written(
            body.mass() * factor,
            body.center_of_mass(),
            body.inertia_about_center_of_mass() * factor,
        )
    });
    scaled.transpose().map_err(|error| ModelError::Inertia { link: link.name.clone(), error })
}

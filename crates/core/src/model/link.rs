//! Links of a compiled robot.

use robot_dynamics_description::{MassProperties, RobotDescription};

/// A link of the model, with its index and the joint that carries it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Link {
    /// The link's name.
    pub name: String,
    /// Its index in [`Model::links`](crate::Model::links) and in the description.
    pub index: usize,
    /// The joint of which it is the child, as an index in [`Model::joints`](crate::Model::joints); `None` for
    /// the root of a robot on a fixed base.
    pub parent_joint: Option<usize>,
    /// Its mass properties in its own frame; `None` without mass.
    pub mass_properties: Option<MassProperties>,
}

impl Link {
    /// Its mass \[kg\], zero without mass properties.
    pub fn mass(&self) -> f64 {
        self.mass_properties.map_or(0.0, |body| body.mass())
    }

    /// Its centre of mass in its own frame \[m\], the origin without mass properties.
    pub fn center_of_mass(&self) -> [f64; 3] {
        self.mass_properties.map_or([0.0; 3], |body| body.center_of_mass().into())
    }

    /// Its rotational inertia about its centre of mass, along its own axes \[kg·m²\].
    pub fn inertia(&self) -> [[f64; 3]; 3] {
        self.mass_properties.map_or([[0.0; 3]; 3], |body| body.inertia_about_center_of_mass().into())
    }
}

/// All links of a description, with the joints that carry them.
pub(crate) fn links(description: &RobotDescription, parent_joints: &[Option<usize>]) -> Vec<Link> {
    let links = description.links.iter().zip(parent_joints).enumerate();
    links
        .map(|(index, (link, &parent_joint))| Link {
            name: link.name.clone(),
            index,
            parent_joint,
            mass_properties: link.mass_properties,
        })
        .collect()
}

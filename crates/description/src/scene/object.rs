//! Rigid bodies of one shape.

use nalgebra::{Matrix3, Rotation3};
use robot_dynamics_number::check_positive;

use crate::{
    Base, LinkDescription, LinkShape, MassProperties, ModelError, Pose, RobotDescription, Shape, ShapeRole,
    Surface,
};

/// A rigid body of one shape: a box on a table, a wall, a floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The name of its link, of its shape and, before `_joint`, of its joint.
    pub name: String,
    /// Its form and size.
    pub shape: Shape,
    /// The shape's frame in the object's frame.
    pub object_from_shape: Pose,
    /// Mass \[kg\], uniformly distributed; `None` for an object that is fixed to the world.
    pub mass: Option<f64>,
    /// Mass properties in the object's frame in place of those of `mass` and `shape`, for example of a mesh.
    pub mass_properties: Option<MassProperties>,
    /// Friction and the other contact parameters.
    pub surface: Surface,
    /// Red, green, blue and opacity, 0 to 1.
    pub color: Option<[f64; 4]>,
}

impl Object {
    /// Geometry that is fixed to the world.
    pub fn fixed(name: impl Into<String>, shape: Shape) -> Self {
        Self {
            name: name.into(),
            shape,
            object_from_shape: Pose::IDENTITY,
            mass: None,
            mass_properties: None,
            surface: Surface::default(),
            color: None,
        }
    }

    /// A free body of this mass \[kg\].
    pub fn of_mass(name: impl Into<String>, shape: Shape, mass: f64) -> Self {
        Self { mass: Some(mass), ..Self::fixed(name, shape) }
    }

    /// A free body of this density \[kg/m³\]. The mass is NaN, which a scene refuses, for shapes without a
    /// volume ([`Shape::volume`]).
    ///
    /// ```
    /// use robot_dynamics::description::{Object, Shape};
    /// let brick = Object::of_density("brick", Shape::Box { size: [0.2, 0.1, 0.1] }, 1000.0);
    /// assert!((brick.mass.expect("a free body") - 2.0).abs() < 1e-14);
    /// ```
    pub fn of_density(name: impl Into<String>, shape: Shape, density: f64) -> Self {
        let mass = density * shape.volume().unwrap_or(f64::NAN);
        Self::of_mass(name, shape, mass)
    }

    /// The half space below z = 0, fixed to the world, with the name `ground`.
    ///
    /// ```
    /// use robot_dynamics::description::{Object, Shape};
    /// assert!(matches!(Object::ground().with_friction(0.6).shape, Shape::Plane { .. }));
    /// ```
    pub fn ground() -> Self {
        Self::fixed("ground", Shape::Plane { half_size: [0.0; 2] })
    }

    /// A box that stands on the plane z = 0 of its frame, such as a table, with these edges along x, y, z
    /// \[m\], fixed to the world.
    ///
    /// ```
    /// use robot_dynamics::description::Object;
    /// let table = Object::table("table", [1.0, 0.6, 0.4]);
    /// assert_eq!(table.object_from_shape.translation, [0.0, 0.0, 0.2]);
    /// ```
    pub fn table(name: impl Into<String>, size: [f64; 3]) -> Self {
        let object_from_shape = Pose::from_translation([0.0, 0.0, 0.5 * size[2]]);
        Self { object_from_shape, ..Self::fixed(name, Shape::Box { size }) }
    }

    /// A wall of this height and thickness \[m\] on the plane z = 0, between two points (x, y), fixed to the
    /// world.
    ///
    /// ```
    /// use robot_dynamics::description::{Object, Shape};
    /// let wall = Object::wall("wall", [[0.0, 1.0], [3.0, 5.0]], 2.5, 0.1);
    /// assert_eq!(wall.shape, Shape::Box { size: [5.0, 0.1, 2.5] });
    /// assert_eq!(wall.object_from_shape.translation, [1.5, 3.0, 1.25]);
    /// ```
    pub fn wall(name: impl Into<String>, [from, to]: [[f64; 2]; 2], height: f64, thickness: f64) -> Self {
        let (along, across) = (to[0] - from[0], to[1] - from[1]);
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), 0.5 * height];
        let object_from_shape = Pose::from_xyz_rpy(middle, [0.0, 0.0, across.atan2(along)]);
        let shape = Shape::Box { size: [along.hypot(across), thickness, height] };
        Self { object_from_shape, ..Self::fixed(name, shape) }
    }

    /// A body with these mass properties in its own frame, for example a mesh.
    ///
    /// ```
    /// use robot_dynamics::description::{MassProperties, Object, Shape};
    /// let body = MassProperties::point(1.0, [0.0, 0.0, 0.05].into())?;
    /// let mug = Object::with_mass_properties("mug", Shape::mesh("mug.stl"), body);
    /// assert_eq!(mug.mass_properties.map(|body| body.mass()), Some(1.0));
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn with_mass_properties(
        name: impl Into<String>,
        shape: Shape,
        mass_properties: MassProperties,
    ) -> Self {
        Self { mass_properties: Some(mass_properties), ..Self::fixed(name, shape) }
    }

    /// With this coefficient of sliding friction.
    pub fn with_friction(mut self, friction: f64) -> Self {
        self.surface.friction[0] = friction;
        self
    }

    /// Whether it has a mass, so that it can move.
    pub(super) fn has_mass(&self) -> bool {
        self.mass.is_some() || self.mass_properties.is_some()
    }

    /// With these contact parameters.
    pub fn with_surface(self, surface: Surface) -> Self {
        Self { surface, ..self }
    }

    /// With this colour: red, green, blue and opacity, 0 to 1.
    pub fn with_color(self, color: [f64; 4]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// A robot of one link.
    pub(super) fn description(&self) -> Result<RobotDescription, ModelError> {
        let Self { name, shape, object_from_shape, mass, mass_properties, surface, color } = self;
        let mass_properties = match (mass_properties, mass) {
            (Some(given), _) => Some(*given),
            (None, None) => None,
            (None, Some(mass)) => {
                let volume = shape.volume().unwrap_or(f64::NAN);
                check_positive(&format!("the mass of object `{name}`"), *mass, "kg")?;
                check_positive(&format!("the volume of object `{name}`"), volume, "m³")?;
                let solid = shape.solid(mass / volume).transpose();
                let solid = solid.map_err(|error| ModelError::Inertia { link: name.clone(), error })?;
                solid.map(|body| placed(&body, object_from_shape))
            }
        };
        let mut robot = RobotDescription::new(name);
        robot.base = if self.has_mass() { Base::Floating } else { Base::Fixed };
        robot.links.push(LinkDescription::new(name, mass_properties));
        robot.shapes.push(LinkShape {
            name: name.clone(),
            color: *color,
            surface: *surface,
            ..LinkShape::new(name, ShapeRole::Collision, *object_from_shape, shape.clone())
        });
        Ok(robot)
    }
}

/// A shape's mass properties in the object's frame.
fn placed(body: &MassProperties, object_from_shape: &Pose) -> MassProperties {
    if *object_from_shape == Pose::IDENTITY {
        return *body;
    }
    let [x, y, z] = object_from_shape.rotation;
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&[x, y, z].concat()));
    body.transformed(&rotation, &object_from_shape.translation.into())
}

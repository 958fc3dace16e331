//! Height fields in a contact set.

use robot_dynamics_core::Model;
use robot_dynamics_description::{LinkShape, Shape, Surface};
use robot_dynamics_number::InvalidInput;

use super::ContactSet;
use super::field::{HeightField, PlacedField};
use super::plane::{meets_bare, takes_part};
use super::shape_checks::described;

impl ContactSet {
    /// Adds a height field to the grounds.
    ///
    /// In [`ContactPoint::ground`](crate::ContactPoint::ground) height fields are counted after the
    /// half-spaces.
    ///
    /// # Errors
    /// [`InvalidInput`]: its friction, restitution or pose is invalid.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, HeightField};
    /// use robot_dynamics::description::{Base, LinkDescription, LinkShape, Pose, RobotDescription};
    /// use robot_dynamics::description::{Shape, ShapeRole};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{RunOptions, SimulationBuilder};
    /// let mut robot = RobotDescription::new("ball");
    /// robot.base = Base::Floating;
    /// let mass = robot_dynamics::description::MassProperties::new(1.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity() * 4e-3)?;
    /// robot.links.push(LinkDescription::new("ball", mass));
    /// robot.shapes.push(LinkShape::new("ball", ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius: 0.1 }));
    /// let model = Model::new(robot)?;
    /// // A valley along y, 45 degrees on both sides.
    /// let valley = HeightField::new(2, 3, [1.0, 1.0], vec![1.0, 0.0, 1.0, 1.0, 0.0, 1.0])?;
    /// let contacts = ContactSet::new(&model, &[])?.with_height_field(&valley)?;
    /// let mut simulation = SimulationBuilder::new(&model).contacts(contacts).build()?;
    /// let q = [0.0, 0.0, 0.15, 0.0, 0.0, 0.0, 1.0];
    /// let run = simulation.run_from(&q, &[0.0; 6], 0.5, RunOptions::new())?;
    /// assert!((run.q[2] - 0.1 * 2.0f64.sqrt()).abs() < 1e-6); // it lies on both sides
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_height_field(mut self, field: &HeightField) -> Result<Self, InvalidInput> {
        let surfaces = field.surface.map(|own| self.surfaces_with(&own, None, &[]));
        self.add_field(field, surfaces, None)?;
        Ok(self)
    }

    fn add_field(
        &mut self,
        field: &HeightField,
        surfaces: Option<Vec<Option<Surface>>>,
        described: Option<&LinkShape>,
    ) -> Result<(), InvalidInput> {
        field.check()?;
        self.fields.push(PlacedField::new(field, surfaces, described));
        let index = self.fields.len() - 1;
        self.let_touch_ground(|set, shape| set.meets_field(shape, index));
        Ok(())
    }

    /// Whether a shape touches a height field: by a pair, or by the masks.
    pub(super) fn meets_field(&self, shape: usize, field: usize) -> bool {
        match &self.fields[field].surfaces {
            Some(surfaces) => surfaces[shape].is_some(),
            None => meets_bare(&self.shapes[shape]),
        }
    }

    /// Adds the height fields that the robot's description has among the collision shapes fixed to the world.
    /// Each is in the frame of its shape, with the heights and surface that `field_of` returns; without a
    /// surface, it has the shape's. If `field_of` returns a reason instead, it is listed in
    /// [`left_out`](Self::left_out). A height field touches a shape if a bit of one's `contype` is in the
    /// other's `conaffinity`, with MuJoCo's mix of both surfaces. It also touches a shape that the
    /// description pairs with it, with the pair's surface.
    ///
    /// # Errors
    /// As [`with_height_field`](Self::with_height_field).
    ///
    /// # Panics
    /// If the set belongs to another robot.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, HeightField};
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let base = robot.links[0].name.clone();
    /// let hills = Shape::HeightField { name: "hills".into(), file: None, size: [1.0, 1.0, 0.5, 0.1], elevation: None };
    /// let below = Pose::from_translation([0.0, 0.0, -2.0]);
    /// robot.shapes.push(LinkShape::new(base, ShapeRole::Collision, below, hills));
    /// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius: 0.5 }));
    /// let model = Model::new(robot)?;
    /// let flat = |_: &LinkShape| HeightField::new(2, 2, [1.0, 1.0], vec![0.5; 4]).map_err(|error| error.to_string());
    /// let contacts = ContactSet::new(&model, &[])?.with_described_height_fields(&model, flat)?;
    /// assert_eq!(contacts.clearance(&model, &mut Workspace::new(&model), &[0.0]), Some(1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn with_described_height_fields(
        mut self,
        model: &Model,
        mut field_of: impl FnMut(&LinkShape) -> Result<HeightField, String>,
    ) -> Result<Self, InvalidInput> {
        model.check_identity(&self.robot, "the contact set");
        for shape in &model.description().shapes {
            let Some(frame) = model.frame(&shape.link).map(|frame| model.frame_of(frame)) else { continue };
            if !matches!(shape.shape, Shape::HeightField { .. }) || !takes_part(model, shape) {
                continue;
            }
            let field = match frame.body {
                None => field_of(shape),
                Some(_) => Err("a height field does not move".into()),
            };
            match field {
                Ok(field) => {
                    let pose = frame.body_from_frame.compose(&shape.link_from_shape);
                    let surface = field.surface.unwrap_or(shape.surface);
                    let field = field.with_pose(pose).with_surface(surface);
                    let exclusions = &model.description().contact_exclusions;
                    let surfaces = self.surfaces_with(&surface, Some(shape), exclusions);
                    self.add_field(&field, Some(surfaces), Some(shape))?;
                }
                Err(reason) => self.left_out.push(format!("{}: {reason}", described(shape))),
            }
        }
        Ok(self)
    }

    /// The number of height fields.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// assert_eq!(ContactSet::new(&Model::new(pendulum(2.0, 0.5))?, &[])?.height_field_count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn height_field_count(&self) -> usize {
        self.fields.len()
    }
}

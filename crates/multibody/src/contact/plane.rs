//! Half-spaces as grounds: those given, and the planes of the robot's description.

use super::soft::mixed;
use super::{ContactError, ContactSet, Ground, Touching};
use crate::{Model, Shape, ShapeRole, Surface};

impl ContactSet {
    /// With a half-space as a further ground.
    ///
    /// # Errors
    /// [`ContactError`]: a number of the ground is invalid.
    pub(super) fn add_ground(&mut self, ground: Ground, name: String) -> Result<(), ContactError> {
        ground.check()?;
        let mixes = |own: Surface| self.shapes.iter().map(|shape| mixed(&shape.surface, &own)).collect();
        self.ground_surfaces.push(ground.surface.map(mixes));
        self.ground_names.push(name);
        self.grounds.push((ground, ground.axes()));
        Ok(())
    }

    /// With the planes that the description fixes to the world as grounds, each with its own surface and masks.
    ///
    /// A plane touches a shape where a bit of one's `contype` is in the other's `conaffinity`. The surface of both together is MuJoCo's mix.
    /// Planes on links that move are listed in [`left_out`](Self::left_out).
    ///
    /// ```
    /// use multibody::{ContactSet, LinkShape, Model, Pose, Shape, ShapeRole, Workspace, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let ball = Shape::Sphere { radius: 0.1 };
    /// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::from_translation([0.5, 0.0, 0.0]), ball));
    /// let floor = Shape::Plane { half_size: [0.0; 2] };
    /// let at = Pose::from_translation([0.0, 0.0, -1.0]);
    /// robot.shapes.push(LinkShape::new("ceiling", ShapeRole::Collision, at, floor));
    /// let model = Model::new(robot)?;
    /// let contacts = ContactSet::new(&model, &[])?.with_described_planes(&model)?;
    /// assert_eq!(contacts.clearance(&model, &mut Workspace::new(&model), &[0.0]), Some(0.9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ContactError::Surface`]: a number of the plane's surface is not finite.
    ///
    /// # Panics
    /// If the set is another robot's.
    #[track_caller]
    pub fn with_described_planes(mut self, model: &Model) -> Result<Self, ContactError> {
        self.robot.check(model, "the contact set");
        for shape in &model.description().shapes {
            let is_plane = matches!(shape.shape, Shape::Plane { .. });
            let masks = shape.surface.contype | shape.surface.conaffinity;
            let is_paired =
                model.description().contact_pairs.iter().any(|pair| pair.shapes.contains(&shape.name));
            let Some(frame) = model.frame(&shape.link).map(|frame| model.frame_of(frame)) else { continue };
            if !is_plane || shape.role != ShapeRole::Collision || (masks == 0 && !is_paired) {
                continue;
            }
            if frame.body.is_some() {
                self.left_out.push(format!("{}: a plane does not move", super::described(shape)));
                continue;
            }
            let pose = frame.body_from_frame.compose(&shape.link_from_shape);
            let normal = pose.rotation.map(|row| row[2]);
            let ground = Ground::through(pose.translation, normal)?.with_surface(shape.surface);
            self.add_ground(ground, shape.name.clone())?;
            for index in 0..self.shapes.len() {
                self.let_touch_ground(index, &ground);
            }
        }
        Ok(self)
    }

    /// How many half-spaces there are.
    ///
    /// ```
    /// use multibody::{ContactSet, Ground, Model, pendulum};
    /// let contacts = ContactSet::new(&Model::new(pendulum(2.0, 0.5))?, &[Ground::level(0.0)])?;
    /// assert_eq!(contacts.ground_count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn ground_count(&self) -> usize {
        self.grounds.len()
    }

    /// Counts the shape's link among those that touch the ground, if its masks let it touch this one.
    fn let_touch_ground(&mut self, index: usize, ground: &Ground) {
        let shape = &self.shapes[index];
        if shape.on_ground.is_some() || shape.body == crate::model::WORLD || !meets(shape, ground) {
            return;
        }
        let link = shape.link.clone();
        let number = self.links.iter().position(|own| *own == link).unwrap_or(self.links.len());
        if number == self.links.len() {
            self.links.push(link);
        }
        self.shapes[index].on_ground = Some(number);
    }
}

/// Whether the masks let a shape touch a ground; a ground without a surface of its own has bit 1 of both.
pub(super) fn meets(shape: &Touching, ground: &Ground) -> bool {
    let own = &shape.surface;
    let (contype, conaffinity) = ground.surface.map_or((1, 1), |other| (other.contype, other.conaffinity));
    shape.on_plane.is_some() || (own.contype & conaffinity) | (contype & own.conaffinity) != 0
}

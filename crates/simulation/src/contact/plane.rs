//! Half-spaces as grounds: given ones, and the planes of the robot's description.

use robot_dynamics_core::Model;
use robot_dynamics_description::{LinkShape, Shape, ShapeRole, Surface};
use robot_dynamics_number::InvalidInput;

use super::contact_shape::ContactShape;
use super::soft::mixed;
use super::{ContactSet, Ground};

impl ContactSet {
    /// Adds a half-space to the grounds.
    ///
    /// # Errors
    /// [`InvalidInput`]: a number of the ground is invalid.
    pub(super) fn add_ground(
        &mut self,
        model: &Model,
        ground: Ground,
        plane: Option<&LinkShape>,
    ) -> Result<(), InvalidInput> {
        ground.check()?;
        let exclusions = &model.description().contact_exclusions;
        self.ground_surfaces.push(ground.surface.map(|own| self.surfaces_with(&own, plane, exclusions)));
        self.ground_names.push(plane.map_or_else(String::new, |plane| plane.name.clone()));
        self.ground_links.push(plane.map_or_else(String::new, |plane| plane.link.clone()));
        self.has_moving_surfaces |= !ground.surface_velocity.is_zero();
        self.grounds.push((ground, ground.axes()));
        let index = self.grounds.len() - 1;
        self.let_touch_ground(|set, shape| set.meets_ground(shape, index));
        Ok(())
    }

    /// The surface of each shape's contact with a ground of this surface. It is that of their pair, otherwise
    /// the mix of both if their masks let them touch. `described` is the ground's shape, if the robot's
    /// description has it. Shapes of links that never touch its link have no surface, unless they are paired
    /// with it.
    pub(super) fn surfaces_with(
        &self,
        own: &Surface,
        described: Option<&LinkShape>,
        exclusions: &[(String, String)],
    ) -> Vec<Option<Surface>> {
        let is_excluded = |link: &str| {
            let is = |one: &str, two: &str| described.is_some_and(|ground| ground.link == one) && link == two;
            exclusions.iter().any(|(one, two)| is(one, two) || is(two, one))
        };
        let of = |shape: &ContactShape| {
            let is_meant = |name: &str| described.is_none_or(|ground| ground.name == name);
            let pair = shape.on_grounds.iter().find(|(name, _)| is_meant(name)).map(|(_, surface)| *surface);
            let touches = || have_common_bits(&shape.surface, own) && !is_excluded(&shape.link);
            pair.or_else(|| touches().then(|| mixed(&shape.surface, own)))
        };
        self.shapes.iter().map(of).collect()
    }

    /// Whether a shape touches a ground: by a pair, or by the masks.
    pub(super) fn meets_ground(&self, shape: usize, ground: usize) -> bool {
        match &self.ground_surfaces[ground] {
            Some(surfaces) => surfaces[shape].is_some(),
            None => meets_bare(&self.shapes[shape]),
        }
    }

    /// Adds the planes that the description fixes to the world as grounds, each with its own surface and
    /// masks.
    ///
    /// A plane touches a shape if a bit of one's `contype` is in the other's `conaffinity`. Their contact has
    /// MuJoCo's mix of both surfaces. Planes on moving links are listed in [`left_out`](Self::left_out).
    ///
    /// ```
    /// use robot_dynamics::contact::ContactSet;
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
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
    /// [`InvalidInput`]: a number of the plane's surface is not finite.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn with_described_planes(mut self, model: &Model) -> Result<Self, InvalidInput> {
        model.check_identity(&self.robot, "the contact set");
        for shape in &model.description().shapes {
            let Some(frame) = model.frame(&shape.link).map(|frame| model.frame_of(frame)) else { continue };
            if !matches!(shape.shape, Shape::Plane { .. }) || !takes_part(model, shape) {
                continue;
            }
            if frame.body.is_some() {
                self.left_out.push(format!("{}: a plane does not move", super::described(shape)));
                continue;
            }
            let pose = frame.body_from_frame.compose(&shape.link_from_shape);
            let normal = pose.rotation.map(|row| row[2]);
            let ground = Ground::through(pose.translation, normal)?
                .with_surface(shape.surface)
                .with_surface_velocity(shape.surface_velocity.in_frame(&pose));
            self.add_ground(model, ground, Some(shape))?;
        }
        Ok(self)
    }

    /// The number of half-spaces.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, Ground};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let contacts = ContactSet::new(&Model::new(pendulum(2.0, 0.5))?, &[Ground::level(0.0)])?;
    /// assert_eq!(contacts.ground_count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn ground_count(&self) -> usize {
        self.grounds.len()
    }

    /// Adds the links of shapes that touch a ground to the links that touch one.
    pub(super) fn let_touch_ground(&mut self, touches: impl Fn(&Self, usize) -> bool) {
        for index in 0..self.shapes.len() {
            let shape = &self.shapes[index];
            if shape.on_ground.is_some()
                || shape.body == robot_dynamics_core::model::WORLD
                || !touches(self, index)
            {
                continue;
            }
            let link = shape.link.clone();
            let number = self.links.iter().position(|own| *own == link).unwrap_or(self.links.len());
            if number == self.links.len() {
                self.links.push(link);
            }
            self.shapes[index].on_ground = Some(number);
        }
    }
}

/// Whether anything can touch a shape of the description: it is for collisions, and a mask or a pair permits
/// it.
pub(super) fn takes_part(model: &Model, shape: &LinkShape) -> bool {
    let is_paired = || model.description().contact_pairs.iter().any(|pair| pair.shapes.contains(&shape.name));
    let masks = shape.surface.contype | shape.surface.conaffinity;
    shape.role == ShapeRole::Collision && (masks != 0 || is_paired())
}

/// Whether a shape touches a ground or height field without a surface. Such a ground has bit 1 of both masks,
/// and represents the planes and height fields that shapes are paired with.
pub(super) fn meets_bare(shape: &ContactShape) -> bool {
    !shape.on_grounds.is_empty() || have_common_bits(&shape.surface, &Surface::default())
}

fn have_common_bits(one: &Surface, two: &Surface) -> bool {
    (one.contype & two.conaffinity) | (two.contype & one.conaffinity) != 0
}

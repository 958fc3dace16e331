//! Height fields: uneven ground as heights on a grid.

mod closest_points;
mod contact_detection;
mod ellipsoid;
mod facets;

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{LinkShape, Pose, Surface, SurfaceVelocity};
use robot_dynamics_number::InvalidInput;

use self::facets::Facets;
use super::Ground;
use super::ground::bad_surface;

/// Heights on a grid over a rectangle. The ground is below each cell's two triangles, and bodies do not enter
/// it from above.
///
/// In its own frame the rectangle is [−X, X] × [−Y, Y] and z points up. Row r and column c of the grid are at
///
/// x = X (2c/(columns − 1) − 1), y = Y (2r/(rows − 1) − 1), z = `heights[r * columns + c]`,
///
/// A cell is divided along the diagonal from its corner of least x and y to that of the largest, as in
/// MuJoCo. The ground ends at the rectangle. Triangles in one plane count as one face, so a flat
/// field equals the plane.
///
/// | shape | how it touches |
/// | --- | --- |
/// | ball, ellipsoid, the two ends of a capsule | where it is nearest to each face, edge and corner nearby: exact |
/// | box, convex mesh | its corners, each above the face below it, along that face's normal |
/// | cylinder | the lowest point of the rim of each end, by each face's normal; eight points of the rim where that is not above the face |
///
/// The search misses ridges and peaks of the field between the corners of a box or a mesh, or between the
/// ends of a capsule. It also misses those inside a cylinder. Use cells larger than such shapes, or balls
/// along them. A corner in a valley touches all faces that meet there.
///
/// ```
/// use robot_dynamics::contact::{ContactSet, HeightField};
/// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // A valley along y, 45 degrees on both sides, its bottom at x = 0, z = −2.
/// let field = HeightField::new(2, 3, [1.0, 1.0], vec![1.0, 0.0, 1.0, 1.0, 0.0, 1.0])?;
/// let field = field.with_pose(Pose::from_translation([0.0, 0.0, -2.0])).with_friction(0.8);
/// assert_eq!(field.height(0.25, 0.3), Some(0.25));
/// // A ball about the pendulum's pivot is √2 away from each side, less its radius.
/// let mut robot = pendulum(2.0, 0.5);
/// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius: 0.5 }));
/// let model = Model::new(robot)?;
/// let contacts = ContactSet::new(&model, &[])?.with_height_field(&field)?;
/// let clearance = contacts.clearance(&model, &mut Workspace::new(&model), &[0.0]).unwrap();
/// assert!((clearance - (2.0f64.sqrt() - 0.5)).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct HeightField {
    /// The pose of the field's frame in the world.
    pub world_from_field: Pose,
    /// μ of every contact with it. `None`: it follows from the field's and the shape's surface, or without a
    /// field's surface from the shape's.
    pub friction: Option<f64>,
    /// The field's surface, which mixes with a shape's surface like those of two shapes. `None`: the shape's
    /// surface counts.
    pub surface: Option<Surface>,
    /// e: the fraction of its normal speed with which a body rebounds; 0 if it does not bounce.
    pub restitution: f64,
    facets: Arc<Facets>,
}

impl HeightField {
    /// A field with this number of rows (along y) and columns (along x) of heights \[m\], row by row. It
    /// covers the rectangle of these half lengths X and Y \[m\] in the world's frame.
    ///
    /// # Errors
    /// [`InvalidInput`]: fewer than two rows or columns, a rectangle without area, a number of
    /// heights other than rows times columns, or a height that is not finite.
    ///
    /// ```
    /// use robot_dynamics::contact::HeightField;
    /// let field = HeightField::new(2, 2, [0.5, 1.0], vec![0.0, 0.2, 0.0, 0.6])?; // x rises to the right, y to the back
    /// assert_eq!(field.height(0.5, 0.0), Some(0.4));
    /// assert!(HeightField::new(2, 2, [0.5, 1.0], vec![0.0; 3]).is_err());
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn new(
        rows: usize,
        columns: usize,
        half_size: [f64; 2],
        heights: Vec<f64>,
    ) -> Result<Self, InvalidInput> {
        if rows < 2 || columns < 2 {
            return Err(field_must("number of rows and of columns", "must be 2 or more"));
        }
        if !half_size.iter().all(|half| half.is_finite() && *half > 0.0) {
            return Err(field_must("half lengths", "must be finite and above 0"));
        }
        if rows.checked_mul(columns) != Some(heights.len()) {
            return Err(field_must("heights", "must be as many as rows times columns"));
        }
        if heights.iter().any(|height| !height.is_finite()) {
            return Err(field_must("heights", "must be finite"));
        }
        let facets = Arc::new(Facets::new([rows, columns], half_size, heights));
        let world_from_field = Pose::IDENTITY;
        Ok(Self { world_from_field, friction: None, surface: None, restitution: 0.0, facets })
    }

    /// Sets the pose of the field's frame in the world.
    ///
    /// ```
    /// use robot_dynamics::contact::HeightField;
    /// use robot_dynamics::description::Pose;
    /// let field = HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4])?.with_pose(Pose::from_translation([0.0, 0.0, 0.3]));
    /// assert_eq!(field.world_from_field.translation[2], 0.3);
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn with_pose(self, world_from_field: Pose) -> Self {
        Self { world_from_field, ..self }
    }

    /// Sets the coefficient of friction of every contact.
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction: Some(friction), ..self }
    }

    /// Sets the surface: the surface of the higher priority counts, otherwise the larger friction and
    /// `condim` and a mean of the softness.
    ///
    /// ```
    /// use robot_dynamics::contact::HeightField;
    /// use robot_dynamics::description::Surface;
    /// let mut ice = Surface::default();
    /// (ice.friction[0], ice.priority) = (0.05, 1); // whatever stands on it
    /// let field = HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4])?.with_surface(ice);
    /// assert_eq!(field.surface.map(|surface| surface.friction[0]), Some(0.05));
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn with_surface(self, surface: Surface) -> Self {
        Self { surface: Some(surface), ..self }
    }

    /// Sets the restitution: the fraction, 0 to 1, of its normal speed with which a body rebounds.
    pub fn with_restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }

    /// The height of the surface at (x, y), in the field's frame \[m\]; `None` outside the rectangle.
    ///
    /// ```
    /// // One corner of a cell is raised: the diagonal that ends in it rises, the other is a crease.
    /// let field = robot_dynamics::contact::HeightField::new(2, 2, [1.0, 1.0], vec![0.0, 0.0, 0.0, 1.0])?;
    /// assert_eq!([field.height(0.0, 0.0), field.height(0.5, -0.5)], [Some(0.5), Some(0.25)]);
    /// assert_eq!(field.height(1.5, 0.0), None);
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let triangle = self.facets.under(&Vector3::new(x, y, 0.0))?;
        let [a, b, c] = self.facets.corners(triangle);
        let n = (b - a).cross(&(c - a));
        Some(a.z - (n.x * (x - a.x) + n.y * (y - a.y)) / n.z)
    }

    /// Returns an error if a number is invalid.
    pub(super) fn check(&self) -> Result<(), InvalidInput> {
        let ground = Ground { friction: self.friction, restitution: self.restitution, ..Ground::level(0.0) };
        ground.check()?;
        if let Some(quantity) = self.surface.and_then(|surface| surface.not_finite()) {
            return Err(bad_surface("a height field", quantity));
        }
        let Pose { rotation, translation } = self.world_from_field;
        let rotation = Matrix3::from_fn(|i, j| rotation[i][j]);
        let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        if !(off < 1e-9 && rotation.determinant() > 0.0 && translation.iter().all(|x| x.is_finite())) {
            return Err(field_must("pose", "must be a finite rotation and translation"));
        }
        Ok(())
    }
}

/// The error of a part of a height field that does not meet a requirement.
fn field_must(part: &str, requirement: &str) -> InvalidInput {
    InvalidInput::unmet(format!("a height field's {part}"), requirement)
}

/// A field of a set.
#[derive(Clone, Debug)]
pub(super) struct PlacedField {
    pub(super) friction: Option<f64>,
    pub(super) restitution: f64,
    /// The link that it is on, if it comes from the description; otherwise empty.
    pub(super) link: String,
    /// The name of its shape, likewise.
    pub(super) name: String,
    /// If it has a surface, the mixed surface with each shape; `None` for shapes that it does not touch.
    pub(super) surfaces: Option<Vec<Option<Surface>>>,
    /// The motion of its surface in the world.
    pub(super) surface_velocity: SurfaceVelocity,
    /// `world_from_field`.
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
    facets: Arc<Facets>,
}

impl PlacedField {
    pub(super) fn new(
        field: &HeightField,
        surfaces: Option<Vec<Option<Surface>>>,
        described: Option<&LinkShape>,
    ) -> Self {
        let Pose { rotation, translation } = field.world_from_field;
        let (link, name) =
            described.map(|shape| (shape.link.clone(), shape.name.clone())).unwrap_or_default();
        let surface_velocity = described.map(|shape| shape.surface_velocity).unwrap_or_default();
        let surface_velocity = surface_velocity.in_frame(&field.world_from_field);
        Self {
            link,
            name,
            friction: field.friction,
            restitution: field.restitution,
            surfaces,
            surface_velocity,
            rotation: Matrix3::from_fn(|i, j| rotation[i][j]),
            origin: translation.into(),
            facets: Arc::clone(&field.facets),
        }
    }

    /// A point of the world in the field's frame.
    fn inward(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(at - self.origin))
    }

    /// The largest margin of these surfaces.
    pub(super) fn margin(&self) -> f64 {
        self.surfaces.iter().flatten().flatten().map(|surface| surface.margin).fold(0.0, f64::max)
    }

    /// The number of its faces.
    pub(super) fn count(&self) -> usize {
        self.facets.planes.len()
    }
}

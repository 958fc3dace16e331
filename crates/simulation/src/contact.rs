//! Contact: the search for contact points, and the convex problem of the contact forces.
//!
//! A contact with the gap g, the velocity c and the impulse p has c_n ≥ 0, p_n ≥ 0, p_n c_n = 0 (Signorini)
//! and |p_t| ≤ μ p_n, with p_t against c_t where it slides (Coulomb). `cone_problem` has the equations, the
//! algorithm and its sources.
//!
//! 1. `candidates` finds pairs of shapes that are near each other, by a sweep along one axis.
//! 2. `form`, `closest`, `field` and `convex` compute contact points. Each has a number that stays the same
//!    from step to step.
//! 3. `cone_problem` computes the impulses of all contacts, limits, friction and equalities. `soft` computes
//!    the forces of MuJoCo's law instead.
//!
//! Cost: each Newton step factors a matrix with the zeros of M. Contacts are tested at the ends of steps
//! only, so a fast body can pass another within one step.

mod broad_phase;
mod candidates;
mod closest_points;
mod components;
pub mod cone_problem;
mod contact_detection;
mod contact_geometry;
mod contact_search;
mod contact_shape;
#[cfg(feature = "convex")]
#[path = "contact/convex/parry.rs"]
mod convex;
#[cfg(not(feature = "convex"))]
#[path = "contact/convex/stub.rs"]
mod convex;
mod described_pairs;
mod field;
mod field_contacts;
mod ground;
mod impulses;
mod interrupt;
mod law;
mod link_contacts;
mod link_distances;
mod link_pairs;
mod moving_surface;
mod named_pairs;
mod pair;
mod pair_points;
mod placed_pair;
mod placed_shape;
mod plane;
mod point;
mod problem;
mod shape_checks;
mod shape_point;
mod soft;

pub use field::HeightField;
pub use ground::Ground;
pub use law::{ContactLaws, ContactViolation};
pub use link_distances::{LinkDistance, LinkDistances};
pub use point::ContactPoint;
pub use problem::{ContactLaw, ContactProblem};
pub use soft::{ActiveSet, SoftConstraints, SoftContact, SoftDynamicsInputs};

pub use components::{Components, Mark};
pub use cone_problem::{ConeProblem, Set};
pub use ground::axes;
pub use impulses::position_correction::{Bound, Equal, ROUNDING};
pub use impulses::{
    ContactImpulses, ContactMemory, DEEP, ImpulsiveStep, JointRow, QUIET, RETURN_TIME, SLOW_TOUCHDOWN,
    returns,
};
pub(crate) use impulses::{CorrectedRow, PushingRow};
pub use interrupt::Interrupt;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::{LinkShape, Pose, Shape, ShapeRole, Surface};
use robot_dynamics_number::InvalidInput;

use self::candidates::{Candidates, Sweep};
use self::contact_geometry::ContactGeometry;
use self::contact_shape::ContactShape;
use self::field::PlacedField;
use self::ground::bad_surface;
use self::named_pairs::NamedPairs;
use self::pair::ShapePair;
use self::placed_pair::MOST_PAIR_POINTS;
use self::shape_checks::{described, size_not_finite};
use crate::placement::Placement;

/// The shapes of one robot that can touch the ground, and the grounds.
///
/// The set contains collision shapes: spheres, capsules, boxes, cylinders, ellipsoids, convex meshes. Shapes
/// on links fixed to the world do not move, and do not touch a ground. A shape whose file prevents all
/// contact (`contype` and `conaffinity` of MJCF) is left out. If the file pairs such a shape with a plane, it
/// touches every ground, with the surface of that pair. Contacts between links are added by
/// [`with_links`](Self::with_links) and [`with_pair`](Self::with_pair), and uneven ground by
/// [`with_height_field`](Self::with_height_field).
///
/// ```
/// use robot_dynamics::contact::{ContactSet, Ground};
/// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// let ball = Shape::Sphere { radius: 0.1 };
/// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::IDENTITY, ball));
/// let contacts = ContactSet::new(&Model::new(robot)?, &[Ground::level(-1.0)])?;
/// assert!(contacts.has_shapes() && contacts.left_out().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ContactSet {
    robot: Identity,
    grounds: Vec<(Ground, [Vector3<f64>; 3])>,
    /// One entry for each ground, `None` without a surface of its own: the surface of each shape's contact
    /// with it.
    ground_surfaces: Vec<Option<Vec<Option<Surface>>>>,
    /// The names of the grounds in the file; empty if a ground has none.
    ground_names: Vec<String>,
    /// The links that the grounds are on; an empty name for a ground that no shape describes.
    ground_links: Vec<String>,
    fields: Vec<PlacedField>,
    shapes: Vec<ContactShape>,
    /// The links that can touch the ground.
    links: Vec<String>,
    left_out: Vec<String>,
    /// The named pairs, and the pairs by the rule that were near each other at some time.
    pairs: Vec<ShapePair>,
    candidates: Option<Candidates>,
    sweep: Sweep,
    left_out_pairs: Vec<String>,
    overlapping_pairs: Vec<String>,
    /// Whether searches include each shape; empty: all.
    active: Vec<bool>,
    /// The restitution e of every pair.
    link_restitution: f64,
    /// The number of points of all shapes together.
    points: usize,
    /// Whether the surface of a shape, a ground or a height field moves.
    has_moving_surfaces: bool,
}

impl ContactSet {
    /// A set of this robot's shapes, except meshes, on these grounds.
    ///
    /// # Errors
    /// [`InvalidInput`]: a ground, a shape that can touch, or a pair has an invalid number.
    pub fn new(model: &Model, grounds: &[Ground]) -> Result<Self, InvalidInput> {
        Self::with_meshes(model, grounds, |_| Err("meshes are not opened".into()))
    }

    /// The same with meshes, as the convex hulls of the points that `points_of` returns, in the shape's frame
    /// \[m\]. If it returns a reason instead, the mesh is left out.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, Ground};
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, Pose::IDENTITY, Shape::mesh("rod.stl")));
    /// let (model, ground) = (Model::new(robot)?, [Ground::level(-1.0)]);
    /// let rod = |_: &LinkShape| Ok(vec![[0.0; 3], [0.5, 0.0, -0.1]]);
    /// let contacts = ContactSet::with_meshes(&model, &ground, rod)?;
    /// assert_eq!(contacts.clearance(&model, &mut Workspace::new(&model), &[0.0]), Some(0.9));
    /// assert_eq!(ContactSet::new(&model, &ground)?.left_out(), ["mesh `rod.stl` of link `rod`: meshes are not opened"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_meshes(
        model: &Model,
        grounds: &[Ground],
        mut points_of: impl FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String>,
    ) -> Result<Self, InvalidInput> {
        let mut set = Self {
            robot: model.identity.clone(),
            grounds: Vec::new(),
            ground_surfaces: Vec::new(),
            ground_names: Vec::new(),
            ground_links: Vec::new(),
            fields: Vec::new(),
            shapes: Vec::new(),
            links: Vec::new(),
            left_out: Vec::new(),
            pairs: Vec::new(),
            candidates: None,
            sweep: Sweep::default(),
            left_out_pairs: Vec::new(),
            overlapping_pairs: Vec::new(),
            active: Vec::new(),
            link_restitution: 0.0,
            points: 0,
            has_moving_surfaces: false,
        };
        let stated = NamedPairs::of(model.description())?;
        for shape in &model.description().shapes {
            set.add(model, shape, &stated, &mut points_of)?;
        }
        for ground in grounds {
            set.add_ground(model, *ground, None)?;
        }
        Ok(set)
    }

    fn add(
        &mut self,
        model: &Model,
        shape: &LinkShape,
        stated: &NamedPairs<'_>,
        points_of: &mut impl FnMut(&LinkShape) -> Result<Vec<[f64; 3]>, String>,
    ) -> Result<(), InvalidInput> {
        let surface = shape.surface;
        let Some(frame) = model.frame(&shape.link).map(|frame| model.frame_of(frame)) else { return Ok(()) };
        let touches_others = surface.contype | surface.conaffinity != 0 || stated.names(&shape.name);
        if shape.role != ShapeRole::Collision || !touches_others {
            return Ok(());
        }
        let moved = shape.surface_velocity.to_array();
        let not_finite = surface.not_finite().or_else(|| size_not_finite(&shape.shape));
        let moved_badly = moved.iter().any(|x| !x.is_finite()).then_some("surface velocity");
        if let Some(quantity) = not_finite.or(moved_badly) {
            let shape = format!("shape `{}` of link `{}`", shape.name, shape.link);
            return Err(bad_surface(&shape, quantity));
        }
        self.has_moving_surfaces |= !shape.surface_velocity.is_zero();
        let body = frame.body.unwrap_or(WORLD);
        // The ground has bit 1 of both.
        let on_grounds = stated.on_grounds(&shape.name);
        let has_bit = (surface.contype | surface.conaffinity) & 1 != 0;
        let touches_ground = (has_bit || !on_grounds.is_empty()) && body != WORLD;
        let form = match &shape.shape {
            Shape::Mesh { .. } => points_of(shape).and_then(|points| ContactGeometry::of_points(&points)),
            other => ContactGeometry::new(other).ok_or_else(|| "it is no shape that moves".to_owned()),
        };
        let form = match form {
            Ok(form) => form,
            Err(reason) => {
                if touches_ground {
                    self.left_out.push(format!("{}: {reason}", described(shape)));
                }
                return Ok(());
            }
        };
        let Pose { rotation, translation } = frame.body_from_frame.compose(&shape.link_from_shape);
        let (reach, extent, first) = (form.reach(), form.extent(), self.points);
        let mut number = || {
            self.links.iter().position(|link| *link == shape.link).unwrap_or_else(|| {
                self.links.push(shape.link.clone());
                self.links.len() - 1
            })
        };
        let on_ground = touches_ground.then(&mut number);
        self.points += form.count();
        self.shapes.push(ContactShape {
            name: shape.name.clone(),
            link: shape.link.clone(),
            on_ground,
            body,
            coordinates: model.coordinates_between(WORLD, body).into_iter().collect(),
            rotation: Matrix3::from_fn(|i, j| rotation[i][j]),
            translation: translation.into(),
            form,
            convex: None,
            reach,
            extent,
            surface,
            surface_velocity: shape.surface_velocity,
            on_grounds,
            first,
        });
        Ok(())
    }

    /// Whether anything can touch the ground.
    pub fn has_shapes(&self) -> bool {
        !self.links.is_empty()
    }

    /// Collision shapes of moving links that are left out, each with the reason.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// The links that can touch the ground, in the order of
    /// [`StepInfo::contact_forces`](crate::StepInfo::contact_forces).
    pub fn links(&self) -> &[String] {
        &self.links
    }

    /// The robot's clearance above the ground, negative if a shape penetrates it \[m\]; `None` if no shape
    /// can touch it.
    ///
    /// ```
    /// use robot_dynamics::contact::{ContactSet, Ground};
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let (ball, at) = (Shape::Sphere { radius: 0.1 }, Pose::from_translation([0.5, 0.0, 0.0]));
    /// robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, at, ball));
    /// let model = Model::new(robot)?;
    /// let contacts = ContactSet::new(&model, &[Ground::level(-1.0)])?;
    /// assert_eq!(contacts.clearance(&model, &mut Workspace::new(&model), &[0.0]), Some(0.9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If q has the wrong length, or the set belongs to another robot.
    #[track_caller]
    pub fn clearance(&self, model: &Model, workspace: &mut Workspace, q: &[f64]) -> Option<f64> {
        workspace.check_inputs(model, q);
        model.check_identity(&self.robot, "the contact set");
        let mut placement = Placement::new(model);
        placement.set(model, workspace, q);
        let mut least = None;
        self.for_each_ground_contact(&placement, f64::INFINITY, |point| {
            least = Some(least.map_or(point.gap, |least: f64| least.min(point.gap)));
        });
        least
    }

    /// The number of points of all shapes on all grounds. Contacts with grounds have lower numbers; those of
    /// pairs start here.
    fn ground_point_count(&self) -> usize {
        self.points * self.grounds.len() + self.field_count()
    }

    /// The number of possible contacts.
    fn count(&self) -> usize {
        self.ground_point_count() + self.pairs.len() * MOST_PAIR_POINTS
    }
}

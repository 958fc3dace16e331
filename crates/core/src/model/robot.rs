//! The compiled robot: what the recursions run on.
//!
//! Compilation does the work that does not depend on the state. It orders joints depth first. It merges links
//! on fixed joints into their parent's body; they stay as named frames. It rotates every body frame so that
//! the joint moves about or along z. A [`Model`] is immutable and `Sync`; share it by reference or `Arc`.

use robot_dynamics_description::{
    JointKind, Limits, ModelError, NoSuchFrame, PassiveForces, Pose, RobotDescription,
};
use robot_dynamics_number::algebra::{Padded, PaddedColumns};

use crate::joint::PrimitiveJoint;
use crate::model::compile::compile;
use crate::model::frame::{Frame, FrameId, refuse_frame};
use crate::model::identity::Identity;
use crate::model::native::Native;
use crate::model::reference_point::ReferencePoints;
use crate::model::rotor::Rotor;
use crate::model::segment::Segments;

/// A checked, immutable robot model.
#[derive(Clone, Debug)]
pub struct Model {
    pub description: RobotDescription,
    pub identity: Identity,
    pub joints: Vec<Joint>,
    pub frames: Vec<Frame>,
    pub segments: Segments,
    pub bodies: Vec<Body>,
    pub dofs: Vec<Dof>,
    pub nq: usize,
    pub nv: usize,
    /// The mass of all links.
    pub mass: f64,
    /// Σ m c of the links fixed to the world, along its axes \[kg·m\].
    pub(crate) fixed_first_moment: [f64; 3],
    pub rotors: Vec<Rotor>,
    /// Whether mimic joints or rotors couple branches, so that M needs a dense factorization.
    pub needs_dense_factor: bool,
    pub(crate) has_armature: bool,
    pub has_springs: bool,
    /// The number of bodies without children; one for a chain.
    pub(crate) leaf_count: usize,
    /// The index in q of the first body's angle, if the angles of the next bodies follow it in order.
    pub(crate) first_angle: Option<usize>,
    pub points: ReferencePoints,
    /// The joints with an axis along which their motion has no kinetic energy in any pose.
    pub massless: Vec<usize>,
    /// See [`Model::actuated_dofs`].
    pub actuated: Vec<bool>,
    /// Its machine code.
    pub native: Native,
}

/// A joint of the model, with its indices in q and v.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Joint {
    /// The joint's name.
    pub name: String,
    /// Its kind, with its axes in the joint's frame.
    pub kind: JointKind,
    /// The parent link; `world` for a floating base.
    pub parent: String,
    /// The child link.
    pub child: String,
    /// First entry in q.
    pub q_index: usize,
    /// Entries in q; 0 for fixed and mimic joints.
    pub nq: usize,
    /// First entry in v.
    pub v_index: usize,
    /// Entries in v; 0 for fixed and mimic joints.
    pub nv: usize,
    /// The leader of a mimic joint, with ratio and offset.
    pub mimic: Option<robot_dynamics_description::Mimic>,
    /// Limits, per degree of freedom.
    pub limits: Limits,
    /// Armature, damping, friction and stiffness, per degree of freedom.
    pub passive: PassiveForces,
}

impl Joint {
    /// The names of its coordinates.
    pub fn coordinate_names(&self) -> Vec<String> {
        self.kind.velocities().iter().map(|coordinate| coordinate.of_joint(&self.name)).collect()
    }
}

/// The parent index of bodies attached to the world.
pub const WORLD: usize = usize::MAX;

/// One moving body with its joint. Constants are in the rotated body frame.
#[derive(Clone, Debug)]
pub struct Body {
    /// Index of the parent body, smaller than the body's own, or [`WORLD`].
    pub parent: usize,
    pub motion: PrimitiveJoint,
    /// The reference point of its placement (module `reference_point`).
    pub point: usize,
    /// The reference point of its tree's root.
    pub tree: usize,
    /// Whether `point` is this body's own origin.
    pub is_point: bool,
    /// Whether that point differs from the parent's and the parent can rotate, so that quantities passing the
    /// joint are shifted.
    pub shifts_reference_point: bool,
    /// First entry of this body in q; that of the leader for a mimic joint.
    pub q_index: usize,
    /// First entry of this body among the tree's degrees of freedom ([`Model::dofs`]).
    pub dof: usize,
    /// `parent_from_body` at q = 0.
    pub rotation: PaddedColumns,
    pub translation: Padded,
    pub mass: f64,
    /// h = m c \[kg·m\].
    pub first_moment: Padded,
    /// Rotational inertia about the body frame's origin \[kg·m²\].
    pub inertia: PaddedColumns,
    /// ∫ r rᵀ dm = ½ tr(I) 1 − I about the body frame's origin \[kg·m²\].
    pub second_moment: PaddedColumns,
    /// The link in whose frame the public functions report this body's quantities.
    pub link: usize,
    /// `body_from_link`: from the link's frame to the rotated body frame.
    pub body_from_link: Pose,
}

/// One degree of freedom of the tree: tree value = ratio · v\[coordinate\] (+ offset, for positions).
#[derive(Clone, Copy, Debug)]
pub struct Dof {
    /// Entry in v.
    pub coordinate: usize,
    /// The ratio of a mimic joint, else 1.
    pub ratio: f64,
    /// The offset of a mimic joint, added to q; else 0.
    pub offset: f64,
    /// The body this degree of freedom moves.
    pub body: usize,
    /// Its joint, in [`Model::joints`].
    pub joint: usize,
    /// One past the last DoF in the subtree of `body`, whose DoFs are contiguous.
    pub end: usize,
    pub passive: PassiveForces,
}

impl Model {
    /// Checks a description and compiles it.
    ///
    /// ```
    /// use robot_dynamics::description::{ModelError, pendulum};
    /// use robot_dynamics::model::Model;
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.nv(), 1);
    /// let mut headless = pendulum(2.0, 0.5);
    /// headless.joints[0].child = "bob".into(); // an unknown link
    /// assert!(Model::new(headless).unwrap_err().to_string().contains("bob"));
    /// # Ok::<(), ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] names the link or joint at fault. The causes are duplicate or unknown names, a link
    /// with two parents, several roots, cycles, a zero axis, and an invalid mimic joint. Joints that move no
    /// inertia are not an error: see [`Model::massless_joints`].
    pub fn new(description: RobotDescription) -> Result<Self, ModelError> {
        compile(description)
    }

    /// The description of this model. To change the robot, edit a copy and compile it again.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut on_mars = model.description().clone();
    /// on_mars.scale_gravity(0.38)?;
    /// let (here, there) = (model.gravity_forces(&[0.3])?, Model::new(on_mars)?.gravity_forces(&[0.3])?);
    /// assert!((there[0] - 0.38 * here[0]).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn description(&self) -> &RobotDescription {
        &self.description
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// Length of q: nv, plus one for each spherical or floating joint.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut thrown = pendulum(2.0, 0.5);
    /// thrown.base = Base::Floating;
    /// assert_eq!(Model::new(thrown)?.nq(), 3 + 4 + 1); // position, quaternion, hinge
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Length of v: the degrees of freedom, without mimic joints.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut thrown = pendulum(2.0, 0.5);
    /// thrown.base = Base::Floating;
    /// assert_eq!(Model::new(thrown)?.nv(), 3 + 3 + 1); // ṗ, ω, hinge
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// Gravitational acceleration in the world frame \[m/s²\].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.gravity(), [0.0, 0.0, -9.81]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn gravity(&self) -> [f64; 3] {
        self.description.gravity
    }

    /// All joints, moving ones in the order of q; fixed and mimic joints have `nq = nv = 0`.
    ///
    /// ```
    /// use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// // In v, each moving joint's numbers follow those of the joint before it.
    /// let ends = model.joints().iter().filter(|joint| joint.nv > 0).try_fold(0, |end, joint| {
    ///     (joint.v_index == end).then_some(end + joint.nv)
    /// });
    /// assert_eq!(ends, Some(model.nv()));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joint of this name.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let hinge = model.joint("hinge").expect("the pendulum's joint");
    /// assert_eq!((hinge.q_index, hinge.v_index, hinge.child.as_str()), (0, 0, "rod"));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn joint(&self, name: &str) -> Option<&Joint> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// All frames: the links first, in the description's order.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(model.frames().iter().map(|frame| frame.name.as_str()).eq(["ceiling", "rod", "tip"]));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The frame (or link) of this name.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let tip = model.frame("tip").expect("the pendulum's tip");
    /// assert_eq!(model.frame_pose(&[0.0], tip)?.translation, [0.5, 0.0, 0.0]);
    /// assert_eq!(model.frame("hand"), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn frame(&self, name: &str) -> Option<FrameId> {
        let index = self.frames.iter().position(|frame| frame.name == name)?;
        Some(FrameId { index, robot: self.identity.hash() })
    }

    /// The frame (or link) of this name, or an error that lists similar names.
    ///
    /// # Errors
    /// [`NoSuchFrame`] if there is no frame of this name.
    ///
    /// ```
    /// use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// let name = &model.frames()[1].name;
    /// assert_eq!(Some(model.frame_named(name)?), model.frame(name));
    /// assert!(model.frame_named("hand").unwrap_err().to_string().contains("no frame or link `hand`"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn frame_named(&self, name: &str) -> Result<FrameId, NoSuchFrame> {
        self.frame(name).ok_or_else(|| {
            let names = self.frames.iter().map(|frame| frame.name.as_str());
            NoSuchFrame::new(self.name(), name, names)
        })
    }

    /// Whether a frame belongs to this robot.
    pub fn has_frame(&self, frame: FrameId) -> bool {
        frame.robot == self.identity.hash()
    }

    /// The frame of an id.
    ///
    /// # Panics
    /// If it belongs to another robot.
    #[inline(always)]
    #[track_caller]
    pub fn frame_of(&self, frame: FrameId) -> &Frame {
        if !self.has_frame(frame) {
            refuse_frame(self);
        }
        &self.frames[frame.index]
    }

    /// Whether there are mimic joints.
    pub fn has_mimic(&self) -> bool {
        self.joints.iter().any(|joint| joint.mimic.is_some())
    }

    /// Whether q̇ = v for every joint: q has no quaternion.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert!(Model::new(robot.clone())?.is_vector_space());
    /// robot.base = Base::Floating; // has a quaternion
    /// assert!(!Model::new(robot)?.is_vector_space());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn is_vector_space(&self) -> bool {
        self.nq == self.nv
    }

    /// Each coordinate's limits, in the order of v.
    ///
    /// ```
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(f64::NEG_INFINITY, f64::INFINITY).with_effort(20.0);
    /// let limits = Model::new(robot)?.coordinate_limits();
    /// assert_eq!((limits[0].effort, limits[0].upper), (20.0, f64::INFINITY));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn coordinate_limits(&self) -> Vec<Limits> {
        let mut limits = vec![Limits::default(); self.nv];
        for joint in self.joints.iter().filter(|joint| joint.nv > 0) {
            limits[joint.v_index..joint.v_index + joint.nv].fill(joint.limits);
        }
        limits
    }

    /// The coordinates' names in the order of v: the joint's name, with a suffix if it has several
    /// coordinates.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.base = Base::Floating;
    /// let names = Model::new(robot)?.coordinate_names();
    /// assert_eq!((names[0].as_str(), names[6].as_str()), ("floating_base.vx", "hinge"));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn coordinate_names(&self) -> Vec<String> {
        self.joints.iter().filter(|joint| joint.nv > 0).flat_map(Joint::coordinate_names).collect()
    }

    /// The joint of a coordinate, O(log n).
    pub(crate) fn joint_at(&self, coordinate: usize) -> &Joint {
        &self.joints[self.joints.partition_point(|joint| joint.v_index + joint.nv <= coordinate)]
    }
}

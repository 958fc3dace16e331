//! The compiled robot: what the recursions run on.
//!
//! Compiling does once what no state changes: joints in depth-first order, fixed joints merged into the
//! body that carries them (their links stay as named frames), every body frame turned so that its joint
//! moves about or along z. A [`Model`] is immutable and `Sync`; share it by reference or `Arc`.

use crate::joint::Motion;
use crate::model::compile::compile;
use crate::model::error::{NoSuchFrame, similar};
use crate::model::frame::{Frame, FrameId, refuse_frame};
use crate::model::identity::Identity;
use crate::model::native::Native;
use crate::model::reference_point::ReferencePoints;
use crate::model::rotor::Rotor;
use crate::model::segment::Segments;
use crate::spatial::algebra::{Padded, PaddedColumns};
use crate::{JointKind, Limits, ModelError, PassiveForces, Pose, RobotDescription};

/// A checked, immutable robot model.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) description: RobotDescription,
    pub(crate) identity: Identity,
    pub(crate) joints: Vec<Joint>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) segments: Segments,
    pub(crate) bodies: Vec<Body>,
    pub(crate) dofs: Vec<Dof>,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
    /// The mass of all links.
    pub(crate) mass: f64,
    /// Σ m c of the links fixed to the world, along its axes \[kg·m\].
    pub(crate) fixed_first_moment: [f64; 3],
    pub(crate) rotors: Vec<Rotor>,
    /// Whether M couples branches, by followers or rotors, and is factored as a whole.
    pub(crate) couples_branches: bool,
    pub(crate) has_armature: bool,
    pub(crate) has_springs: bool,
    /// Bodies that carry no other; one for a chain.
    pub(crate) tips: usize,
    /// Where in q the first body's angle stands, when each next body's is the next number.
    pub(crate) first_angle: Option<usize>,
    pub(crate) points: ReferencePoints,
    /// The joints that cost no kinetic energy along some axis in any pose.
    pub(crate) massless: Vec<usize>,
    /// See [`Model::actuated_dofs`].
    pub(crate) actuated: Vec<bool>,
    /// Its functions in machine code.
    pub(crate) native: Native,
}

/// A joint of the model, with its place in q and v.
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
    /// The joint this one follows, with ratio and offset.
    pub mimic: Option<crate::Mimic>,
    /// Limits, per degree of freedom.
    pub limits: Limits,
    /// Armature, damping, friction and stiffness, per degree of freedom.
    pub passive: PassiveForces,
}

impl Joint {
    /// The names of its coordinates.
    pub(crate) fn coordinate_names(&self) -> Vec<String> {
        self.kind.velocities().iter().map(|coordinate| coordinate.of_joint(&self.name)).collect()
    }
}

/// The parent of bodies that hang in the world.
pub(crate) const WORLD: usize = usize::MAX;

/// One moving body with its joint; constants in the turned body frame.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Index of the parent body, smaller than the body's own, or [`WORLD`].
    pub parent: usize,
    pub motion: Motion,
    /// The reference point that its placement is measured from ([`reference_point`](crate::model::reference_point)).
    pub point: usize,
    /// The reference point of its tree's root.
    pub tree: usize,
    /// Whether `point` is this body's own origin.
    pub is_point: bool,
    /// Whether that point is not the parent's, and the parent turns: what passes the joint is shifted.
    pub is_carried: bool,
    /// First entry of this body in q (of the leader, for a follower).
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
    /// The link whose frame this body's user-facing quantities use.
    pub link: usize,
    /// `body_from_link`: turns and shifts link-frame quantities into the turned frame.
    pub body_from_link: Pose,
}

/// One degree of freedom of the tree: tree value = ratio · v\[coordinate\] (+ offset, for positions).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dof {
    /// Entry in v.
    pub coordinate: usize,
    /// 1 unless the joint follows another.
    pub ratio: f64,
    /// Added to q; 0 unless the joint follows another.
    pub offset: f64,
    /// The body this degree of freedom moves.
    pub body: usize,
    /// The joint it is of, in [`Model::joints`].
    pub joint: usize,
    /// One past the last freedom of the bodies that ride on `body`: a subtree is numbered through.
    pub end: usize,
    pub passive: PassiveForces,
}

impl Model {
    /// Checks a description and compiles it.
    ///
    /// ```
    /// use multibody::{Model, ModelError, pendulum};
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.nv(), 1);
    /// let mut headless = pendulum(2.0, 0.5);
    /// headless.joints[0].child = "bob".into(); // a link that is not there
    /// assert!(Model::new(headless).unwrap_err().to_string().contains("bob"));
    /// # Ok::<(), ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] names the link or joint at fault: duplicate or unknown names, a link with two
    /// parents, several roots, cycles, a zero axis, a follower of nothing. Joints that move no inertia are no
    /// error: see [`Model::massless_joints`].
    pub fn new(description: RobotDescription) -> Result<Self, ModelError> {
        compile(description)
    }

    /// The description this model was compiled from; edit a copy and compile again for model surgery.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
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
    /// use multibody::{Base, Model, pendulum};
    /// let mut thrown = pendulum(2.0, 0.5);
    /// thrown.base = Base::Floating;
    /// assert_eq!(Model::new(thrown)?.nq(), 3 + 4 + 1); // place, quaternion, hinge
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Length of v: degrees of freedom, followers not counted.
    ///
    /// ```
    /// use multibody::{Base, Model, pendulum};
    /// let mut thrown = pendulum(2.0, 0.5);
    /// thrown.base = Base::Floating;
    /// assert_eq!(Model::new(thrown)?.nv(), 3 + 3 + 1); // ṗ, ω, hinge
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// Gravitational acceleration in the world frame \[m/s²\].
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// assert_eq!(Model::new(pendulum(2.0, 0.5))?.gravity(), [0.0, 0.0, -9.81]);
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn gravity(&self) -> [f64; 3] {
        self.description.gravity
    }

    /// All joints, moving ones in the order of q; fixed and mimic joints have `nq = nv = 0`.
    ///
    /// ```
    /// use multibody::{Model, RandomRobotOptions, random_robot};
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// // Each moving joint's numbers in v begin where those of the one before it end.
    /// let ends = model.joints().iter().filter(|joint| joint.nv > 0).try_fold(0, |end, joint| {
    ///     (joint.v_index == end).then_some(end + joint.nv)
    /// });
    /// assert_eq!(ends, Some(model.nv()));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joint of this name.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let hinge = model.joint("hinge").expect("the pendulum's joint");
    /// assert_eq!((hinge.q_index, hinge.v_index, hinge.child.as_str()), (0, 0, "rod"));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn joint(&self, name: &str) -> Option<&Joint> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// All frames: the links first, in the description's order.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(model.frames().iter().map(|frame| frame.name.as_str()).eq(["ceiling", "rod", "tip"]));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The frame (or link) of this name.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
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

    /// The frame (or link) of this name, or an error that names those of similar names.
    ///
    /// # Errors
    /// [`NoSuchFrame`].
    ///
    /// ```
    /// use multibody::{Model, RandomRobotOptions, random_robot};
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// let name = &model.frames()[1].name;
    /// assert_eq!(Some(model.frame_named(name)?), model.frame(name));
    /// assert!(model.frame_named("hand").unwrap_err().to_string().contains("no frame or link `hand`"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn frame_named(&self, name: &str) -> Result<FrameId, NoSuchFrame> {
        self.frame(name).ok_or_else(|| {
            let names = self.frames.iter().map(|frame| frame.name.as_str());
            NoSuchFrame { robot: self.name().into(), name: name.into(), similar: similar(name, names) }
        })
    }

    /// Whether a frame is this robot's.
    pub(crate) fn has_frame(&self, frame: FrameId) -> bool {
        frame.robot == self.identity.hash()
    }

    /// The frame.
    ///
    /// # Panics
    /// If it is another robot's.
    #[inline(always)]
    #[track_caller]
    pub(crate) fn frame_of(&self, frame: FrameId) -> &Frame {
        if !self.has_frame(frame) {
            refuse_frame(self);
        }
        &self.frames[frame.index]
    }

    /// Whether some joint follows another.
    pub fn has_mimic(&self) -> bool {
        self.joints.iter().any(|joint| joint.mimic.is_some())
    }

    /// Whether every joint's q is plain numbers with q̇ = v (no quaternion).
    ///
    /// ```
    /// use multibody::{Base, Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert!(Model::new(robot.clone())?.is_vector_space());
    /// robot.base = Base::Floating; // has a quaternion
    /// assert!(!Model::new(robot)?.is_vector_space());
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn is_vector_space(&self) -> bool {
        self.nq == self.nv
    }

    /// Each coordinate's limits, in the order of v.
    ///
    /// ```
    /// use multibody::{Limits, Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(f64::NEG_INFINITY, f64::INFINITY).with_effort(20.0);
    /// let limits = Model::new(robot)?.coordinate_limits();
    /// assert_eq!((limits[0].effort, limits[0].upper), (20.0, f64::INFINITY));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn coordinate_limits(&self) -> Vec<Limits> {
        let mut limits = vec![Limits::default(); self.nv];
        for joint in self.joints.iter().filter(|joint| joint.nv > 0) {
            limits[joint.v_index..joint.v_index + joint.nv].fill(joint.limits);
        }
        limits
    }

    /// The coordinates' names in the order of v: the joint's name, with a suffix where it has several.
    ///
    /// ```
    /// use multibody::{Base, Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.base = Base::Floating;
    /// let names = Model::new(robot)?.coordinate_names();
    /// assert_eq!((names[0].as_str(), names[6].as_str()), ("floating_base.vx", "hinge"));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn coordinate_names(&self) -> Vec<String> {
        self.joints.iter().filter(|joint| joint.nv > 0).flat_map(Joint::coordinate_names).collect()
    }

    /// The joint that a coordinate belongs to, O(log n).
    pub(crate) fn joint_at(&self, coordinate: usize) -> &Joint {
        &self.joints[self.joints.partition_point(|joint| joint.v_index + joint.nv <= coordinate)]
    }
}

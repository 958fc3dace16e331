//! The compiled robot: what the recursions run on.
//!
//! Compilation does the work that does not depend on the state. It orders joints depth first. It merges links
//! on fixed joints into their parent's body; they stay as named frames. It rotates every body frame so that
//! the joint moves about or along z. A [`Model`] is immutable and `Sync`; share it by reference or `Arc`.

#[cfg(feature = "native")]
use std::sync::Arc;

use robot_dynamics_description::{Limits, RobotDescription, unknown_name};
#[cfg(feature = "native")]
use robot_dynamics_expression::Arithmetic;
use robot_dynamics_number::InvalidInput;

use crate::model::body::{Body, Dof};
use crate::model::frame::{Frame, FrameId, refuse_frame};
use crate::model::identity::Identity;
use crate::model::joint::Joint;
use crate::model::link::Link;
#[cfg(feature = "native")]
use crate::model::native::slots::Kernels;
#[cfg(not(feature = "native"))]
pub(crate) use crate::model::native::stub::Native;
#[cfg(feature = "native")]
use crate::model::native::{NativeFunction, NativeTrace};
use crate::model::reference_point::ReferencePoints;
use crate::model::rotor::Rotor;
use crate::model::segment::Segments;

/// A checked, immutable robot model.
#[derive(Clone, Debug)]
pub struct Model {
    pub description: RobotDescription,
    pub identity: Identity,
    pub joints: Vec<Joint>,
    pub links: Vec<Link>,
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
    /// The indices in q of the first number of each quaternion.
    pub(crate) quaternions: Vec<usize>,
    pub points: ReferencePoints,
    /// The joints with an axis along which their motion has no kinetic energy in any pose.
    pub massless: Vec<usize>,
    /// See [`Model::actuated_dofs`].
    pub actuated: Vec<bool>,
    /// Its machine code.
    pub native: Native,
}

/// Returns the expression of a model's function, or the reason for a missing one. The name is that of the
/// frame, for [`NativeFunction::OF_FRAMES`].
#[cfg(feature = "native")]
pub type Tracer = fn(&Model, NativeFunction, Option<&str>, Arithmetic) -> Result<NativeTrace, String>;

#[cfg(feature = "native")]
/// The machine code of a model, if it has a tracer.
#[derive(Clone, Debug, Default)]
pub struct Native(pub(super) Option<Arc<Code>>);

#[cfg(feature = "native")]
/// All machine code of a model.
#[derive(Debug)]
pub struct Code {
    pub(super) tracer: Tracer,
    pub(super) is_on: bool,
    pub(super) f64: Kernels<f64>,
    pub(super) f32: Kernels<f32>,
}

impl Model {
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
    /// assert_eq!((hinge.q_index, hinge.v_index, hinge.child_link.as_str()), (0, 0, "rod"));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn joint(&self, name: &str) -> Option<&Joint> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// All links, in the description's order: a link's index is its frame's index, too.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let rod = &model.links()[1];
    /// assert_eq!((rod.name.as_str(), rod.index, rod.parent_joint, rod.mass()), ("rod", 1, Some(0), 2.0));
    /// assert_eq!(model.links()[0].parent_joint, None); // the root
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The link of this name.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(model.link("rod").map(|rod| rod.center_of_mass()), Some([0.5, 0.0, 0.0]));
    /// assert_eq!(model.link("hand"), None);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn link(&self, name: &str) -> Option<&Link> {
        self.links.iter().find(|link| link.name == name)
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
    /// [`InvalidInput`] if there is no frame of this name.
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
    #[doc(alias = "NoSuchFrame")]
    pub fn frame_named(&self, name: &str) -> Result<FrameId, InvalidInput> {
        self.frame(name).ok_or_else(|| {
            let names = self.frames.iter().map(|frame| frame.name.as_str());
            unknown_name("frame or link", name, format!("robot `{}`", self.name()), names)
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
            refuse_frame(self.name());
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
            limits[joint.v()].fill(joint.limits);
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

    /// A hash of the description without its shapes, sensors and poses: equal if every name and every digit
    /// is. Workspaces and frames of one robot panic when used with a robot of another fingerprint.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let robot = Model::new(pendulum(2.0, 0.5))?;
    /// assert_eq!(robot.fingerprint(), Model::new(pendulum(2.0, 0.5))?.fingerprint());
    /// assert_ne!(robot.fingerprint(), Model::new(pendulum(2.0_f64.next_up(), 0.5))?.fingerprint());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn fingerprint(&self) -> u64 {
        self.identity.hash()
    }

    /// Panics with both names if `what` belongs to another robot, `owner`.
    #[inline(always)]
    #[track_caller]
    pub fn check_identity(&self, owner: &Identity, what: &str) {
        if owner.hash() != self.identity.hash() {
            self.identity.refuse(owner, what);
        }
    }

    /// The joint of a coordinate, O(log n).
    pub(crate) fn joint_at(&self, coordinate: usize) -> &Joint {
        &self.joints[self.joints.partition_point(|joint| joint.v_index + joint.nv <= coordinate)]
    }
}

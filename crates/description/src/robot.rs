//! A robot as its file describes it: links, joints and frames by name, in the file's own axes.
//!
//! A [`RobotDescription`] is plain data: readers of robot files fill it, users edit it, serde serializes it.
//! `Model::new` checks it and compiles it for the recursions.

use std::collections::{HashMap, HashSet};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{
    ActuatorDescription, ContactPairDescription, EndEffectorDescription, EqualityDescription, FluidShape,
    FrameDescription, GroupDescription, JointDescription, JointKind, LinkShape, MassProperties, Medium,
    NamedPose, SensorDescription, SpatialTendonDescription, TendonDescription,
};

/// Earth's gravity along −z of the world frame \[m/s²\].
pub const EARTH_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A robot: a tree of links connected by joints.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct RobotDescription {
    /// The robot's name.
    pub name: String,
    /// The gravitational acceleration in the world frame \[m/s²\].
    pub gravity: [f64; 3],
    /// How the root link is attached to the world.
    pub base: Base,
    /// Every link; exactly one, the root, is not the child of a joint.
    pub links: Vec<LinkDescription>,
    /// Every joint; each connects a parent link to a child link.
    pub joints: Vec<JointDescription>,
    /// Further named frames, fixed to links; every link is also a frame.
    pub frames: Vec<FrameDescription>,
    /// The links' shapes. No algorithm of dynamics reads them, and `Model::fingerprint` does not depend on
    /// them.
    #[cfg_attr(feature = "serde", serde(default))]
    pub shapes: Vec<LinkShape>,
    /// Pairs of links that never collide.
    #[cfg_attr(feature = "serde", serde(default))]
    pub contact_exclusions: Vec<(String, String)>,
    /// Pairs of shapes that always collide.
    #[cfg_attr(feature = "serde", serde(default))]
    pub contact_pairs: Vec<ContactPairDescription>,
    /// Tendons over joints.
    #[cfg_attr(feature = "serde", serde(default))]
    pub tendons: Vec<TendonDescription>,
    /// The fluid around the robot.
    #[cfg_attr(feature = "serde", serde(default))]
    pub medium: Medium,
    /// The parts of links on which the fluid acts.
    #[cfg_attr(feature = "serde", serde(default))]
    pub fluid_shapes: Vec<FluidShape>,
    /// Tendons along a path through points of links.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spatial_tendons: Vec<SpatialTendonDescription>,
    /// Equalities in addition to the tree.
    #[cfg_attr(feature = "serde", serde(default))]
    pub equalities: Vec<EqualityDescription>,
    /// Actuators, in the order of their controls.
    #[cfg_attr(feature = "serde", serde(default))]
    pub actuators: Vec<ActuatorDescription>,
    /// Sensors, in the order of their values. No algorithm of dynamics reads them.
    #[cfg_attr(feature = "serde", serde(default))]
    pub sensors: Vec<SensorDescription>,
    /// Named poses.
    #[cfg_attr(feature = "serde", serde(default))]
    pub poses: Vec<NamedPose>,
    /// Groups of links and joints. No algorithm of dynamics reads them.
    #[cfg_attr(feature = "serde", serde(default))]
    pub groups: Vec<GroupDescription>,
    /// The groups that are tools.
    #[cfg_attr(feature = "serde", serde(default))]
    pub end_effectors: Vec<EndEffectorDescription>,
    /// The joints that motors drive. `None` means all except floating ones. See `Model::actuated_dofs`.
    #[cfg_attr(feature = "serde", serde(default))]
    pub actuated_joints: Option<Vec<String>>,
    /// The time step that the file requests \[s\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub time_step: Option<f64>,
    /// The ratio of the stiffness of friction to that of the normal force under MuJoCo's law, if the file
    /// gives it: `impratio` of MJCF.
    #[cfg_attr(feature = "serde", serde(default))]
    pub impratio: Option<f64>,
}

impl RobotDescription {
    /// The names of all tendons, those over joints first.
    pub fn tendon_names(&self) -> impl Iterator<Item = &str> {
        let over_joints = self.tendons.iter().map(|tendon| tendon.name.as_str());
        over_joints.chain(self.spatial_tendons.iter().map(|tendon| tendon.name.as_str()))
    }

    /// An empty robot in Earth's gravity, its base fixed to the world.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            gravity: EARTH_GRAVITY,
            base: Base::Fixed,
            links: Vec::new(),
            joints: Vec::new(),
            frames: Vec::new(),
            shapes: Vec::new(),
            contact_exclusions: Vec::new(),
            contact_pairs: Vec::new(),
            tendons: Vec::new(),
            medium: Medium::default(),
            fluid_shapes: Vec::new(),
            spatial_tendons: Vec::new(),
            equalities: Vec::new(),
            actuators: Vec::new(),
            sensors: Vec::new(),
            poses: Vec::new(),
            groups: Vec::new(),
            end_effectors: Vec::new(),
            actuated_joints: None,
            time_step: None,
            impratio: None,
        }
    }

    /// The name of the joint that a floating base adds: [`FLOATING_BASE`], or `floating_base_2` and so on if
    /// joints of the robot have that name.
    ///
    /// ```
    /// let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    /// assert_eq!(robot.floating_base_name(), "floating_base");
    /// robot.joints[0].name = "floating_base".into();
    /// assert_eq!(robot.floating_base_name(), "floating_base_2");
    /// ```
    pub fn floating_base_name(&self) -> String {
        let is_taken = |name: &str| self.joints.iter().any(|joint| joint.name == name);
        let numbered = (2..).map(|number| format!("{FLOATING_BASE}_{number}"));
        core::iter::once(FLOATING_BASE.to_owned())
            .chain(numbered)
            .find(|name| !is_taken(name))
            .unwrap_or_default()
    }

    /// The frames of all equalities, in addition to the robot's own.
    pub fn equality_frames(&self) -> Vec<FrameDescription> {
        self.equalities.iter().flat_map(EqualityDescription::frames).collect()
    }

    /// The links that are not the child of a joint; a valid robot has one.
    pub(crate) fn roots(&self) -> impl Iterator<Item = &LinkDescription> {
        let children: HashSet<&str> = self.joints.iter().map(|joint| joint.child.as_str()).collect();
        self.links.iter().filter(move |link| !children.contains(link.name.as_str()))
    }

    /// Whether the robot floats by joints of its own. The root link and all links fixed to it then have no
    /// mass, and their other joints are floating. A floating base would add motions without inertia.
    ///
    /// ```
    /// use robot_dynamics::description::{JointKind, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert!(!robot.root_floats());
    /// robot.joints[0].kind = JointKind::Floating; // from a massless ceiling: a free rod
    /// assert!(robot.root_floats());
    /// ```
    pub fn root_floats(&self) -> bool {
        let Some(root) = self.roots().next() else { return false };
        let has_mass: HashSet<&str> = self
            .links
            .iter()
            .filter(|link| link.mass_properties.is_some())
            .map(|link| link.name.as_str())
            .collect();
        let mut from = HashMap::<&str, Vec<&JointDescription>>::new();
        for joint in &self.joints {
            from.entry(&joint.parent).or_default().push(joint);
        }
        let (mut floats, mut pending) = (false, vec![root.name.as_str()]);
        while let Some(link) = pending.pop() {
            if has_mass.contains(link) {
                return false;
            }
            for joint in from.remove(link).unwrap_or_default() {
                match joint.kind {
                    JointKind::Fixed => pending.push(&joint.child),
                    JointKind::Floating => floats = true,
                    _ => return false,
                }
            }
        }
        floats
    }
}

/// The attachment of the root link to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Base {
    /// The root link's frame is the world frame.
    Fixed,
    /// Six degrees of freedom: a joint named [`FLOATING_BASE`] (see there) before all others. Its q
    /// is \[x y z, qx qy qz qw\], and its v \[linear, angular\] in the root link's frame.
    Floating,
}

/// The name of the joint that a floating base adds. If a joint of the robot has it, a number follows: see
/// [`RobotDescription::floating_base_name`].
pub const FLOATING_BASE: &str = "floating_base";

/// A rigid link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LinkDescription {
    /// Its name, unique among links.
    pub name: String,
    /// Mass, centre of mass and inertia in the link's frame; `None` for a link without mass.
    #[cfg_attr(feature = "serde", serde(with = "mass_properties_as_numbers"))]
    pub mass_properties: Option<MassProperties>,
    /// The fraction of its weight that a force outside the equations compensates: 1 for a link without
    /// effective weight. The force is not part of g; see `Actuation`.
    #[cfg_attr(feature = "serde", serde(default))]
    pub gravity_compensation: f64,
}

impl LinkDescription {
    /// A link with this mass; `None` for a massless link.
    ///
    /// ```
    /// use robot_dynamics::description::LinkDescription;
    /// let ball = robot_dynamics::description::MassProperties::point(2.0, nalgebra::Vector3::zeros())?;
    /// assert_eq!(LinkDescription::new("ball", ball).mass_properties.map(|p| p.mass()), Some(2.0));
    /// assert_eq!(LinkDescription::new("tool", None).mass_properties, None);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn new(name: impl Into<String>, mass_properties: impl Into<Option<MassProperties>>) -> Self {
        Self { name: name.into(), mass_properties: mass_properties.into(), gravity_compensation: 0.0 }
    }
}

/// Mass properties as numbers. Reading them back accepts them as written, if they are finite and symmetric.
#[cfg(feature = "serde")]
mod mass_properties_as_numbers {
    use nalgebra::{Matrix3, Vector3};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::MassProperties;

    #[derive(Serialize, Deserialize)]
    struct Numbers {
        mass: f64,
        center_of_mass: [f64; 3],
        /// About the centre of mass, along the link's axes: xx, xy, xz, yy, yz, zz.
        inertia: [f64; 6],
    }

    #[allow(clippy::ref_option)] // serde's `with` passes a reference to the field
    pub(super) fn serialize<S: Serializer>(
        properties: &Option<MassProperties>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let numbers = properties.as_ref().map(|p| {
            let i = p.inertia_about_center_of_mass();
            Numbers {
                mass: p.mass(),
                center_of_mass: p.center_of_mass().into(),
                inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
            }
        });
        numbers.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<MassProperties>, D::Error> {
        let Some(numbers) = Option::<Numbers>::deserialize(deserializer)? else { return Ok(None) };
        let [xx, xy, xz, yy, yz, zz] = numbers.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        MassProperties::as_written(numbers.mass, Vector3::from(numbers.center_of_mass), inertia)
            .map(Some)
            .map_err(D::Error::custom)
    }
}

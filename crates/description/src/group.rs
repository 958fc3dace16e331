//! Named groups of links and joints, and the end effectors among them, as SRDF files state them.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A named group of links and joints, such as an arm for a motion planner. No algorithm of dynamics reads it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct GroupDescription {
    /// Its name, unique among groups.
    pub name: String,
    /// All its links, in the robot's order.
    pub links: Vec<String>,
    /// All its joints, in the robot's order.
    pub joints: Vec<String>,
    /// The chains that the file lists: the base link and the tip link of each.
    #[cfg_attr(feature = "serde", serde(default))]
    pub chains: Vec<(String, String)>,
    /// The groups that the file lists as a part of it. Their links and joints are among its own.
    #[cfg_attr(feature = "serde", serde(default))]
    pub subgroups: Vec<String>,
}

impl GroupDescription {
    /// A group of these links and joints.
    ///
    /// ```
    /// use robot_dynamics::description::{GroupDescription, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.groups.push(GroupDescription::new("arm", ["rod"], ["hinge"]));
    /// assert!(robot_dynamics::model::Model::new(robot).is_ok());
    /// ```
    pub fn new<N: Into<String>>(
        name: impl Into<String>,
        links: impl IntoIterator<Item = N>,
        joints: impl IntoIterator<Item = N>,
    ) -> Self {
        let links = links.into_iter().map(Into::into).collect();
        let joints = joints.into_iter().map(Into::into).collect();
        Self { name: name.into(), links, joints, ..Self::default() }
    }
}

/// A group that is a tool, such as a gripper.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct EndEffectorDescription {
    /// Its name, unique among end effectors.
    pub name: String,
    /// The group of its links and joints.
    pub group: String,
    /// The link that carries it.
    pub parent_link: String,
    /// The group that moves it, if the file states one.
    #[cfg_attr(feature = "serde", serde(default))]
    pub parent_group: Option<String>,
}

impl EndEffectorDescription {
    /// An end effector: its name, the group of its links and joints, and the link that carries it.
    ///
    /// ```
    /// let hand = robot_dynamics::description::EndEffectorDescription::new("hand", "fingers", "wrist");
    /// assert_eq!((hand.parent_link.as_str(), hand.parent_group), ("wrist", None));
    /// ```
    pub fn new(name: impl Into<String>, group: impl Into<String>, parent_link: impl Into<String>) -> Self {
        Self { name: name.into(), group: group.into(), parent_link: parent_link.into(), parent_group: None }
    }
}

//! Adds frames and links.

use super::names::missing;
use crate::validation::{check_joint, check_pose};
use crate::{FrameDescription, JointDescription, LinkDescription, ModelError, Pose, RobotDescription};

impl RobotDescription {
    /// Adds a frame that is fixed to a link or to another frame, at `parent_from_frame`.
    ///
    /// ```
    /// use robot_dynamics::description::{Pose, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.add_frame("camera", "tip", Pose::from_translation([0.0, 0.0, 0.1]))?;
    /// assert_eq!(robot.frames[1].link, "rod");
    /// assert_eq!(robot.frames[1].link_from_frame.translation, [0.5, 0.0, 0.1]);
    /// let error = robot.add_frame("grip", "tipp", Pose::IDENTITY).unwrap_err();
    /// assert!(error.to_string().ends_with("did you mean `tip`?"));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if the parent is unknown, the name is taken, or the pose is invalid. The robot is then
    /// unchanged.
    pub fn add_frame(&mut self, name: &str, parent: &str, parent_from_frame: Pose) -> Result<(), ModelError> {
        let (link, link_from_parent) = self.link_of(parent)?;
        self.check_place_name("frame", name)?;
        let frame = FrameDescription::new(name, link, link_from_parent.compose(&parent_from_frame));
        check_pose(&format!("frame `{name}`"), &frame.link_from_frame)?;
        self.frames.push(frame);
        Ok(())
    }

    /// Adds a link as the child of a new joint. The joint's parent is a link of the robot.
    ///
    /// ```
    /// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, MassProperties};
    /// use robot_dynamics::description::{Pose, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let slide = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    /// let joint = JointDescription::new("slide", slide, "rod", "slider", Pose::IDENTITY);
    /// let body = MassProperties::point(1.0, [0.0; 3].into())?;
    /// robot.add_link(LinkDescription::new("slider", body), joint)?;
    /// assert_eq!(Model::new(robot)?.nv(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if the joint's parent is unknown, its child is not this link, or a name is taken. The
    /// robot is then unchanged.
    pub fn add_link(&mut self, link: LinkDescription, joint: JointDescription) -> Result<(), ModelError> {
        self.link_index(&joint.parent)?;
        self.check_place_name("link", &link.name)?;
        if self.joints.iter().any(|own| own.name == joint.name) {
            return Err(ModelError::DuplicateName { sort: "joint", name: joint.name });
        }
        if joint.child != link.name {
            let user = format!("joint `{}`", joint.name);
            return Err(ModelError::UnknownName { user, sort: "child link", name: joint.child });
        }
        check_joint(&joint)?;
        self.links.push(link);
        self.joints.push(joint);
        Ok(())
    }

    /// The link of a link or frame, with `link_from_frame`.
    pub(crate) fn link_of(&self, name: &str) -> Result<(String, Pose), ModelError> {
        if self.links.iter().any(|link| link.name == name) {
            return Ok((name.to_owned(), Pose::IDENTITY));
        }
        if let Some(frame) = self.frames.iter().find(|frame| frame.name == name) {
            return Ok((frame.link.clone(), frame.link_from_frame));
        }
        let links = self.links.iter().map(|link| link.name.as_str());
        let names = links.chain(self.frames.iter().map(|frame| frame.name.as_str()));
        Err(missing("link or frame", name, names).into())
    }

    /// Rejects the name of a link or of a frame.
    pub(super) fn check_place_name(&self, sort: &'static str, name: &str) -> Result<(), ModelError> {
        let is_taken = self.links.iter().any(|link| link.name == name)
            || self.frames.iter().chain(&self.equality_frames()).any(|frame| frame.name == name);
        if is_taken { Err(ModelError::DuplicateName { sort, name: name.to_owned() }) } else { Ok(()) }
    }
}

//! Which joints are written into one body: MuJoCo refuses to move a link without mass.

use std::collections::HashSet;

use multibody::{Equality, JointKind, Pose, SensorObject, Transmission};

use super::Writing;

/// The most freedoms of a body.
const FREEDOMS: usize = 6;

/// A body to be written.
pub(super) struct Body {
    pub(super) link: usize,
    /// The joints that move it, from its parent on.
    pub(super) joints: Vec<usize>,
    /// In the body that it is in, where all joints are at zero.
    pub(super) place: Pose,
    /// Whether it stands in the world.
    pub(super) stands: bool,
}

impl Writing<'_> {
    /// The links that something names, and which must have a body of their own.
    pub(super) fn named_links(&self) -> HashSet<usize> {
        let robot = self.robot;
        let mut names: Vec<&str> = robot.shapes.iter().map(|shape| shape.link.as_str()).collect();
        names.extend(robot.frames.iter().map(|frame| frame.link.as_str()));
        names.extend(robot.contact_exclusions.iter().flat_map(|(a, b)| [a.as_str(), b]));
        for equality in &robot.equalities {
            match &equality.kind {
                Equality::Connect { a: (a, _), b: (b, _) } | Equality::Weld { a, b, .. } => {
                    names.extend([a.as_str(), b]);
                }
                _ => {}
            }
        }
        for actuator in &robot.actuators {
            if let Transmission::Frame { frame, .. } = &actuator.transmission {
                names.push(frame);
            }
        }
        for sensor in &robot.sensors {
            for object in core::iter::once(&sensor.object).chain(&sensor.reference) {
                if let SensorObject::Named(name) | SensorObject::CenterOfMass(name) = object {
                    names.push(name);
                }
            }
        }
        names.into_iter().filter_map(|name| self.link_index.get(name).copied()).collect()
    }

    /// The body at the end of a joint, with the joints that follow it over links without mass, nothing named on them.
    pub(super) fn body_of(&mut self, joint: usize, stands: bool, named: &HashSet<usize>) -> Body {
        let robot = self.robot;
        let mut joints = vec![joint];
        // A free body's spring rests where the file places the body.
        let rest = robot.joints[joint].spring.filter(|_| robot.joints[joint].kind == JointKind::Floating);
        let mut place = rest.map_or(robot.joints[joint].parent_from_joint, |spring| spring.rest);
        let mut freedoms = robot.joints[joint].kind.nv();
        loop {
            let last = &robot.joints[joints[joints.len() - 1]];
            let link = self.link_index[last.child.as_str()];
            let next = match self.below[link][..] {
                [next] if self.is_bare(link) && !named.contains(&link) => next,
                _ => break,
            };
            let after = &robot.joints[next];
            let count = freedoms + after.kind.nv();
            // A quaternion is along the body's axes, and so must be those of the joints behind it.
            let turns_freely = joints.iter().any(|&joint| robot.joints[joint].kind == JointKind::Spherical);
            let is_turned = after.parent_from_joint.rotation != Pose::IDENTITY.rotation;
            let is_free = |kind: JointKind| matches!(kind, JointKind::Floating | JointKind::Fixed);
            let readers_own = robot.links[link].name == format!("{}/{}", after.child, last.name);
            if is_free(last.kind)
                || after.kind == JointKind::Floating
                || (after.kind == JointKind::Fixed && !readers_own)
                || count > FREEDOMS
                || (turns_freely && is_turned)
            {
                break;
            }
            if !readers_own {
                let message =
                    "without mass between two joints, which MuJoCo refuses: both joints are the next body's";
                self.note(&format!("link {:?}", robot.links[link].name), message);
            }
            place = place.compose(&after.parent_from_joint);
            freedoms = count;
            joints.push(next);
        }
        let link = self.link_index[robot.joints[joints[joints.len() - 1]].child.as_str()];
        let moves = joints.iter().any(|&joint| robot.joints[joint].kind != JointKind::Fixed);
        Body { link, joints, place, stands: stands && !moves }
    }

    fn is_bare(&self, link: usize) -> bool {
        let link = &self.robot.links[link];
        link.mass_properties.is_none() && !self.link_sites.contains_key(link.name.as_str())
    }

    /// Whether the root link is the world's own body.
    pub(super) fn root_is_world(&self) -> bool {
        self.robot.base == multibody::Base::Fixed && self.robot.links[self.root].name == "world"
    }
}

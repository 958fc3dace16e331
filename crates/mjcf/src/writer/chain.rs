//! Groups joints into bodies: links without mass between joints are omitted, because MuJoCo refuses to move
//! them.

use std::collections::HashSet;

use robot_dynamics_description::{Equality, JointKind, Pose, SensorObject, TendonPathElement, Transmission};

use super::MjcfWriter;

/// The largest number of degrees of freedom of a body.
const DOF_LIMIT: usize = 6;

/// A body to be written.
pub(super) struct WrittenBody {
    pub(super) link: usize,
    /// The joints between its parent and it, in order.
    pub(super) joints: Vec<usize>,
    /// The pose in its parent with all joints at zero.
    pub(super) place: Pose,
    /// Whether it is fixed to the world.
    pub(super) is_fixed_to_world: bool,
}

impl MjcfWriter<'_> {
    /// The links that other elements refer to, which need a body of their own.
    pub(super) fn named_links(&self) -> HashSet<usize> {
        let robot = self.robot;
        let mut names: Vec<&str> = robot.shapes.iter().map(|shape| shape.link.as_str()).collect();
        names.extend(robot.fluid_shapes.iter().map(|shape| shape.link.as_str()));
        names.extend(robot.frames.iter().map(|frame| frame.link.as_str()));
        names.extend(robot.contact_exclusions.iter().flat_map(|(a, b)| [a.as_str(), b]));
        for equality in &robot.equalities {
            match &equality.kind {
                Equality::Connect { a: (a, _), b: (b, _) } | Equality::Weld { a, b, .. } => {
                    names.extend([a.as_str(), b]);
                }
                Equality::Joints { .. } | Equality::Tendons { .. } => {}
            }
        }
        for actuator in &robot.actuators {
            names.extend(actuator.transmission.frames());
            if let Transmission::Contacts { link } = &actuator.transmission {
                names.push(link);
            }
        }
        let paths = robot.spatial_tendons.iter().flat_map(|tendon| &tendon.path);
        names.extend(paths.flat_map(TendonPathElement::places));
        for sensor in &robot.sensors {
            for object in core::iter::once(&sensor.object).chain(&sensor.reference) {
                if let SensorObject::Named(name) | SensorObject::CenterOfMass(name) = object {
                    names.push(name);
                }
            }
        }
        names.into_iter().filter_map(|name| self.link_index.get(name).copied()).collect()
    }

    /// The body after a joint. Joints after links without mass and without references belong to the same
    /// body.
    pub(super) fn body_of(
        &mut self,
        joint: usize,
        is_fixed_to_world: bool,
        named: &HashSet<usize>,
    ) -> WrittenBody {
        let robot = self.robot;
        let mut joints = vec![joint];
        // The spring of a free body is at rest in the pose of the file.
        let rest = robot.joints[joint].spring.filter(|_| robot.joints[joint].kind == JointKind::Floating);
        let mut place = rest.map_or(robot.joints[joint].parent_from_joint, |spring| spring.rest);
        let mut dofs = robot.joints[joint].kind.nv();
        loop {
            let last = &robot.joints[joints[joints.len() - 1]];
            let link = self.link_index[last.child.as_str()];
            let next = match self.below[link][..] {
                [next] if self.is_bare(link) && !named.contains(&link) => next,
                _ => break,
            };
            let after = &robot.joints[next];
            let count = dofs + after.kind.nv();
            // The quaternion of a ball joint refers to the axes of the body, so later joints must not be
            // rotated.
            let turns_freely = joints.iter().any(|&joint| robot.joints[joint].kind == JointKind::Spherical);
            let is_turned = after.parent_from_joint.rotation != Pose::IDENTITY.rotation;
            let is_free = |kind: JointKind| matches!(kind, JointKind::Floating | JointKind::Fixed);
            let readers_own = robot.links[link].name == format!("{}/{}", after.child, last.name);
            if is_free(last.kind)
                || after.kind == JointKind::Floating
                || (after.kind == JointKind::Fixed && !readers_own)
                || count > DOF_LIMIT
                || (turns_freely && is_turned)
            {
                break;
            }
            if !readers_own {
                let message = "no mass between two joints, which MuJoCo refuses: both joints become those of the next body";
                self.add_note(&format!("link {:?}", robot.links[link].name), message);
            }
            place = place.compose(&after.parent_from_joint);
            dofs = count;
            joints.push(next);
        }
        let link = self.link_index[robot.joints[joints[joints.len() - 1]].child.as_str()];
        let moves = joints.iter().any(|&joint| robot.joints[joint].kind != JointKind::Fixed);
        WrittenBody { link, joints, place, is_fixed_to_world: is_fixed_to_world && !moves }
    }

    fn is_bare(&self, link: usize) -> bool {
        let link = &self.robot.links[link];
        link.mass_properties.is_none() && !self.link_sites.contains_key(link.name.as_str())
    }

    /// Whether the root link is the world body.
    pub(super) fn root_is_world(&self) -> bool {
        self.robot.base == robot_dynamics_description::Base::Fixed
            && self.robot.links[self.root].name == "world"
    }
}

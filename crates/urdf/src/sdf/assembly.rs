//! Makes a tree of links and joints from resolved frames.

use std::collections::HashSet;

use robot_dynamics_description::{
    FLOATING_BASE, FrameDescription, JointDescription, JointKind, LinkDescription, LinkShape, Mimic, Pose,
    RobotDescription, Surface,
};

use super::graph::{Edge, WORLD_NODE, orient, split};
use super::parts::{Axis, JointType, Parts, Place, SdfJoint, Target};
use super::poses::Resolved;
use crate::UrdfError;
use crate::reader::Reader;
use crate::tree::SourceLines;

/// A link is on an axis if its distance is below this part of its distance from the joint, or in m.
const ON_AXIS: f64 = 1e-12;

/// The bit of shapes that do not collide with other links of their model.
const OWN_BIT: u32 = 2;

const WORLD_NAME: &str = "world";

/// The robot so far.
pub(super) struct Assembly<'p, 'f> {
    pub(super) parts: &'p Parts<'f>,
    pub(super) resolved: &'p Resolved,
    pub(super) robot: RobotDescription,
    pub(super) lines: SourceLines,
    /// The place of the whole robot.
    line: usize,
    link_names: HashSet<String>,
    joint_names: HashSet<String>,
    /// The joints that others follow.
    leaders: HashSet<&'p str>,
}

impl<'p, 'f> Assembly<'p, 'f> {
    pub(super) fn new(parts: &'p Parts<'f>, resolved: &'p Resolved, name: &str, line: usize) -> Self {
        let mut robot = RobotDescription::new(name);
        if let Some(gravity) = parts.gravity {
            robot.gravity = gravity;
        }
        let link_names = parts.links.iter().map(|link| link.name.clone());
        let axes = parts.joints.iter().flat_map(|joint| &joint.axes);
        Self {
            parts,
            resolved,
            robot,
            lines: SourceLines { robot: line, links: Vec::new(), joints: Vec::new() },
            line,
            link_names: link_names.chain([WORLD_NAME.to_owned()]).collect(),
            joint_names: parts.joints.iter().map(|joint| joint.name.clone()).collect(),
            leaders: axes.filter_map(|axis| Some(axis.mimic.as_ref()?.joint.as_str())).collect(),
        }
    }

    /// Adds everything but the joints that close loops, and returns these.
    pub(super) fn run(&mut self, reader: &mut Reader<'_>) -> Vec<Edge> {
        self.add_links();
        let edges = self.edges(reader);
        let (tree, loops) = split(&self.parts.links, &edges);
        let order = orient(&self.parts.links, &tree);
        for (joint, from, to) in order {
            match joint {
                None => self.add_root(from, to),
                Some(joint) => {
                    let joint = &self.parts.joints[joint];
                    let is_reversed = self.node_of(&joint.child) == Some(from);
                    self.add_joint(reader, joint, (from, to), is_reversed);
                }
            }
        }
        self.free_name();
        self.add_frames(reader);
        self.add_shapes(&edges);
        loops
    }

    fn add_links(&mut self) {
        self.robot.links.push(LinkDescription::new(WORLD_NAME, None));
        self.lines.links.push(self.line);
        for link in &self.parts.links {
            let mut description = LinkDescription::new(&link.name, link.mass_properties);
            description.gravity_compensation = if link.has_gravity { 0.0 } else { 1.0 };
            self.robot.links.push(description);
            self.lines.links.push(link.at.line);
        }
    }

    /// The node that a frame moves with.
    fn node_of(&self, target: &Target) -> Option<usize> {
        let frame = self.parts.find(target, &Place::default(), &mut Vec::new())?;
        Some(self.resolved.links[frame].map_or(WORLD_NODE, |link| link + 1))
    }

    fn edges(&self, reader: &mut Reader<'_>) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (index, joint) in self.parts.joints.iter().enumerate() {
            if joint.is_static {
                let (line, place) = (joint.at.line, joint.at.place.clone());
                reader.report_ignored(line, place, "the model is static, so that its joints do not move");
                continue;
            }
            let [parent, child] = [&joint.parent, &joint.child].map(|target| {
                let found = self.parts.find(target, &joint.at, &mut reader.errors);
                found.map(|frame| self.resolved.links[frame].map_or(WORLD_NODE, |link| link + 1))
            });
            let (Some(parent), Some(child)) = (parent, child) else { continue };
            if parent == child || child == WORLD_NODE {
                let reason = if parent == child {
                    "it joins a link to itself; parent and child must differ"
                } else {
                    "its child does not move; exchange <parent> and <child>"
                };
                reader.refuse(bad(joint, reason.to_owned()));
                continue;
            }
            edges.push(Edge { joint: index, parent, child });
        }
        edges
    }

    pub(super) fn node_name(&self, node: usize) -> String {
        self.robot.links[node].name.clone()
    }

    pub(super) fn world_from(&self, node: usize) -> Pose {
        match node {
            WORLD_NODE => Pose::IDENTITY,
            _ => self.resolved.world_from_frame[self.parts.links[node - 1].frame],
        }
    }

    fn push_joint(&mut self, joint: JointDescription, line: usize) {
        self.joint_names.insert(joint.name.clone());
        self.robot.joints.push(joint);
        self.lines.joints.push(line);
    }

    /// Adds a link without mass, with a new name.
    fn push_link(&mut self, name: String, line: usize) -> String {
        let name = unique(&mut self.link_names, name);
        self.robot.links.push(LinkDescription::new(&name, None));
        self.lines.links.push(line);
        name
    }

    /// Fixes a static link to the world, or lets the root of a free part float.
    fn add_root(&mut self, from: usize, to: usize) {
        let link = &self.parts.links[to - 1];
        let kind = if link.is_static { JointKind::Fixed } else { JointKind::Floating };
        let name = unique(&mut self.joint_names, format!("{}_joint", link.name));
        let (line, parent, pose) = (link.at.line, self.node_name(from), self.world_from(to));
        self.push_joint(JointDescription::new(name, kind, parent, &link.name, pose), line);
    }

    /// A single free part has the joint name of a floating base.
    fn free_name(&mut self) {
        let mut free = self.robot.joints.iter_mut().filter(|joint| joint.kind == JointKind::Floating);
        if let (Some(joint), None) = (free.next(), free.next())
            && !self.joint_names.contains(FLOATING_BASE)
        {
            FLOATING_BASE.clone_into(&mut joint.name);
        }
    }

    fn add_joint(
        &mut self,
        reader: &mut Reader<'_>,
        joint: &SdfJoint,
        (from, to): (usize, usize),
        is_reversed: bool,
    ) {
        let line = joint.at.line;
        let (world_from_parent, world_from_child) = (self.world_from(from), self.world_from(to));
        let parent_from_world = world_from_parent.inverse();
        let (mut parent, child) = (self.node_name(from), self.node_name(to));
        if joint.kind == JointType::Fixed {
            let pose = parent_from_world.compose(&world_from_child);
            return self
                .push_joint(JointDescription::new(&joint.name, JointKind::Fixed, parent, child, pose), line);
        }
        let axes = self.world_axes(reader, joint);
        let world_from_joint = self.joint_frame(joint, &axes, &world_from_child);
        let mut parent_from_joint = parent_from_world.compose(&world_from_joint);
        let has_offset = world_from_joint != world_from_child;
        let is_single = joint.kind != JointType::TwoAxes || self.is_universal(joint, is_reversed);
        let end =
            if has_offset { self.push_link(format!("{}_frame", joint.name), line) } else { child.clone() };
        let local: Vec<[f64; 3]> = axes
            .iter()
            .map(|(world_from_axis, xyz)| {
                let axis = if *world_from_axis == world_from_joint {
                    *xyz
                } else {
                    world_from_joint.inverse().rotate(world_from_axis.rotate(*xyz))
                };
                if is_reversed { axis.map(|c| 0.0 - c) } else { axis }
            })
            .collect();
        if is_single {
            let kind = match (joint.kind, &local[..]) {
                (JointType::Revolute, &[axis]) => JointKind::Revolute { axis },
                (JointType::Continuous, &[axis]) => JointKind::Continuous { axis },
                (JointType::Prismatic, &[axis]) => JointKind::Prismatic { axis },
                (JointType::Screw, &[axis]) => JointKind::Helical { axis, pitch: joint.pitch },
                (JointType::TwoAxes, &[first, second]) => JointKind::Universal { first, second },
                (JointType::Ball, _) => JointKind::Spherical,
                // A missing axis is listed as an error.
                _ => JointKind::Fixed,
            };
            let made = JointDescription::new(&joint.name, kind, &parent, &end, parent_from_joint);
            self.push_joint(with_axis(made, joint.axes.first()), line);
        } else {
            let mut turns: Vec<(usize, [f64; 3])> = local.into_iter().enumerate().collect();
            if is_reversed {
                turns.reverse();
            }
            let count = turns.len();
            for (position, (number, axis)) in turns.into_iter().enumerate() {
                let is_last = position + 1 == count;
                let name = axis_name(&joint.name, number);
                let next = if is_last { end.clone() } else { self.push_link(format!("{name}_link"), line) };
                let kind = JointKind::Revolute { axis };
                let made = JointDescription::new(name, kind, &parent, &next, parent_from_joint);
                self.push_joint(with_axis(made, joint.axes.get(number)), line);
                (parent, parent_from_joint) = (next, Pose::IDENTITY);
            }
        }
        if has_offset {
            let name = unique(&mut self.joint_names, format!("{child}_fixed"));
            let pose = world_from_joint.inverse().compose(&world_from_child);
            self.push_joint(JointDescription::new(name, JointKind::Fixed, end, child, pose), line);
        }
        if is_reversed {
            let (line, place) = (joint.at.line, joint.at.place.clone());
            reader.report_ignored(
                line,
                place,
                "its child is nearer to the root of the tree: its motion is reversed",
            );
        }
    }

    /// For each axis the frame in which it is expressed, and its components.
    pub(super) fn world_axes(&self, reader: &mut Reader<'_>, joint: &SdfJoint) -> Vec<(Pose, [f64; 3])> {
        let of = |axis: &Axis, errors: &mut Vec<UrdfError>| {
            let frame = match &axis.expressed_in {
                None => joint.frame,
                Some(target) => self.parts.find(target, &joint.at, errors)?,
            };
            Some((self.resolved.world_from_frame[frame], axis.xyz))
        };
        joint.axes.iter().filter_map(|axis| of(axis, &mut reader.errors)).collect()
    }

    /// The frame in which the joint moves: that of the child, if the motion is the same.
    fn joint_frame(&self, joint: &SdfJoint, axes: &[(Pose, [f64; 3])], world_from_child: &Pose) -> Pose {
        let own = self.resolved.world_from_frame[joint.frame];
        let offset: [f64; 3] = core::array::from_fn(|i| world_from_child.translation[i] - own.translation[i]);
        let distance = norm(offset);
        let off_axis = match (joint.kind, axes) {
            (JointType::Prismatic, _) => 0.0,
            (JointType::Revolute | JointType::Continuous | JointType::Screw, [(world_from_axis, xyz)]) => {
                let axis = world_from_axis.rotate(*xyz);
                let length = norm(axis);
                let [x, y, z] = axis.map(|c| c / length);
                let [a, b, c] = offset;
                norm([b * z - c * y, c * x - a * z, a * y - b * x])
            }
            _ => distance,
        };
        if off_axis <= ON_AXIS * distance.max(1.0) { *world_from_child } else { own }
    }

    /// Whether one joint of two axes represents the joint: both have the same limits and forces.
    fn is_universal(&self, joint: &SdfJoint, is_reversed: bool) -> bool {
        let [first, second] = &joint.axes[..] else { return true };
        !is_reversed
            && first.limits == second.limits
            && first.passive == second.passive
            && first.mimic.is_none()
            && second.mimic.is_none()
            && !self.leaders.contains(joint.name.as_str())
    }

    fn add_frames(&mut self, reader: &mut Reader<'_>) {
        for frame in &self.parts.named_frames {
            let at = &self.parts.frames[frame.frame].at;
            if frame.name.is_empty() || !self.link_names.insert(frame.name.clone()) {
                let message = "a link has the name of this frame: the frame is omitted";
                reader.report_ignored(at.line, at.place.clone(), message);
                continue;
            }
            let node = self.resolved.links[frame.frame].map_or(WORLD_NODE, |link| link + 1);
            let pose = self.world_from(node).inverse().compose(&self.resolved.world_from_frame[frame.frame]);
            self.robot.frames.push(FrameDescription::new(&frame.name, self.node_name(node), pose));
        }
    }

    /// Adds shapes. Links of a model collide with each other only if one of them has `self_collide`, and
    /// never if a joint connects them.
    fn add_shapes(&mut self, edges: &[Edge]) {
        let collides = |node: usize| node != WORLD_NODE && self.parts.links[node - 1].self_collides;
        for edge in edges.iter().filter(|edge| edge.parent != WORLD_NODE) {
            if collides(edge.parent) || collides(edge.child) {
                let pair = (self.node_name(edge.parent), self.node_name(edge.child));
                self.robot.contact_exclusions.push(pair);
            }
        }
        for link in &self.parts.links {
            let world_from_link = self.resolved.world_from_frame[link.frame];
            for shape in &link.shapes {
                let relative = shape.relative_to.as_ref().and_then(|target| {
                    let frame = self.parts.find(target, &shape.at, &mut Vec::new())?;
                    Some(world_from_link.inverse().compose(&self.resolved.world_from_frame[frame]))
                });
                let pose =
                    relative.map_or(shape.pose, |link_from_frame| link_from_frame.compose(&shape.pose));
                let mut surface = shape.surface;
                if !link.self_collides && surface.contype != 0 {
                    (surface.contype, surface.conaffinity) = (OWN_BIT, !OWN_BIT);
                }
                if surface.contype != 0 && link.self_collides {
                    surface.conaffinity = u32::MAX;
                }
                let mut made = LinkShape::new(&link.name, shape.role, pose, shape.shape.clone())
                    .with_name(&shape.name)
                    .with_surface(if shape.role == robot_dynamics_description::ShapeRole::Visual {
                        Surface::default()
                    } else {
                        surface
                    });
                made.color = shape.color;
                self.robot.shapes.push(made);
            }
        }
    }
}

/// The name of a joint for one of two axes.
fn axis_name(joint: &str, number: usize) -> String {
    if number == 0 { joint.to_owned() } else { format!("{joint}_axis{}", number + 1) }
}

fn with_axis(mut joint: JointDescription, axis: Option<&Axis>) -> JointDescription {
    if let Some(axis) = axis {
        joint.limits = axis.limits;
        joint.passive = axis.passive;
        joint.mimic = axis.mimic.as_ref().map(|mimic| {
            Mimic::new(axis_name(&mimic.joint, usize::from(mimic.is_second_axis)), mimic.ratio, mimic.offset)
        });
    }
    joint
}

fn unique(names: &mut HashSet<String>, mut name: String) -> String {
    while !names.insert(name.clone()) {
        name.push('_');
    }
    name
}

pub(super) fn norm(x: [f64; 3]) -> f64 {
    x.iter().fold(0.0_f64, |norm, x| norm.hypot(*x))
}

pub(super) fn bad(joint: &SdfJoint, reason: String) -> UrdfError {
    UrdfError::BadSemantics { line: joint.at.line, place: joint.at.place.clone(), reason }
}

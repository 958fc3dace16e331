//! Makes a tree of links and joints, whose root is the link `world`.

use std::collections::HashSet;

use nalgebra::Vector3;
use robot_dynamics_description::{
    ActuatorDescription, FLOATING_BASE, FrameDescription, JointDescription, JointKind, LinkDescription, Pose,
    RobotDescription, Transmission,
};

use crate::drive::Drive;
use crate::findings::Findings;
use crate::geometry::Geometry;
use crate::joint::{Dof, Motion, UsdJoint, unit_vector};
use crate::names::{unique, unique_names};
use crate::transform::matrix;
use crate::tree::Group;

/// A point is on an axis if its distance is below this part of its distance from the joint, or in m. Points
/// are floats.
const ON_AXIS: f64 = 1e-9;

const WORLD_NAME: &str = "world";

/// The robot so far.
pub(crate) struct Assembly<'a> {
    pub(crate) geometry: &'a Geometry<'a>,
    pub(crate) joints: &'a [UsdJoint],
    pub(crate) robot: RobotDescription,
    pub(crate) link_names: HashSet<String>,
    joint_names: HashSet<String>,
    /// The names of the joints, in the order of `joints`.
    pub(crate) names: Vec<String>,
    /// The joints of the robot that stand for each joint, one for each of its axes.
    pub(crate) made: Vec<Vec<String>>,
}

impl<'a> Assembly<'a> {
    pub(crate) fn new(geometry: &'a Geometry<'a>, joints: &'a [UsdJoint], name: &str) -> Self {
        let mut link_names = HashSet::from([WORLD_NAME.to_owned()]);
        let mut joint_names = HashSet::new();
        let mut robot = RobotDescription::new(name);
        robot.links.push(LinkDescription::new(WORLD_NAME, None));
        let prims: Vec<usize> = joints.iter().map(|joint| joint.prim).collect();
        let names = unique_names(geometry.scene, &prims, &mut joint_names);
        for link in unique_names(geometry.scene, &geometry.bodies, &mut link_names) {
            robot.links.push(LinkDescription::new(link, None));
        }
        let made = vec![Vec::new(); joints.len()];
        Self { geometry, joints, robot, link_names, joint_names, names, made }
    }

    pub(crate) fn node_name(&self, node: usize) -> String {
        self.robot.links[node].name.clone()
    }

    /// Adds a link without mass, with a new name.
    fn push_link(&mut self, name: String) -> String {
        let name = unique(&mut self.link_names, name);
        self.robot.links.push(LinkDescription::new(&name, None));
        name
    }

    /// Lets the root of a part without joints to the world float.
    pub(crate) fn add_root(&mut self, node: usize) {
        let link = self.node_name(node);
        let name = unique(&mut self.joint_names, format!("{link}_joint"));
        let pose = self.geometry.world_from_node(node);
        self.robot.joints.push(JointDescription::new(name, JointKind::Floating, WORLD_NAME, link, pose));
    }

    /// Fixes a body to the world at its pose.
    pub(crate) fn fix(&mut self, node: usize) {
        let link = self.node_name(node);
        let name = unique(&mut self.joint_names, format!("{link}_joint"));
        let pose = self.geometry.world_from_node(node);
        self.robot.joints.push(JointDescription::new(name, JointKind::Fixed, WORLD_NAME, link, pose));
    }

    /// A single free part has the joint name of a floating base.
    pub(crate) fn free_name(&mut self) {
        let mut free = self.robot.joints.iter_mut().filter(|joint| joint.kind == JointKind::Floating);
        if let (Some(joint), None) = (free.next(), free.next())
            && joint.parent == WORLD_NAME
            && !self.names.contains(&joint.name)
            && !self.joint_names.contains(FLOATING_BASE)
        {
            FLOATING_BASE.clone_into(&mut joint.name);
        }
    }

    /// Adds joints in series from a node to another.
    pub(crate) fn add_group(&mut self, group: &Group, findings: &mut Findings) {
        let Group { joints, from, to } = group;
        let mut parent = self.node_name(*from);
        for (position, &index) in joints.iter().enumerate() {
            let joint = &self.joints[index];
            let is_last = position + 1 == joints.len();
            let sides = if joint.nodes[0] == *from { [0, 1] } else { [1, 0] };
            let [near, far] = sides.map(|side| joint.frames[side]);
            // Between two joints in series, the frame is that of the last link at rest.
            let near = if position == 0 { near } else { far };
            let child = if is_last {
                self.node_name(*to)
            } else {
                self.push_link(format!("{}_link", self.names[index]))
            };
            self.add_joint(index, (parent, near), (child.clone(), far), sides[0] == 1, findings);
            parent = child;
        }
    }

    /// Adds the axes of a joint in series. `near` and `far` are its frames in the parent and the child.
    fn add_joint(
        &mut self,
        index: usize,
        (mut parent, near): (String, Pose),
        (child, far): (String, Pose),
        is_reversed: bool,
        findings: &mut Findings,
    ) {
        let joint = &self.joints[index];
        let name = self.names[index].clone();
        if joint.dofs.is_empty() {
            let pose = near.compose(&far.inverse());
            self.robot.joints.push(JointDescription::new(name, JointKind::Fixed, parent, child, pose));
            return;
        }
        let mut dofs: Vec<&Dof> = joint.dofs.iter().collect();
        if is_reversed {
            dofs.reverse();
        }
        let prim = &self.geometry.scene.prims[joint.prim];
        if is_reversed && matches!(dofs[..], [Dof { motion: Motion::Ball | Motion::Free, .. }]) {
            findings
                .ignore(&prim.path, "its body1 is nearer to the root of the tree: its motion is reversed");
        }
        let mut pose = near;
        let mut made = Vec::new();
        let count = dofs.len();
        for (position, dof) in dofs.into_iter().enumerate() {
            let is_last = position + 1 == count;
            let uses_child_frame = is_last && keeps_frame(dof.motion, &far);
            let own = if dof.name.is_empty() { name.clone() } else { format!("{name}_{}", dof.name) };
            let own = if dof.name.is_empty() { own } else { unique(&mut self.joint_names, own) };
            let end = match (is_last, uses_child_frame) {
                (true, true) => child.clone(),
                (true, false) => self.push_link(format!("{name}_frame")),
                (false, _) => self.push_link(format!("{own}_link")),
            };
            let (frame, turn) =
                if uses_child_frame { (pose.compose(&far.inverse()), far) } else { (pose, Pose::IDENTITY) };
            let sign = if is_reversed { -1.0 } else { 1.0 };
            let axis = |axis: usize| (matrix(&turn) * unit_vector(axis) * sign).map(|c| c + 0.0).into();
            let kind = match dof.motion {
                Motion::Rotation(number) if has_limits(dof) => JointKind::Revolute { axis: axis(number) },
                Motion::Rotation(number) => JointKind::Continuous { axis: axis(number) },
                Motion::Translation(number) => JointKind::Prismatic { axis: axis(number) },
                Motion::Ball => JointKind::Spherical,
                Motion::Free => JointKind::Floating,
            };
            let mut description = JointDescription::new(&own, kind, &parent, &end, frame);
            description.limits = dof.limits;
            description.passive = dof.passive;
            self.robot.joints.push(description);
            made.push(own);
            if is_last && !uses_child_frame {
                let fixed = unique(&mut self.joint_names, format!("{child}_fixed"));
                let fixed = JointDescription::new(fixed, JointKind::Fixed, &end, &child, far.inverse());
                self.robot.joints.push(fixed);
            }
            (parent, pose) = (end, Pose::IDENTITY);
        }
        if is_reversed {
            made.reverse();
        }
        self.made[index] = made;
    }

    /// Adds the actuators of drives, except those of joints with other actuators.
    pub(crate) fn add_drives(&mut self, driven: &HashSet<usize>, findings: &mut Findings) {
        let mut names: HashSet<String> =
            self.robot.actuators.iter().map(|actuator| actuator.name.clone()).collect();
        for (index, joint) in self.joints.iter().enumerate() {
            let path = &self.geometry.scene.prims[joint.prim].path;
            for (dof, name) in joint.dofs.iter().zip(&self.made[index]) {
                let Some(drive) = dof.drive else { continue };
                if driven.contains(&index) {
                    findings.ignore(path, "an actuator acts on the joint: its drive is not in the model");
                    continue;
                }
                if matches!(dof.motion, Motion::Ball | Motion::Free) {
                    if drive.stiffness != 0.0 || drive.damping != 0.0 {
                        findings.leave_out(path, "a drive of a ball joint is not in the model");
                    }
                    continue;
                }
                let name_of_drive = unique(&mut names, name.clone());
                self.robot.actuators.push(actuator(name_of_drive, name, &drive));
                if drive.target != 0.0 || (drive.velocity != 0.0 && drive.stiffness == 0.0) {
                    let target = if drive.stiffness == 0.0 { drive.velocity } else { drive.target };
                    let message =
                        format!("the target {target} of its drive is the control of the actuator {name:?}");
                    findings.push(path, robot_dynamics_description::Disposition::Read, message);
                }
            }
        }
    }

    /// Adds sites as frames.
    pub(crate) fn add_frames(&mut self) {
        let geometry = self.geometry;
        let is_site = |at: &usize| {
            let prim = &geometry.scene.prims[*at];
            prim.has("NewtonSiteAPI") || prim.has("MjcSiteAPI")
        };
        let sites: Vec<usize> = (0..geometry.scene.prims.len()).filter(is_site).collect();
        let names = unique_names(geometry.scene, &sites, &mut self.link_names);
        for (site, name) in sites.into_iter().zip(names) {
            let link = self.node_name(geometry.node_of[site]);
            let pose = geometry.node_from_prim(site).rigid();
            self.robot.frames.push(FrameDescription::new(name, link, pose));
        }
    }
}

/// A drive as an actuator: its control is the target position, the target velocity of a damper without a
/// spring, or the force without both.
fn actuator(name: String, joint: &str, drive: &Drive) -> ActuatorDescription {
    let mut actuator = ActuatorDescription::new(name, Transmission::joint(joint, 1.0));
    if drive.stiffness != 0.0 {
        actuator = actuator.servo(drive.stiffness, drive.damping);
        actuator.bias.constant = drive.damping * drive.velocity;
    } else if drive.damping != 0.0 {
        actuator.gain.constant = drive.damping;
        actuator.bias.velocity = -drive.damping;
    }
    if drive.max_force >= 0.0 && drive.max_force < 1e30 {
        actuator.force_range = [-drive.max_force, drive.max_force];
        if drive.stiffness == 0.0 && drive.damping == 0.0 {
            actuator.control_range = actuator.force_range;
        }
    }
    actuator
}

fn has_limits(dof: &Dof) -> bool {
    dof.limits.lower.is_finite() || dof.limits.upper.is_finite()
}

/// Whether the motion in the joint's frame is one in the child's frame, with the axis turned.
fn keeps_frame(motion: Motion, far: &Pose) -> bool {
    let offset = Vector3::from(far.translation);
    let off_axis = match motion {
        Motion::Translation(_) => 0.0,
        Motion::Rotation(axis) => (matrix(far) * unit_vector(axis)).cross(&offset).norm(),
        Motion::Ball | Motion::Free => offset.norm(),
    };
    off_axis <= ON_AXIS * offset.norm().max(1.0)
}

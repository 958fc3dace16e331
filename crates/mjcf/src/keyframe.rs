//! Reads `<keyframe>`: named poses.

use std::collections::{HashMap, VecDeque};

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot_dynamics_description::{NamedPose, RobotDescription};
use robot_dynamics_xml::Resource;

use crate::MjcfError;
use crate::actuator::Actuators;
use crate::assembly::{ElementTable, JointEntry};
use crate::element::Element;
use crate::joint::JointType;
use crate::names::Names;
use crate::reader::Reader;
use crate::tree::Id;

/// The size of a joint's name, position and velocity in a pose, in numbers.
const JOINT_SIZE: usize = 16;

/// The name of the pose in which the file places the bodies.
const INITIAL: &str = "qpos0";

impl Reader<'_> {
    /// Reads all keyframes, and adds the pose of the file if it is not neutral.
    pub(crate) fn poses(
        &mut self,
        table: &ElementTable,
        actuators: &Actuators,
        robot: &mut RobotDescription,
    ) {
        let mut names = Names::default();
        let mut parts: HashMap<Id, Part> = HashMap::new();
        let all: Vec<Id> =
            self.tree.in_sections("keyframe").filter(|&id| self.tree.nodes[id].name == "key").collect();
        let size = JOINT_SIZE * table.joints.len() + actuators.nodes.len();
        for (index, id) in all.into_iter().enumerate() {
            let element = self.raw_element(id);
            if !self.charge(id, Resource::Numbers, size) {
                return;
            }
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = names.unique(&written.map_or_else(|| format!("key_{index}"), str::to_owned));
            let rest = KeyLists::at_rest(table, actuators);
            let lists = match self.tree.nodes[id].scope {
                Some(frame) => {
                    let part = parts.entry(frame).or_insert_with(|| self.part(frame, table, actuators));
                    self.read_part_lists(&element, part, rest)
                }
                None => self.read_lists(&element, rest),
            };
            let mut pose = self.named_pose(&element, name, table, &lists);
            if lists.has_controls {
                pose.controls = actuators
                    .read
                    .iter()
                    .map(|index| index.map_or(0.0, |index| lists.controls[index]))
                    .collect();
            }
            self.report_read(&element, "a keyframe");
            robot.poses.push(pose);
        }
        if !table.joints.iter().all(is_neutral) && names.reserve(INITIAL) {
            let positions = table.joints.iter().map(|joint| (joint.name.clone(), joint.initial.clone()));
            robot.poses.push(NamedPose::new(INITIAL, positions));
        }
    }

    /// The lists of a keyframe of the main model; `rest` completes and replaces them.
    fn read_lists(&mut self, element: &Element, rest: KeyLists) -> KeyLists {
        let q = self.read_list(element, "qpos", &rest.q);
        let v = self.read_list(element, "qvel", &rest.v);
        let controls = self.read_list(element, "ctrl", &rest.controls);
        KeyLists {
            q: q.unwrap_or(rest.q),
            v: v.unwrap_or(rest.v),
            has_controls: controls.is_some(),
            controls: controls.unwrap_or(rest.controls),
        }
    }

    /// The lists of a keyframe of an attached model, placed in those of the robot.
    fn read_part_lists(&mut self, element: &Element, part: &Part, rest: KeyLists) -> KeyLists {
        let mut lists = rest;
        let all = [("qpos", &mut lists.q), ("qvel", &mut lists.v), ("ctrl", &mut lists.controls)];
        for (which, (name, all)) in all.into_iter().enumerate() {
            let rest = vec![0.0; part.0[which].len()];
            if let Some(list) = self.read_list(element, name, &rest) {
                part.place(which, &list, all);
                lists.has_controls |= which == 2;
            }
        }
        lists
    }

    /// The positions and velocities of the joints in a keyframe.
    fn named_pose(
        &mut self,
        element: &Element,
        name: String,
        table: &ElementTable,
        lists: &KeyLists,
    ) -> NamedPose {
        let mut pose = NamedPose::new(name, []);
        let (mut at_q, mut at_v) = (0, 0);
        for joint in &table.joints {
            let (nq, nv) = (joint.initial.len(), joint.motion.dof_count());
            let own = &lists.q[at_q..at_q + nq];
            let (position, turn) = from_mujoco(joint, own).unwrap_or_else(|| {
                let message =
                    format!("qpos: the quaternion of joint {:?} is zero: taken as the identity", joint.name);
                self.warn(element, message);
                let place = &own[..own.len() - 4];
                ([place, &[0.0, 0.0, 0.0, 1.0]].concat(), UnitQuaternion::identity())
            });
            let mut velocity = lists.v[at_v..at_v + nv].to_vec();
            if joint.motion == JointType::Free {
                // MuJoCo's linear velocity is along the axes of the world, ours along those of the body.
                let linear = turn.inverse() * Vector3::new(velocity[0], velocity[1], velocity[2]);
                velocity[..3].copy_from_slice(linear.as_slice());
            }
            pose.positions.push((joint.name.clone(), position));
            if velocity.iter().any(|&v| v != 0.0) {
                pose.velocities.push((joint.name.clone(), velocity));
            }
            (at_q, at_v) = (at_q + nq, at_v + nv);
        }
        pose
    }

    /// A list with as many numbers as `rest`, which completes a shorter list; `None` if the attribute is
    /// missing or has an error. MuJoCo fills short lists since version 4.
    fn read_list(&mut self, element: &Element, attribute: &str, rest: &[f64]) -> Option<Vec<f64>> {
        let mut list = self.all_numbers(element, attribute)?;
        let count = rest.len();
        if list.len() < count {
            if !self.tree.has_copies {
                let message = format!(
                    "{attribute} has {} of {count} numbers: the others have their defaults",
                    list.len()
                );
                self.report_default(element, message);
            }
            list.extend(&rest[list.len()..]);
        }
        if list.len() == count {
            return Some(list);
        }
        let (line, place) = (element.line, element.place.clone());
        let (attribute, text) = (attribute.to_owned(), format!("{} …", list.first().copied().unwrap_or(0.0)));
        let (expected, found) = (count.to_string(), list.len());
        self.errors.push(MjcfError::WrongCount { line, place, attribute, text, expected, found });
        None
    }
}

/// The numbers of a keyframe, in MuJoCo's order.
struct KeyLists {
    q: Vec<f64>,
    v: Vec<f64>,
    controls: Vec<f64>,
    /// Whether the keyframe gives controls.
    has_controls: bool,
}

impl KeyLists {
    /// The pose in which the file places the bodies, at rest and without controls.
    fn at_rest(table: &ElementTable, actuators: &Actuators) -> Self {
        let dofs = table.joints.iter().map(|joint| joint.motion.dof_count()).sum();
        Self {
            q: table.joints.iter().flat_map(|joint| to_mujoco(joint, &joint.initial)).collect(),
            v: vec![0.0; dofs],
            controls: vec![0.0; actuators.nodes.len()],
            has_controls: false,
        }
    }
}

/// Maps the q, v and controls of an attached model to those of the robot.
struct Part([Vec<Option<usize>>; 3]);

impl Reader<'_> {
    /// The map for the model that was attached in a frame.
    fn part(&mut self, frame: Id, table: &ElementTable, actuators: &Actuators) -> Part {
        let tree = self.tree;
        let Some(origin) = tree.origins.get(&frame) else { return Part(Default::default()) };
        // The indices of each joint, once for each replica. The first replica belongs to the attachment.
        let mut found: HashMap<Id, VecDeque<(usize, usize)>> = HashMap::new();
        let (mut at_q, mut at_v) = (0, 0);
        for joint in &table.joints {
            found.entry(joint.node).or_default().push_back((at_q, at_v));
            (at_q, at_v) = (at_q + joint.initial.len(), at_v + joint.motion.dof_count());
        }
        let mut part: [Vec<Option<usize>>; 3] = Default::default();
        for (node, motion) in self.joints_in(origin.whole) {
            let own = if origin.whole == frame { Some(&node) } else { origin.attached.get(&node) };
            let at = own.and_then(|own| found.get_mut(own)?.pop_front());
            let (nq, nv) = (motion.positions(), motion.dof_count());
            part[0].extend((0..nq).map(|k| Some(at?.0 + k)));
            part[1].extend((0..nv).map(|k| Some(at?.1 + k)));
        }
        let mut controls: HashMap<Id, Vec<usize>> = HashMap::new();
        for (at, &node) in actuators.nodes.iter().enumerate() {
            controls.entry(node).or_default().push(at);
        }
        for own in &origin.actuators {
            match own.as_ref().and_then(|own| controls.get(own)) {
                Some(all) => part[2].extend(all.iter().map(|&at| Some(at))),
                None => part[2].push(None),
            }
        }
        Part(part)
    }
}

impl Part {
    /// Copies a list of the model to its places in `all`.
    fn place(&self, which: usize, list: &[f64], all: &mut [f64]) {
        for (at, number) in self.0[which].iter().zip(list) {
            if let Some(at) = *at {
                all[at] = *number;
            }
        }
    }
}

/// Whether the file places the bodies so that the joint is at zero.
fn is_neutral(joint: &JointEntry) -> bool {
    match joint.initial[..] {
        [angle] => angle == 0.0,
        [.., x, y, z, w] => {
            [x, y, z, w] == [0.0, 0.0, 0.0, 1.0]
                && joint.initial[..joint.initial.len() - 4].iter().all(|&x| x == 0.0)
        }
        _ => true,
    }
}

/// The q of a joint with its quaternion in the order w x y z.
fn to_mujoco(joint: &JointEntry, q: &[f64]) -> Vec<f64> {
    match (joint.motion, q) {
        (JointType::Ball, &[x, y, z, w]) => vec![w, x, y, z],
        (JointType::Free, &[a, b, c, x, y, z, w]) => vec![a, b, c, w, x, y, z],
        _ => q.to_vec(),
    }
}

/// Converts q from MuJoCo's order. Also returns the rotation of the normalized quaternion; `None` if it is
/// zero.
fn from_mujoco(joint: &JointEntry, q: &[f64]) -> Option<(Vec<f64>, UnitQuaternion<f64>)> {
    let turn = |w, x, y, z| UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-15);
    match (joint.motion, q) {
        (JointType::Ball, &[w, x, y, z]) => {
            let turn = turn(w, x, y, z)?;
            Some((vec![turn.i, turn.j, turn.k, turn.w], turn))
        }
        (JointType::Free, &[a, b, c, w, x, y, z]) => {
            let turn = turn(w, x, y, z)?;
            Some((vec![a, b, c, turn.i, turn.j, turn.k, turn.w], turn))
        }
        _ => Some((q.to_vec(), UnitQuaternion::identity())),
    }
}

//! `<keyframe>`: poses by name.

use std::collections::{HashMap, VecDeque};

use multibody::{NamedPose, RobotDescription};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::MjcfError;
use crate::actuator::Actuators;
use crate::assemble::{Placed, Places};
use crate::joint::Motion;
use crate::names::Names;
use crate::reader::{Element, Reader};
use crate::tree::Id;

/// The name of the pose that the file places the bodies in.
const INITIAL: &str = "qpos0";

impl Reader<'_> {
    /// All keyframes, and the file's own pose where that is not neutral.
    pub(crate) fn poses(&mut self, places: &Places, actuators: &Actuators, robot: &mut RobotDescription) {
        let mut names = Names::default();
        let mut parts: HashMap<Id, Part> = HashMap::new();
        let all: Vec<Id> =
            self.tree.in_sections("keyframe").filter(|&id| self.tree.nodes[id].name == "key").collect();
        for (index, id) in all.into_iter().enumerate() {
            let element = self.plain(id);
            let written = self.text(&element, "name").filter(|name| !name.is_empty());
            let name = names.free(&written.map_or_else(|| format!("key_{index}"), str::to_owned));
            let initial: Vec<f64> =
                places.joints.iter().flat_map(|joint| to_mujoco(joint, &joint.initial)).collect();
            let freedoms: usize = places.joints.iter().map(|joint| joint.motion.freedoms()).sum();
            let (q, v, controls) = if let Some(frame) = self.tree.nodes[id].scope {
                let part = parts.entry(frame).or_insert_with(|| self.part(frame, places, actuators));
                let mut all = [initial, vec![0.0; freedoms], vec![0.0; actuators.count]];
                let mut has_controls = false;
                for (which, name) in ["qpos", "qvel", "ctrl"].into_iter().enumerate() {
                    let rest = vec![0.0; part.0[which].len()];
                    if let Some(list) = self.stretch(&element, name, &rest) {
                        part.place(which, &list, &mut all[which]);
                        has_controls |= which == 2;
                    }
                }
                let [q, v, u] = all;
                (q, v, if has_controls { u } else { Vec::new() })
            } else {
                let q = self.stretch(&element, "qpos", &initial).unwrap_or(initial);
                let v = self.stretch(&element, "qvel", &vec![0.0; freedoms]);
                let controls = self.stretch(&element, "ctrl", &vec![0.0; actuators.count]);
                (q, v.unwrap_or_else(|| vec![0.0; freedoms]), controls.unwrap_or_default())
            };
            let mut pose = NamedPose::new(name, []);
            let (mut at_q, mut at_v) = (0, 0);
            for joint in &places.joints {
                let (nq, nv) = (joint.initial.len(), joint.motion.freedoms());
                let own = &q[at_q..at_q + nq];
                let (position, turn) = from_mujoco(joint, own).unwrap_or_else(|| {
                    let message =
                        format!("qpos: the quaternion of joint {:?} is zero: taken as no turn", joint.name);
                    self.as_written(&element, message);
                    let place = &own[..own.len() - 4];
                    ([place, &[0.0, 0.0, 0.0, 1.0]].concat(), UnitQuaternion::identity())
                });
                let mut velocity = v[at_v..at_v + nv].to_vec();
                if joint.motion == Motion::Free {
                    // Along the world's axes there, along the body's own here.
                    let linear = turn.inverse() * Vector3::new(velocity[0], velocity[1], velocity[2]);
                    velocity[..3].copy_from_slice(linear.as_slice());
                }
                pose.positions.push((joint.name.clone(), position));
                if velocity.iter().any(|&v| v != 0.0) {
                    pose.velocities.push((joint.name.clone(), velocity));
                }
                (at_q, at_v) = (at_q + nq, at_v + nv);
            }
            if !controls.is_empty() {
                pose.controls = actuators.read.iter().map(|&index| controls[index]).collect();
            }
            self.read(&element, "a pose");
            robot.poses.push(pose);
        }
        let is_neutral = |joint: &Placed| match joint.initial[..] {
            [angle] => angle == 0.0,
            [.., x, y, z, w] => {
                [x, y, z, w] == [0.0, 0.0, 0.0, 1.0]
                    && joint.initial[..joint.initial.len() - 4].iter().all(|&x| x == 0.0)
            }
            _ => true,
        };
        if !places.joints.iter().all(is_neutral) && names.take(INITIAL) {
            let positions = places.joints.iter().map(|joint| (joint.name.clone(), joint.initial.clone()));
            robot.poses.push(NamedPose::new(INITIAL, positions));
        }
    }

    /// A list of as many numbers as there are in `rest`, from which come those that a file leaves out that attaches or replicates
    /// parts; `None` where it is left out or wrong.
    fn stretch(&mut self, element: &Element, attribute: &str, rest: &[f64]) -> Option<Vec<f64>> {
        let mut list = self.all_numbers(element, attribute)?;
        let count = rest.len();
        if self.tree.grown && list.len() < count {
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

/// Where the numbers of a model are among those of the robot that a part of it was attached to: of q, of v, of the controls.
struct Part([Vec<Option<usize>>; 3]);

impl Reader<'_> {
    /// Of the model that the frame's contents are of.
    fn part(&mut self, frame: Id, places: &Places, actuators: &Actuators) -> Part {
        let tree = self.tree;
        let Some(origin) = tree.origins.get(&frame) else { return Part(Default::default()) };
        // Where each joint is, as often as replicates have it: the first ones are those of the attachment itself.
        let mut found: HashMap<Id, VecDeque<(usize, usize)>> = HashMap::new();
        let (mut at_q, mut at_v) = (0, 0);
        for joint in &places.joints {
            found.entry(joint.node).or_default().push_back((at_q, at_v));
            (at_q, at_v) = (at_q + joint.initial.len(), at_v + joint.motion.freedoms());
        }
        let mut part: [Vec<Option<usize>>; 3] = Default::default();
        for (node, motion) in self.joints_in(origin.whole) {
            let own = if origin.whole == frame { Some(&node) } else { origin.attached.get(&node) };
            let at = own.and_then(|own| found.get_mut(own)?.pop_front());
            let (nq, nv) = (motion.positions(), motion.freedoms());
            part[0].extend((0..nq).map(|k| Some(at?.0 + k)));
            part[1].extend((0..nv).map(|k| Some(at?.1 + k)));
        }
        let index: HashMap<Id, usize> =
            actuators.nodes.iter().enumerate().map(|(at, &node)| (node, at)).collect();
        part[2] = origin.actuators.iter().map(|own| index.get(own.as_ref()?).copied()).collect();
        Part(part)
    }
}

impl Part {
    /// A list of the model's, put where it belongs among `all`.
    fn place(&self, which: usize, list: &[f64], all: &mut [f64]) {
        for (at, number) in self.0[which].iter().zip(list) {
            if let Some(at) = *at {
                all[at] = *number;
            }
        }
    }
}

/// A joint's q with its quaternion as w x y z.
fn to_mujoco(joint: &Placed, q: &[f64]) -> Vec<f64> {
    match (joint.motion, q) {
        (Motion::Ball, &[x, y, z, w]) => vec![w, x, y, z],
        (Motion::Free, &[a, b, c, x, y, z, w]) => vec![a, b, c, w, x, y, z],
        _ => q.to_vec(),
    }
}

/// The other way, the quaternion normalised, with the turn that it is; `None` where it is zero.
fn from_mujoco(joint: &Placed, q: &[f64]) -> Option<(Vec<f64>, UnitQuaternion<f64>)> {
    let turn = |w, x, y, z| UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-15);
    match (joint.motion, q) {
        (Motion::Ball, &[w, x, y, z]) => {
            let turn = turn(w, x, y, z)?;
            Some((vec![turn.i, turn.j, turn.k, turn.w], turn))
        }
        (Motion::Free, &[a, b, c, w, x, y, z]) => {
            let turn = turn(w, x, y, z)?;
            Some((vec![a, b, c, turn.i, turn.j, turn.k, turn.w], turn))
        }
        _ => Some((q.to_vec(), UnitQuaternion::identity())),
    }
}

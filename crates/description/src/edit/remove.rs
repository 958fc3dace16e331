//! Removes parts, with everything that refers to them.

use std::collections::{HashMap, HashSet};

use super::names::missing;
use super::note::EditNote;
use crate::sensor::ObjectSort;
use crate::{Equality, ModelError, RobotDescription, SensorObject, TendonPathElement, Transmission};

/// The names of removed parts.
#[derive(Default)]
struct Removed {
    links: HashSet<String>,
    joints: HashSet<String>,
    frames: HashSet<String>,
    shapes: HashSet<String>,
    tendons: HashSet<String>,
    actuators: HashSet<String>,
}

/// The links that joints lead to from these links, with these.
fn reached<'a>(
    children: &HashMap<&'a str, Vec<&'a str>>,
    from: impl Iterator<Item = &'a str>,
) -> HashSet<&'a str> {
    let (mut links, mut pending) = (HashSet::new(), from.collect::<Vec<_>>());
    while let Some(link) = pending.pop() {
        if links.insert(link) {
            pending.extend(children.get(link).into_iter().flatten());
        }
    }
    links
}

impl RobotDescription {
    /// Removes a joint with the links behind it, and with every part that refers to them. Returns the other
    /// parts that were removed or changed; the joints, links, frames and shapes behind the joint are not
    /// listed. Links that are also behind another joint stay: if a link has two parents, this cuts the loop.
    ///
    /// Actuators, sensors, tendons, equalities and contact pairs with a reference to a removed part are
    /// removed. A mimic joint whose leader is removed moves by itself. Named poses lose the values of removed
    /// joints and the controls of removed actuators.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    /// let notes = robot.remove_joint("hinge")?;
    /// assert_eq!((robot.links.len(), robot.joints.len(), robot.frames.len()), (1, 0, 0));
    /// assert_eq!(notes[0].place, "actuator `motor`");
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] for an unknown joint.
    pub fn remove_joint(&mut self, name: &str) -> Result<Vec<EditNote>, ModelError> {
        let cut = self.joint_index(name)?;
        let mut children = HashMap::<&str, Vec<&str>>::new();
        for (_, joint) in self.joints.iter().enumerate().filter(|(index, _)| *index != cut) {
            children.entry(&joint.parent).or_default().push(&joint.child);
        }
        let top = self.joints[cut].child.as_str();
        let moved: HashSet<&str> = self.joints.iter().map(|joint| joint.child.as_str()).collect();
        let roots = self.links.iter().map(|link| link.name.as_str()).filter(|link| !moved.contains(link));
        let held = reached(&children, roots);
        let behind = reached(&children, [top].into_iter());
        let links = behind.difference(&held).map(|link| (*link).to_owned()).collect();
        let joints = HashSet::from([name.to_owned()]);
        Ok(self.remove_parts(Removed { links, joints, ..Removed::default() }))
    }

    /// Removes an equality, for example to cut a loop that it closes. Returns the actuators and sensors that
    /// were removed with its frames.
    ///
    /// ```
    /// use robot_dynamics::description::{Equality, EqualityDescription, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let pin = Equality::Connect { a: ("ceiling".into(), [0.0; 3]), b: ("rod".into(), [0.0; 3]) };
    /// robot.equalities.push(EqualityDescription::new("pin", pin));
    /// assert!(robot.remove_equality("pin")?.is_empty() && robot.equalities.is_empty());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError::Input`] for an unknown equality.
    pub fn remove_equality(&mut self, name: &str) -> Result<Vec<EditNote>, ModelError> {
        let Some(index) = self.equalities.iter().position(|equality| equality.name == name) else {
            let names = self.equalities.iter().map(|equality| equality.name.as_str());
            return Err(missing("equality", name, names).into());
        };
        let equality = self.equalities.remove(index);
        let frames = equality.frames().into_iter().map(|frame| frame.name).collect();
        Ok(self.remove_parts(Removed { frames, ..Removed::default() }))
    }

    /// Removes parts and everything that refers to them, in the order of their references.
    fn remove_parts(&mut self, mut removed: Removed) -> Vec<EditNote> {
        let mut notes = Vec::new();
        self.remove_links(&mut removed, &mut notes);
        self.remove_couplings(&mut removed, &mut notes);
        self.remove_actuators_and_sensors(&mut removed, &mut notes);
        for pose in &mut self.poses {
            let mut joints = Vec::new();
            for values in [&mut pose.positions, &mut pose.velocities] {
                values.retain(|(joint, _)| {
                    let is_removed = removed.joints.contains(joint);
                    if is_removed && !joints.contains(joint) {
                        joints.push(joint.clone());
                    }
                    !is_removed
                });
            }
            if !joints.is_empty() {
                let message = format!("the values of {} were removed", joints.join(", "));
                notes.push(EditNote::new(format!("pose `{}`", pose.name), message));
            }
        }
        if let Some(joints) = &mut self.actuated_joints {
            joints.retain(|joint| !removed.joints.contains(joint));
        }
        self.remove_members(&removed, &mut notes);
        notes
    }

    /// The links and joints of groups, and end effectors on removed links.
    fn remove_members(&mut self, removed: &Removed, notes: &mut Vec<EditNote>) {
        let Removed { links, joints, .. } = removed;
        for group in &mut self.groups {
            let before = (group.links.len(), group.joints.len(), group.chains.len());
            group.links.retain(|link| !links.contains(link));
            group.joints.retain(|joint| !joints.contains(joint));
            group.chains.retain(|(base, tip)| !links.contains(base) && !links.contains(tip));
            if before != (group.links.len(), group.joints.len(), group.chains.len()) {
                let message = "its removed links and joints were removed";
                notes.push(EditNote::new(format!("group `{}`", group.name), message));
            }
        }
        self.end_effectors.retain(|tool| {
            let is_removed = links.contains(&tool.parent_link);
            if is_removed {
                notes.push(note("end effector", &tool.name, "link", &tool.parent_link));
            }
            !is_removed
        });
    }

    /// Links with their joints, frames, shapes and pairs.
    fn remove_links(&mut self, removed: &mut Removed, notes: &mut Vec<EditNote>) {
        let Removed { links, joints, frames, shapes, .. } = removed;
        self.links.retain(|link| !links.contains(&link.name));
        self.joints.retain(|joint| {
            let is_removed = links.contains(&joint.child) || joints.contains(&joint.name);
            if is_removed {
                joints.insert(joint.name.clone());
            }
            !is_removed
        });
        self.frames.retain(|frame| {
            let is_removed = links.contains(&frame.link);
            if is_removed {
                frames.insert(frame.name.clone());
            }
            !is_removed
        });
        self.shapes.retain(|shape| {
            let is_removed = links.contains(&shape.link);
            if is_removed && !shape.name.is_empty() {
                shapes.insert(shape.name.clone());
            }
            !is_removed
        });
        self.fluid_shapes.retain(|shape| !links.contains(&shape.link));
        for shape in &self.shapes {
            shapes.remove(&shape.name);
        }
        self.contact_exclusions.retain(|(one, other)| {
            let Some(link) = [one, other].into_iter().find(|link| links.contains(*link)) else { return true };
            let inside = links.contains(one) && links.contains(other);
            if !inside {
                let place = format!("contact exclusion of `{one}` and `{other}`");
                notes.push(EditNote::new(place, format!("removed with link `{link}`")));
            }
            false
        });
        self.contact_pairs.retain(|pair| {
            let Some(shape) = pair.shapes.iter().find(|shape| shapes.contains(*shape)) else { return true };
            let place = format!("contact pair of `{}` and `{}`", pair.shapes[0], pair.shapes[1]);
            notes.push(EditNote::new(place, format!("removed with shape `{shape}`")));
            false
        });
    }

    /// Mimic joints, tendons and equalities.
    fn remove_couplings(&mut self, removed: &mut Removed, notes: &mut Vec<EditNote>) {
        let Removed { links, joints, frames, tendons, .. } = removed;
        for joint in &mut self.joints {
            if let Some(mimic) = joint.mimic.take_if(|mimic| joints.contains(&mimic.joint)) {
                let message = format!("it followed joint `{}`, and now moves by itself", mimic.joint);
                notes.push(EditNote::new(format!("joint `{}`", joint.name), message));
            }
        }
        self.tendons.retain(|tendon| {
            let Some((joint, _)) = tendon.terms.iter().find(|(joint, _)| joints.contains(joint)) else {
                return true;
            };
            tendons.insert(tendon.name.clone());
            notes.push(note("tendon", &tendon.name, "joint", joint));
            false
        });
        self.spatial_tendons.retain(|tendon| {
            let is_removed = |name: &&str| links.contains(*name) || frames.contains(*name);
            let Some(place) = tendon.path.iter().flat_map(TendonPathElement::places).find(is_removed) else {
                return true;
            };
            tendons.insert(tendon.name.clone());
            let sort = if links.contains(place) { "link" } else { "frame" };
            notes.push(note("tendon", &tendon.name, sort, place));
            false
        });
        self.equalities.retain(|equality| {
            let (sort, all, removed) = match &equality.kind {
                Equality::Joints { joint: own, leader, .. } => {
                    ("joint", with_leader(own, leader.as_ref()), &*joints)
                }
                Equality::Tendons { tendon: own, leader, .. } => {
                    ("tendon", with_leader(own, leader.as_ref()), &*tendons)
                }
                Equality::Connect { a, b } => ("link", vec![&a.0, &b.0], &*links),
                Equality::Weld { a, b, .. } => ("link", vec![a, b], &*links),
            };
            let Some(name) = all.into_iter().find(|name| removed.contains(*name)) else { return true };
            frames.extend(equality.frames().into_iter().map(|frame| frame.name));
            notes.push(note("equality", &equality.name, sort, name));
            false
        });
    }

    fn remove_actuators_and_sensors(&mut self, removed: &mut Removed, notes: &mut Vec<EditNote>) {
        let Removed { links, joints, frames, shapes, tendons, actuators } = removed;
        let kept: Vec<bool> = self
            .actuators
            .iter()
            .map(|actuator| {
                let cause = match &actuator.transmission {
                    Transmission::Joint { joint, .. } | Transmission::JointInParent { joint, .. } => {
                        joints.contains(joint).then_some(("joint", joint.as_str()))
                    }
                    Transmission::Tendon { tendon, .. } => {
                        tendons.contains(tendon).then_some(("tendon", tendon.as_str()))
                    }
                    Transmission::Contacts { link } => {
                        links.contains(link).then_some(("link", link.as_str()))
                    }
                    other => {
                        let is_removed = |name: &&str| frames.contains(*name) || links.contains(*name);
                        other.frames().find(is_removed).map(|name| ("frame", name))
                    }
                };
                if let Some((sort, name)) = cause {
                    actuators.insert(actuator.name.clone());
                    notes.push(note("actuator", &actuator.name, sort, name));
                }
                cause.is_none()
            })
            .collect();
        for pose in self.poses.iter_mut().filter(|pose| pose.controls.len() == kept.len()) {
            let mut kept = kept.iter();
            pose.controls.retain(|_| kept.next().copied().unwrap_or(true));
        }
        let mut kept = kept.iter();
        self.actuators.retain(|_| kept.next().copied().unwrap_or(true));
        self.sensors.retain(|sensor| {
            let cause = |object: &SensorObject, sort: ObjectSort| {
                let (name, sets): (&String, &[(&'static str, &HashSet<String>)]) = match object {
                    SensorObject::Robot => return None,
                    SensorObject::Shape(name) => (name, &[("shape", shapes)]),
                    SensorObject::CenterOfMass(name) => (name, &[("link", links)]),
                    SensorObject::Named(name) => match sort {
                        ObjectSort::Joint | ObjectSort::Ball => (name, &[("joint", joints)]),
                        ObjectSort::Tendon => (name, &[("tendon", tendons)]),
                        ObjectSort::Actuator => (name, &[("actuator", actuators)]),
                        _ => (name, &[("link", links), ("frame", frames)]),
                    },
                };
                let found = sets.iter().find(|(_, names)| names.contains(name));
                found.map(|(sort, _)| (*sort, name.clone()))
            };
            let reference = sensor.reference.as_ref().and_then(|object| cause(object, ObjectSort::Frame));
            let Some((sort, name)) = cause(&sensor.object, sensor.kind.sort()).or(reference) else {
                return true;
            };
            notes.push(note("sensor", &sensor.name, sort, &name));
            false
        });
    }
}

/// A part that was removed because another one was.
fn note(sort: &str, name: &str, cause: &str, cause_name: &str) -> EditNote {
    EditNote::new(format!("{sort} `{name}`"), format!("removed with {cause} `{cause_name}`"))
}

/// The names of a relation's position and of its leader.
fn with_leader<'a>(own: &'a (String, f64), leader: Option<&'a (String, f64)>) -> Vec<&'a String> {
    core::iter::once(own).chain(leader).map(|(name, _)| name).collect()
}

//! Makes another link the root.

use std::collections::HashMap;

use super::motion::{moved_by, velocity_of};
use super::note::EditNote;
use super::reverse::{reversed, reversed_state};
use crate::sensor::ObjectSort;
use crate::{
    Base, JointDescription, JointKind, LinkDescription, ModelError, NamedPose, Pose, Quaternion,
    RobotDescription, SensorObject, Transmission,
};

const NO_FORM: &str = "the force of its actuator has no form in the reversed coordinates";

/// The joints between the old and the new root.
struct Path {
    /// From the new root to the old one.
    joints: Vec<usize>,
    /// The old root.
    from: String,
    /// The floating joint of the description that carries the old root.
    floating: Option<usize>,
}

impl RobotDescription {
    /// Makes another link the root: the joints between the two are reversed. Their frames, names, links and
    /// all other parts stay. Returns the parts that changed.
    ///
    /// A robot that floats, by its base or by a floating joint, keeps its dynamics. q and v of its floating
    /// joint become the pose and velocity of the new root, and named poses are converted. A robot with a
    /// fixed base is held at the new root instead of the old one, and the new root's frame is the world's.
    ///
    /// A reversed revolute, continuous, prismatic or helical joint has the opposite axis and the same q. The
    /// angles of a universal joint change places. A planar or spherical joint has the inverse motion. If the
    /// joint's frame is not that of the parent link, a link without mass carries the parent: its name is that
    /// of the joint with `_axis`.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.base = Base::Floating;
    /// robot.set_root("rod")?;
    /// assert_eq!(robot.joints[0].parent, "rod");
    /// assert_eq!(Model::new(robot)?.nv(), 7);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`] if the link is unknown, the joints form no tree, or a joint has forces that the
    /// reversed joint cannot express. The robot is then unchanged.
    pub fn set_root(&mut self, link: &str) -> Result<Vec<EditNote>, ModelError> {
        self.link_index(link)?;
        let path = self.path_to_root(link)?;
        if path.joints.is_empty() {
            return Ok(Vec::new());
        }
        let mut edited = self.clone();
        let mut notes = Vec::new();
        edited.move_floating_joint(&path, link, &mut notes)?;
        edited.convert_poses(&path)?;
        for &index in &path.joints {
            edited.reverse_joint(index, &mut notes)?;
        }
        *self = edited;
        Ok(notes)
    }

    fn path_to_root(&self, link: &str) -> Result<Path, ModelError> {
        let carriers: HashMap<&str, usize> =
            self.joints.iter().enumerate().map(|(index, joint)| (joint.child.as_str(), index)).collect();
        let (mut joints, mut from) = (Vec::new(), link);
        while let Some(&index) = carriers.get(from) {
            let joint = &self.joints[index];
            if joint.kind == JointKind::Floating {
                return Ok(Path { joints, from: from.to_owned(), floating: Some(index) });
            }
            if joints.len() == self.joints.len() {
                return Err(ModelError::Cycle { links: vec![from.to_owned()] });
            }
            joints.push(index);
            from = &joint.parent;
        }
        Ok(Path { joints, from: from.to_owned(), floating: None })
    }

    /// The joint's position in a pose, or its neutral one; and its velocity.
    fn state_in(&self, joint: &JointDescription, pose: &NamedPose) -> (Vec<f64>, Vec<f64>) {
        if let Some(mimic) = &joint.mimic
            && let Some(leader) = self.joints.iter().find(|leader| leader.name == mimic.joint)
            && leader.name != joint.name
        {
            let (q, v) = self.state_in(leader, pose);
            if let (Some(q), Some(v)) = (q.first(), v.first()) {
                return (vec![mimic.ratio * q + mimic.offset], vec![mimic.ratio * v]);
            }
        }
        own_state(&joint.name, &joint.kind, pose)
    }

    /// `old_root_from_new_root` in a pose, and the velocity of the new root's frame along its axes, linear
    /// and angular, for that of the old root.
    fn along(&self, path: &Path, pose: &NamedPose, old: [[f64; 3]; 2]) -> Option<(Pose, [[f64; 3]; 2])> {
        let (mut placement, mut velocity) = (Pose::IDENTITY, old);
        for &index in path.joints.iter().rev() {
            let joint = &self.joints[index];
            let (q, v) = self.state_in(joint, pose);
            let step = joint.parent_from_joint.compose(&moved_by(&joint.kind, &q)?);
            velocity = carried_along(&step, velocity, velocity_of(&joint.kind, &q, &v)?);
            placement = placement.compose(&step);
        }
        Some((placement, velocity))
    }

    /// Gives the floating joint to the new root, and its actuators to the old one.
    fn move_floating_joint(
        &mut self,
        path: &Path,
        link: &str,
        notes: &mut Vec<EditNote>,
    ) -> Result<(), ModelError> {
        let name = match path.floating {
            Some(index) => self.joints[index].name.clone(),
            None if self.base == Base::Floating => self.floating_base_name(),
            None => {
                let message = format!("link `{link}` is fixed to the world, instead of link `{}`", path.from);
                notes.push(EditNote::new("base", message));
                return Ok(());
            }
        };
        if let Some(index) = path.floating {
            let neutral = self.along(path, &NamedPose::default(), [[0.0; 3]; 2]);
            let (old_from_new, _) = neutral.ok_or_else(|| no_motion(&name))?;
            let joint = &mut self.joints[index];
            if joint.passive != crate::PassiveForces::default()
                || joint.spring.is_some()
                || !joint.higher_terms.is_zero()
            {
                let reason = "its passive forces act on the old root";
                return Err(ModelError::Irreversible { joint: name, reason });
            }
            joint.parent_from_joint = joint.parent_from_joint.compose(&old_from_new);
            link.clone_into(&mut joint.child);
        }
        for actuator in &mut self.actuators {
            if let Transmission::JointInParent { joint, .. } = &actuator.transmission
                && *joint == name
            {
                return Err(ModelError::Irreversible { joint: name, reason: NO_FORM });
            }
            if let Transmission::Joint { joint, gear } = &actuator.transmission
                && *joint == name
            {
                let message = format!("its force acts on link `{}`, instead of joint `{name}`", path.from);
                notes.push(EditNote::new(format!("actuator `{}`", actuator.name), message));
                // v of a floating joint is the velocity of its child along the child's axes.
                actuator.transmission = Transmission::Frame { frame: path.from.clone(), gear: *gear };
            }
        }
        Ok(())
    }

    /// Converts named poses to the coordinates of the reversed joints. The joints are not reversed yet; the
    /// floating joint is.
    fn convert_poses(&mut self, path: &Path) -> Result<(), ModelError> {
        let floating = match path.floating {
            Some(index) => Some(self.joints[index].name.clone()),
            None => (self.base == Base::Floating).then(|| self.floating_base_name()),
        };
        let neutral = self.along(path, &NamedPose::default(), [[0.0; 3]; 2]);
        let mut poses = self.poses.clone();
        for pose in &mut poses {
            let before = pose.clone();
            if let Some(name) = &floating {
                let (q, v) = own_state(name, &JointKind::Floating, &before);
                let converted = moved_by(&JointKind::Floating, &q).and_then(|old| {
                    let twist = velocity_of(&JointKind::Floating, &q, &v)?;
                    let (placement, twist) = self.along(path, &before, twist)?;
                    let new = old.compose(&placement);
                    // Relative to the joint's frame, which moved with the neutral configuration.
                    let offset = neutral.filter(|_| path.floating.is_some());
                    Some((offset.map_or(new, |(offset, _)| offset.inverse().compose(&new)), twist))
                });
                let (new, twist) = converted.ok_or_else(|| no_motion(name))?;
                let turn = Quaternion::from_rotation(&new.rotation).to_xyzw();
                let moves = twist.as_flattened().iter().any(|x| *x != 0.0);
                set(&mut pose.positions, name, [&new.translation[..], &turn[..]].concat(), true);
                set(&mut pose.velocities, name, twist.as_flattened().to_vec(), moves);
            }
            for &index in &path.joints {
                let joint = &self.joints[index];
                let (q, v) = own_state(&joint.name, &joint.kind, &before);
                let (q, v) = reversed_state(&joint.kind, &q, &v).ok_or_else(|| no_motion(&joint.name))?;
                let moves = v.iter().any(|x| *x != 0.0);
                set(&mut pose.positions, &joint.name, q, false);
                set(&mut pose.velocities, &joint.name, v, moves);
            }
        }
        self.poses = poses;
        Ok(())
    }

    fn reverse_joint(&mut self, index: usize, notes: &mut Vec<EditNote>) -> Result<(), ModelError> {
        let joint = self.joints[index].clone();
        let reversed = reversed(&joint)?;
        self.reverse_actuators(&joint)?;
        for sensor in &self.sensors {
            let is_named = matches!(&sensor.object, SensorObject::Named(name) if *name == joint.name);
            if sensor.kind.sort() == ObjectSort::Ball && is_named {
                let message = format!(
                    "it measures the motion of link `{}` relative to link `{}`, which is the inverse",
                    joint.parent, joint.child
                );
                notes.push(EditNote::new(format!("sensor `{}`", sensor.name), message));
            }
        }
        if !matches!(joint.kind.nv(), 0 | 1) {
            let message = "its coordinates are those of the inverse motion";
            notes.push(EditNote::new(format!("joint `{}`", joint.name), message));
        }
        let mut child = joint.parent.clone();
        if let Some(joint_from_old) = reversed.carried {
            let carrier = self.free_name(&format!("{}_axis", joint.name));
            let old = self.links.iter().find(|link| link.name == joint.parent);
            let gravity_compensation = old.map_or(0.0, |link| link.gravity_compensation);
            self.links.push(LinkDescription { gravity_compensation, ..LinkDescription::new(&carrier, None) });
            let name = self.free_name(&format!("{}_offset", joint.name));
            let fixed = JointKind::Fixed;
            self.joints.push(JointDescription::new(name, fixed, &carrier, &joint.parent, joint_from_old));
            notes.push(EditNote::new(
                format!("link `{}`", joint.parent),
                format!("joint `{}` moves it by the new link `{carrier}` without mass", joint.name),
            ));
            child = carrier;
        }
        let own = &mut self.joints[index];
        (own.parent, own.child) = (joint.child, child);
        (own.kind, own.parent_from_joint) = (reversed.kind, reversed.parent_from_joint);
        own.spring = reversed.spring;
        Ok(())
    }

    /// Adapts the actuators on a joint of several degrees of freedom.
    fn reverse_actuators(&mut self, reversed: &JointDescription) -> Result<(), ModelError> {
        for actuator in &mut self.actuators {
            match (&mut actuator.transmission, reversed.kind) {
                (Transmission::Joint { joint, gear }, JointKind::Universal { .. })
                    if *joint == reversed.name =>
                {
                    gear.swap(0, 1);
                }
                (
                    Transmission::Joint { joint, .. } | Transmission::JointInParent { joint, .. },
                    JointKind::Planar { .. } | JointKind::Spherical,
                ) if *joint == reversed.name => {
                    return Err(ModelError::Irreversible { joint: joint.clone(), reason: NO_FORM });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// A name that no link, frame or joint has.
    fn free_name(&self, name: &str) -> String {
        let is_taken = |name: &str| {
            self.links.iter().any(|link| link.name == name)
                || self.frames.iter().any(|frame| frame.name == name)
                || self.joints.iter().any(|joint| joint.name == name)
        };
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        core::iter::once(name.to_owned()).chain(numbered).find(|name| !is_taken(name)).unwrap_or_default()
    }
}

/// The joint's own position and velocity in a pose; neutral and at rest if the pose does not give them.
fn own_state(name: &str, kind: &JointKind, pose: &NamedPose) -> (Vec<f64>, Vec<f64>) {
    let given = |values: &[(String, Vec<f64>)], width: usize| {
        let found = values.iter().find(|(joint, _)| joint == name);
        found.map(|(_, values)| values.clone()).filter(|values| values.len() == width)
    };
    let neutral = || {
        let mut q = vec![0.0; kind.nq()];
        if kind.nq() > kind.nv()
            && let Some(last) = q.last_mut()
        {
            *last = 1.0;
        }
        q
    };
    let q = given(&pose.positions, kind.nq()).unwrap_or_else(neutral);
    (q, given(&pose.velocities, kind.nv()).unwrap_or_else(|| vec![0.0; kind.nv()]))
}

/// The velocity of a child's frame along its axes, from its parent's and its own relative to the parent.
fn carried_along(
    parent_from_child: &Pose,
    [linear, angular]: [[f64; 3]; 2],
    own: [[f64; 3]; 2],
) -> [[f64; 3]; 2] {
    let back = Pose { translation: [0.0; 3], ..*parent_from_child }.inverse();
    let [px, py, pz] = parent_from_child.translation;
    let [wx, wy, wz] = angular;
    let at_child =
        [linear[0] + wy * pz - wz * py, linear[1] + wz * px - wx * pz, linear[2] + wx * py - wy * px];
    let [linear, angular] = [back.rotate(at_child), back.rotate(angular)];
    [core::array::from_fn(|i| linear[i] + own[0][i]), core::array::from_fn(|i| angular[i] + own[1][i])]
}

/// Replaces the values of a joint, or adds them if asked.
fn set(values: &mut Vec<(String, Vec<f64>)>, joint: &str, new: Vec<f64>, adds: bool) {
    match values.iter_mut().find(|(name, _)| name == joint) {
        Some((_, old)) => *old = new,
        None if adds => values.push((joint.to_owned(), new)),
        None => {}
    }
}

fn no_motion(joint: &str) -> ModelError {
    ModelError::Irreversible { joint: joint.to_owned(), reason: "its axis or its quaternion is zero" }
}

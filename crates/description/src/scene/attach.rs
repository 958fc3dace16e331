//! Attaches a robot to another one.

use std::collections::HashSet;

use super::mount::{Mount, WORLD};
use super::prefix::Renaming;
use crate::{Base, EditNote, JointDescription, JointKind, Medium, ModelError, Pose, RobotDescription};

impl RobotDescription {
    /// Attaches another robot to a link or frame, for example a gripper to an arm. Every name of the other
    /// robot gets the mount's prefix. See [`Scene::add`](crate::Scene::add), which does the same in a world.
    ///
    /// Returns the statements of the other robot that are not taken: other gravity, another step.
    ///
    /// ```
    /// use robot_dynamics::description::{Mount, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let notes = robot.attach(&pendulum(1.0, 0.2), &Mount::on("tip").with_prefix("second_"))?;
    /// assert!(notes.is_empty());
    /// assert_eq!(Model::new(robot)?.coordinate_names(), ["hinge", "second_hinge"]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`]: the parent is unknown, a name is taken, or the other robot does not have exactly one
    /// root. The robot is then unchanged.
    pub fn attach(&mut self, robot: &RobotDescription, mount: &Mount) -> Result<Vec<EditNote>, ModelError> {
        let (parent, parent_from_frame) = self.link_of(&mount.parent)?;
        let root = root_of(robot)?.to_owned();
        let kind = mount.joint.unwrap_or(match robot.base {
            Base::Fixed => JointKind::Fixed,
            Base::Floating => JointKind::Floating,
        });
        let pose = parent_from_frame.compose(&mount.parent_from_robot);
        let shares_world = root == WORLD
            && parent == WORLD
            && kind == JointKind::Fixed
            && mount.prefix.is_empty()
            && pose == Pose::IDENTITY
            && robot.links.iter().all(|link| link.name != root || link.mass_properties.is_none());
        let new_root = match (root.as_str(), mount.prefix.as_str()) {
            (WORLD, "") if shares_world => WORLD.to_owned(),
            (WORLD, "") => format!("{}_{WORLD}", robot.name),
            (root, prefix) => format!("{prefix}{root}"),
        };
        let mut part = robot.clone();
        let base_joint = robot.floating_base_name();
        Renaming { prefix: &mount.prefix, root: (&root, &new_root) }.apply(&mut part);
        let base_joint = format!("{}{base_joint}", mount.prefix);
        part.base = Base::Fixed;
        if shares_world {
            part.links.retain(|link| link.name != new_root);
        } else {
            let name = if kind == JointKind::Floating && robot.base == Base::Floating && mount.joint.is_none()
            {
                self.free_joint_name(&base_joint, &new_root)
            } else {
                format!("{new_root}_joint")
            };
            rename_base(&mut part, &base_joint, (kind == JointKind::Floating).then_some(name.as_str()));
            part.joints.insert(0, JointDescription::new(name, kind, parent, new_root, pose));
        }
        self.check_names(&part)?;
        let notes = self.differences(robot);
        self.merge(part, robot.actuated_joints.is_some());
        Ok(notes)
    }

    /// Replaces a joint and everything behind it by another robot, for example one gripper by another. The
    /// root link of the other robot is fixed to the joint's parent, at the joint's frame. Returns the notes
    /// of [`remove_joint`](Self::remove_joint) and of [`attach`](Self::attach).
    ///
    /// ```
    /// use robot_dynamics::description::{Mount, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.attach(&pendulum(1.0, 0.2), &Mount::on("tip").with_prefix("old_"))?;
    /// robot.replace_subtree("old_ceiling_joint", &pendulum(3.0, 0.1), "new_")?;
    /// let names: Vec<_> = robot.links.iter().map(|link| link.name.as_str()).collect();
    /// assert_eq!(names, ["ceiling", "rod", "new_ceiling", "new_rod"]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`]: the joint is unknown, a name is taken, or the other robot does not have exactly one
    /// root. The robot is then unchanged.
    pub fn replace_subtree(
        &mut self,
        joint: &str,
        robot: &RobotDescription,
        prefix: &str,
    ) -> Result<Vec<EditNote>, ModelError> {
        let JointDescription { parent, parent_from_joint, .. } = &self.joints[self.joint_index(joint)?];
        let mount = Mount::on(parent).with_pose(*parent_from_joint);
        let mount = mount.with_joint(JointKind::Fixed).with_prefix(prefix);
        let mut edited = self.clone();
        let mut notes = edited.remove_joint(joint)?;
        notes.extend(edited.attach(robot, &mount)?);
        *self = edited;
        Ok(notes)
    }

    /// The name of a floating base in the scene: its own, or one by the root link if that is taken.
    fn free_joint_name(&self, base_joint: &str, root: &str) -> String {
        let is_taken = self.joints.iter().any(|joint| joint.name == base_joint);
        if is_taken { format!("{root}_joint") } else { base_joint.to_owned() }
    }

    /// Rejects the names of a part that this robot has.
    fn check_names(&self, part: &RobotDescription) -> Result<(), ModelError> {
        for ((sort, own), (_, added)) in names(self).into_iter().zip(names(part)) {
            let added: HashSet<&str> = added.into_iter().filter(|name| !name.is_empty()).collect();
            if let Some(name) = own.into_iter().find(|name| added.contains(name)) {
                return Err(ModelError::NameInScene { sort, name: name.to_owned() });
            }
        }
        Ok(())
    }

    /// The statements of a robot about the world that differ from this robot's.
    fn differences(&self, robot: &RobotDescription) -> Vec<EditNote> {
        let mut notes = Vec::new();
        let mut differ = |quantity: &str, own: String, stated: String| {
            let message = format!("it states {quantity} {stated}; the scene keeps {own}");
            notes.push(EditNote::new(format!("robot `{}`", robot.name), message));
        };
        if robot.gravity != self.gravity {
            let [own, stated] = [self.gravity, robot.gravity].map(|gravity| format!("{gravity:?} m/s²"));
            differ("gravity", own, stated);
        }
        let (own, stated) = (self.medium, robot.medium);
        if own != stated && own != Medium::default() && stated != Medium::default() {
            let text = |medium: Medium| format!("{} kg/m³ and {} Pa·s", medium.density, medium.viscosity);
            differ("a fluid of", text(own), text(stated));
        }
        for (quantity, own, stated) in
            [("a time step of", self.time_step, robot.time_step), ("impratio", self.impratio, robot.impratio)]
        {
            if let (Some(own), Some(stated)) = (own, stated)
                && own != stated
            {
                differ(quantity, own.to_string(), stated.to_string());
            }
        }
        notes
    }

    fn merge(&mut self, part: RobotDescription, states_actuated: bool) {
        let own = self;
        // `None` means every joint except floating ones.
        if own.actuated_joints.is_some() || states_actuated {
            let motorized = |robot: &RobotDescription| {
                let moves = |joint: &&JointDescription| {
                    joint.kind.nv() > 0 && joint.kind != JointKind::Floating && joint.mimic.is_none()
                };
                let all = || robot.joints.iter().filter(moves).map(|joint| joint.name.clone()).collect();
                robot.actuated_joints.clone().unwrap_or_else(all)
            };
            own.actuated_joints = Some([motorized(own), motorized(&part)].concat());
        }
        let (own_controls, part_controls) = (own.actuators.len(), part.actuators.len());
        for pose in own.poses.iter_mut().filter(|pose| !pose.controls.is_empty()) {
            pose.controls.resize(own_controls + part_controls, 0.0);
        }
        let mut poses = part.poses;
        for pose in poses.iter_mut().filter(|pose| !pose.controls.is_empty()) {
            pose.controls.splice(0..0, core::iter::repeat_n(0.0, own_controls));
        }
        own.time_step = own.time_step.or(part.time_step);
        own.impratio = own.impratio.or(part.impratio);
        own.links.extend(part.links);
        own.joints.extend(part.joints);
        own.frames.extend(part.frames);
        own.shapes.extend(part.shapes);
        own.contact_exclusions.extend(part.contact_exclusions);
        own.contact_pairs.extend(part.contact_pairs);
        own.tendons.extend(part.tendons);
        own.fluid_shapes.extend(part.fluid_shapes);
        if own.medium == Medium::default() {
            own.medium = part.medium;
        }
        own.spatial_tendons.extend(part.spatial_tendons);
        own.equalities.extend(part.equalities);
        own.actuators.extend(part.actuators);
        own.sensors.extend(part.sensors);
        own.poses.extend(poses);
        own.groups.extend(part.groups);
        own.end_effectors.extend(part.end_effectors);
    }
}

/// The link that is not the child of a joint.
fn root_of(robot: &RobotDescription) -> Result<&str, ModelError> {
    let roots: Vec<&str> = robot.roots().map(|link| link.name.as_str()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] if robot.links.is_empty() => Err(ModelError::NoLinks),
        [] => Err(ModelError::Cycle { links: robot.links.iter().map(|link| link.name.clone()).collect() }),
        _ => Err(ModelError::SeveralRoots { links: roots.into_iter().map(str::to_owned).collect() }),
    }
}

/// Replaces the name of the floating base in poses and in the list of actuated joints, or removes it there.
fn rename_base(part: &mut RobotDescription, base_joint: &str, new: Option<&str>) {
    if part.joints.iter().any(|joint| joint.name == base_joint) {
        return;
    }
    for pose in &mut part.poses {
        for values in [&mut pose.positions, &mut pose.velocities] {
            match new {
                Some(new) => values
                    .iter_mut()
                    .filter(|(joint, _)| joint == base_joint)
                    .for_each(|(joint, _)| new.clone_into(joint)),
                None => values.retain(|(joint, _)| joint != base_joint),
            }
        }
    }
    if let Some(joints) = &mut part.actuated_joints {
        match new {
            Some(new) => {
                joints
                    .iter_mut()
                    .filter(|joint| *joint == base_joint)
                    .for_each(|joint| new.clone_into(joint));
            }
            None => joints.retain(|joint| joint != base_joint),
        }
    }
}

/// The names of each sort that a scene keeps apart.
fn names(robot: &RobotDescription) -> [(&'static str, Vec<&str>); 9] {
    fn of<T>(items: &[T], name: impl Fn(&T) -> &str) -> Vec<&str> {
        items.iter().map(name).collect()
    }
    let tendons =
        [of(&robot.tendons, |tendon| &tendon.name), of(&robot.spatial_tendons, |tendon| &tendon.name)];
    let places = [of(&robot.links, |link| &link.name), of(&robot.frames, |frame| &frame.name)];
    [
        ("link or frame", places.concat()),
        ("joint", of(&robot.joints, |joint| &joint.name)),
        ("tendon", tendons.concat()),
        ("equality", of(&robot.equalities, |equality| &equality.name)),
        ("actuator", of(&robot.actuators, |actuator| &actuator.name)),
        ("sensor", of(&robot.sensors, |sensor| &sensor.name)),
        ("pose", of(&robot.poses, |pose| &pose.name)),
        ("group", of(&robot.groups, |group| &group.name)),
        ("end effector", of(&robot.end_effectors, |tool| &tool.name)),
    ]
}

//! Writes `<worldbody>`: bodies with their inertia, joints, shapes and sites.

use std::collections::HashSet;

use nalgebra::{Rotation3, UnitQuaternion};
use robot_dynamics_description::{Base, JointKind, Pose, Quaternion};
use robot_dynamics_xml::excerpt;

use super::MjcfWriter;
use super::chain::WrittenBody;

/// The deepest nesting of bodies, below the limit of MuJoCo's parser.
const DEPTH_LIMIT: usize = 490;

enum Step {
    Begin(WrittenBody),
    End,
}

impl<'r> MjcfWriter<'r> {
    /// Assigns a site to each frame, and to each link that an actuator or a connection acts on.
    pub(super) fn plan_sites(&mut self) {
        let robot = self.robot;
        for frame in &robot.frames {
            let site = (frame.name.clone(), frame.link_from_frame);
            self.sites.entry(&frame.link).or_default().push(site);
        }
        for actuator in &robot.actuators {
            for frame in actuator.transmission.frames() {
                if self.link_index.contains_key(frame) {
                    self.plan_link_site(frame);
                }
            }
        }
        self.plan_sensor_sites();
        for (index, equality) in robot.equalities.iter().enumerate() {
            if let robot_dynamics_description::Equality::Connect { a, b } = &equality.kind {
                let names = [("1", a), ("2", b)].map(|(number, (link, point))| {
                    let name = self.site_names.unique(&format!("{}_site{number}", equality.name));
                    self.sites.entry(link).or_default().push((name.clone(), Pose::from_translation(*point)));
                    name
                });
                self.connections.insert(index, names);
            }
        }
    }

    /// Assigns a site at the frame of a link.
    pub(super) fn plan_link_site(&mut self, link: &'r str) {
        if !self.link_sites.contains_key(link) {
            let name = self.site_names.unique(&format!("{link}_site"));
            self.sites.entry(link).or_default().push((name.clone(), Pose::IDENTITY));
            self.link_sites.insert(link, name);
        }
    }

    pub(super) fn write_bodies(&mut self) {
        let (robot, named) = (self.robot, self.named_links());
        let has_mass = self.moves_mass();
        self.xml.start("worldbody");
        let mut pending = Vec::new();
        if self.root_is_world() {
            if robot.links[self.root].mass_properties.is_some() {
                self.add_note("link \"world\"", "its mass is omitted: the world has none in MJCF");
            }
            self.write_shapes_and_sites(self.root, true);
            self.push_children(self.root, true, &named, &mut pending);
        } else {
            let is_fixed_to_world = robot.base == Base::Fixed;
            pending.push(Step::Begin(WrittenBody {
                link: self.root,
                joints: Vec::new(),
                place: Pose::IDENTITY,
                is_fixed_to_world,
            }));
        }
        let mut depth = 0_usize;
        // Floating children of a fixed link are written as children of the world.
        let mut floating = Vec::new();
        loop {
            match pending.pop() {
                Some(Step::Begin(body)) => {
                    let floats =
                        matches!(body.joints[..], [joint] if robot.joints[joint].kind == JointKind::Floating);
                    if floats && depth > 0 {
                        floating.push(body);
                        continue;
                    }
                    depth += 1;
                    if depth == DEPTH_LIMIT {
                        let message =
                            format!("bodies are nested deeper than {DEPTH_LIMIT}, which MuJoCo refuses");
                        self.unwritable.push(message);
                    }
                    self.write_body(&body, &has_mass);
                    pending.push(Step::End);
                    self.push_children(body.link, body.is_fixed_to_world, &named, &mut pending);
                }
                Some(Step::End) => {
                    self.xml.end();
                    depth -= 1;
                }
                None => {
                    let Some(body) = floating.pop() else { break };
                    pending.push(Step::Begin(body));
                }
            }
        }
        self.xml.end();
    }

    /// Pushes the children of a link, the first one on top.
    fn push_children(
        &mut self,
        link: usize,
        is_fixed_to_world: bool,
        named: &HashSet<usize>,
        pending: &mut Vec<Step>,
    ) {
        for at in (0..self.below[link].len()).rev() {
            let joint = self.below[link][at];
            let own = &self.robot.joints[joint];
            let body = self.body_of(joint, is_fixed_to_world, named);
            if own.kind == JointKind::Floating {
                if !is_fixed_to_world || link != self.root {
                    let place = super::joint_place(&own.name);
                    self.unwritable.push(format!("{place}: in MJCF only children of the world can float"));
                } else if own.parent_from_joint != Pose::IDENTITY {
                    let message = "its position becomes relative to the frame of the world";
                    self.add_loss(&super::joint_place(&own.name), message);
                }
            }
            pending.push(Step::Begin(body));
        }
    }

    fn write_body(&mut self, body: &WrittenBody, has_mass: &[bool]) {
        let link = &self.robot.links[body.link];
        self.xml.start("body").attribute("name", &self.body_names[body.link]);
        self.write_placement(&body.place);
        self.xml.unless("gravcomp", link.gravity_compensation, 0.0);
        if let Some(own) = &link.mass_properties {
            let (center, i) = (own.center_of_mass(), own.inertia_about_center_of_mass());
            self.xml.start("inertial").numbers("pos", center.as_slice()).numbers("mass", &[own.mass()]);
            let moments = [i[(0, 0)], i[(1, 1)], i[(2, 2)]];
            let products = [i[(0, 1)], i[(0, 2)], i[(1, 2)]];
            let axes = self.box_axes(&link.name, own).filter(|axes| *axes != Rotation3::identity());
            if let Some(axes) = axes {
                // The axes of a box in a fluid are those of the inertia as written.
                let quaternion = UnitQuaternion::from_rotation_matrix(&axes);
                let turn = quaternion.to_rotation_matrix();
                let moments = (turn.transpose() * i * turn).diagonal();
                self.xml.numbers("quat", &[quaternion.w, quaternion.i, quaternion.j, quaternion.k]);
                self.xml.numbers("diaginertia", moments.as_slice());
            } else if products == [0.0; 3] {
                self.xml.numbers("diaginertia", &moments);
            } else {
                self.xml.numbers("fullinertia", &[moments, products].concat());
            }
            self.xml.end();
        }
        self.write_joints(body);
        let floats = body.link == self.root && self.robot.base == Base::Floating;
        let moves = floats || body.joints.iter().any(|&joint| self.robot.joints[joint].kind.nv() > 0);
        if moves && !has_mass[body.link] {
            let message = "it moves without mass, which MuJoCo refuses";
            self.add_note(&format!("link {:?}", excerpt(&link.name)), message);
        }
        self.write_shapes_and_sites(body.link, body.is_fixed_to_world);
    }

    /// Writes `pos` and `quat`, each unless it is the identity.
    pub(super) fn write_placement(&mut self, pose: &Pose) {
        if pose.translation != [0.0; 3] {
            self.xml.numbers("pos", &pose.translation);
        }
        if pose.rotation != Pose::IDENTITY.rotation {
            self.xml.numbers("quat", &Quaternion::from_rotation(&pose.rotation).to_wxyz());
        }
    }

    fn write_shapes_and_sites(&mut self, link: usize, is_fixed_to_world: bool) {
        let name = self.robot.links[link].name.as_str();
        for (shape, asset) in self.shapes.remove(name).unwrap_or_default() {
            self.write_shape(shape, asset.as_deref(), is_fixed_to_world);
        }
        self.write_ellipsoids(name);
        self.write_tendon_geoms(name);
        for (name, place) in self.sites.remove(name).unwrap_or_default() {
            self.xml.start("site").attribute("name", &name);
            self.write_site_shape(&name);
            self.write_placement(&place);
            self.xml.end();
        }
    }

    /// Whether each link, or a link fixed to it, has mass.
    fn moves_mass(&self) -> Vec<bool> {
        let robot = self.robot;
        let mut has_mass: Vec<bool> = robot.links.iter().map(|link| link.mass_properties.is_some()).collect();
        // Parents before children, so that the reverse order propagates masses to the parents.
        let (mut order, mut at) = (vec![self.root], 0);
        while at < order.len() {
            let children = self.below[order[at]].iter();
            order.extend(children.map(|&joint| self.link_index[robot.joints[joint].child.as_str()]));
            at += 1;
        }
        for &link in order.iter().rev() {
            for &joint in &self.below[link] {
                let joint = &robot.joints[joint];
                let child = self.link_index[joint.child.as_str()];
                has_mass[link] |= joint.kind == JointKind::Fixed && has_mass[child];
            }
        }
        has_mass
    }
}

//! `<worldbody>`: bodies with their inertia, joints, shapes and sites.

use std::collections::HashSet;

use multibody::{Base, JointKind, Pose, Quaternion, Transmission};
use robot_xml::excerpt;

use super::Writing;
use super::chain::Body;

/// Deepest nesting of bodies, for readers that refuse more (MuJoCo among them).
const DEEPEST: usize = 490;

enum Step {
    Begin(Body),
    End,
}

impl<'r> Writing<'r> {
    /// Gives each frame its site, and each link that an actuator or a connection acts on one of its own.
    pub(super) fn plan_sites(&mut self) {
        let robot = self.robot;
        for frame in &robot.frames {
            let site = (frame.name.clone(), frame.link_from_frame);
            self.sites.entry(&frame.link).or_default().push(site);
        }
        for actuator in &robot.actuators {
            if let Transmission::Frame { frame, .. } = &actuator.transmission
                && self.link_index.contains_key(frame.as_str())
            {
                self.plan_link_site(frame);
            }
        }
        self.plan_sensor_sites();
        for (index, equality) in robot.equalities.iter().enumerate() {
            if let multibody::Equality::Connect { a, b } = &equality.kind {
                let names = [("1", a), ("2", b)].map(|(number, (link, point))| {
                    let name = self.site_names.free(&format!("{}_site{number}", equality.name));
                    self.sites.entry(link).or_default().push((name.clone(), Pose::from_translation(*point)));
                    name
                });
                self.connections.insert(index, names);
            }
        }
    }

    /// A site where the link's own frame is.
    pub(super) fn plan_link_site(&mut self, link: &'r str) {
        if !self.link_sites.contains_key(link) {
            let name = self.site_names.free(&format!("{link}_site"));
            self.sites.entry(link).or_default().push((name.clone(), Pose::IDENTITY));
            self.link_sites.insert(link, name);
        }
    }

    pub(super) fn bodies(&mut self) {
        let (robot, named) = (self.robot, self.named_links());
        let has_mass = self.moves_mass();
        self.xml.start("worldbody");
        let mut pending = Vec::new();
        if self.root_is_world() {
            if robot.links[self.root].mass_properties.is_some() {
                self.note("link \"world\"", "its mass, which moves nothing: the format's world has none");
            }
            self.shapes_and_sites(self.root, true);
            self.push_children(self.root, true, &named, &mut pending);
        } else {
            let stands = robot.base == Base::Fixed;
            pending.push(Step::Begin(Body {
                link: self.root,
                joints: Vec::new(),
                place: Pose::IDENTITY,
                stands,
            }));
        }
        let mut depth = 0_usize;
        // Floating links under a link that stands are bodies of the world.
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
                    if depth == DEEPEST {
                        let message =
                            format!("bodies are nested deeper than {DEEPEST}, which MuJoCo refuses");
                        self.unwritable.push(message);
                    }
                    self.body(&body, &has_mass);
                    pending.push(Step::End);
                    self.push_children(body.link, body.stands, &named, &mut pending);
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

    /// The bodies below a link, the first on top.
    fn push_children(&mut self, link: usize, stands: bool, named: &HashSet<usize>, pending: &mut Vec<Step>) {
        for at in (0..self.below[link].len()).rev() {
            let joint = self.below[link][at];
            let own = &self.robot.joints[joint];
            let body = self.body_of(joint, stands, named);
            if own.kind == JointKind::Floating {
                if !stands || link != self.root {
                    let place = super::joint_place(&own.name);
                    self.unwritable.push(format!("{place}: in the format only bodies of the world float"));
                } else if own.parent_from_joint != Pose::IDENTITY {
                    let message = "its position counts from the world's frame, and no longer from its own";
                    self.lost(&super::joint_place(&own.name), message);
                }
            }
            pending.push(Step::Begin(body));
        }
    }

    fn body(&mut self, body: &Body, has_mass: &[bool]) {
        let link = &self.robot.links[body.link];
        self.xml.start("body").attribute("name", &self.body_names[body.link]);
        self.placement(&body.place);
        self.xml.unless("gravcomp", link.gravity_compensation, 0.0);
        if let Some(own) = &link.mass_properties {
            let (center, i) = (own.center_of_mass(), own.inertia_about_center_of_mass());
            self.xml.start("inertial").numbers("pos", center.as_slice()).numbers("mass", &[own.mass()]);
            let moments = [i[(0, 0)], i[(1, 1)], i[(2, 2)]];
            let products = [i[(0, 1)], i[(0, 2)], i[(1, 2)]];
            if products == [0.0; 3] {
                self.xml.numbers("diaginertia", &moments);
            } else {
                self.xml.numbers("fullinertia", &[moments, products].concat());
            }
            self.xml.end();
        }
        self.joints(body);
        let floats = body.link == self.root && self.robot.base == Base::Floating;
        let moves = floats || body.joints.iter().any(|&joint| self.robot.joints[joint].kind.nv() > 0);
        if moves && !has_mass[body.link] {
            let message = "it moves without mass, which MuJoCo refuses";
            self.note(&format!("link {:?}", excerpt(&link.name)), message);
        }
        self.shapes_and_sites(body.link, body.stands);
    }

    /// `pos` and `quat`, each where it says something.
    pub(super) fn placement(&mut self, pose: &Pose) {
        if pose.translation != [0.0; 3] {
            self.xml.numbers("pos", &pose.translation);
        }
        if pose.rotation != Pose::IDENTITY.rotation {
            self.xml.numbers("quat", &Quaternion::from_rotation(&pose.rotation).to_wxyz());
        }
    }

    fn shapes_and_sites(&mut self, link: usize, stands: bool) {
        let name = self.robot.links[link].name.as_str();
        for (shape, asset) in self.shapes.remove(name).unwrap_or_default() {
            self.shape(shape, asset.as_deref(), stands);
        }
        for (name, place) in self.sites.remove(name).unwrap_or_default() {
            self.xml.start("site").attribute("name", &name);
            self.site_form(&name);
            self.placement(&place);
            self.xml.end();
        }
    }

    /// Which links have mass, or carry a link with mass that is fixed to them.
    fn moves_mass(&self) -> Vec<bool> {
        let robot = self.robot;
        let mut has_mass: Vec<bool> = robot.links.iter().map(|link| link.mass_properties.is_some()).collect();
        // Parents before children, so that the way back passes it on.
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

//! Reads `<equality>`: couplings of joints and of tendons, connected points, welded bodies.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot_dynamics_description::{Equality, EqualityDescription, Pose, RobotDescription};

use crate::assembly::{ElementTable, JointEntry};
use crate::body::Body;
use crate::classes::MAIN;
use crate::element::Element;
use crate::joint::JointType;
use crate::names::Names;
use crate::orientation::pose;
use crate::reader::Reader;
use crate::tree::Id;

impl Reader<'_> {
    /// Reads all equalities, in the order of the file.
    pub(crate) fn equalities(&mut self, bodies: &[Body], table: &ElementTable, robot: &mut RobotDescription) {
        let mut names = Names::default();
        // The pose of each body in the file.
        let mut world_from_body: Vec<Isometry3<f64>> = Vec::with_capacity(bodies.len());
        for body in bodies {
            let parent = world_from_body.get(body.parent).copied().unwrap_or_else(Isometry3::identity);
            world_from_body.push(parent * body.parent_from_body);
        }
        let all: Vec<Id> = self.tree.in_sections("equality").collect();
        for (index, id) in all.into_iter().enumerate() {
            let sort = self.tree.nodes[id].name.as_str();
            if !["joint", "tendon", "connect", "weld"].contains(&sort) {
                continue;
            }
            let mut element = self.element(id, MAIN);
            let class = self.text(&self.raw_element(id), "class").and_then(|name| self.classes.find(name));
            element.defaults = self.classes.of_kind(class.unwrap_or(MAIN), "equality");
            let kind = match sort {
                "joint" => self.joint_coupling(&element, table),
                "tendon" => self.tendon_coupling(&element, table, robot),
                "connect" => self.connect_constraint(&element, bodies, table, &world_from_body),
                _ => self.weld_constraint(&element, bodies, table, &world_from_body),
            };
            let Some(kind) = kind else { continue };
            let name = match self.tree.nodes[id].attribute("name") {
                Some(name) if !name.is_empty() => names.unique(name),
                _ => names.unique(&format!("equality_{index}")),
            };
            let mut equality = EqualityDescription::new(name, kind);
            equality.active = self.boolean(&element, "active").unwrap_or(true);
            equality.solref = self.overlay(&element, "solref", equality.solref);
            equality.solimp = self.overlay(&element, "solimp", equality.solimp);
            self.report_read(&element, "an equality constraint");
            robot.equalities.push(equality);
        }
    }

    fn joint_coupling(&mut self, element: &Element, table: &ElementTable) -> Option<Equality> {
        let name = self.required_text(element, "joint1", "JOINT")?;
        let joint = self.single_joint(element, name, table)?;
        let leader = match self.text(element, "joint2") {
            Some(name) => Some(self.single_joint(element, name, table)?),
            None => None,
        };
        let polynomial = self.overlay(element, "polycoef", [0.0, 1.0, 0.0, 0.0, 0.0]);
        Some(Equality::Joints { joint, leader, polynomial })
    }

    fn tendon_coupling(
        &mut self,
        element: &Element,
        table: &ElementTable,
        robot: &RobotDescription,
    ) -> Option<Equality> {
        let name = self.required_text(element, "tendon1", "TENDON")?;
        let tendon = self.tendon_length(element, name, table, robot)?;
        let leader = match self.text(element, "tendon2") {
            Some(name) => Some(self.tendon_length(element, name, table, robot)?),
            None => None,
        };
        let polynomial = self.overlay(element, "polycoef", [0.0, 1.0, 0.0, 0.0, 0.0]);
        Some(Equality::Tendons { tendon, leader, polynomial })
    }

    /// A tendon, and its length in the pose of the file if it is a tendon over joints. That of a spatial
    /// tendon is found when the robot is complete.
    fn tendon_length(
        &mut self,
        element: &Element,
        name: &str,
        table: &ElementTable,
        robot: &RobotDescription,
    ) -> Option<(String, f64)> {
        if let Some(tendon) = robot.tendons.iter().find(|own| own.name == name) {
            let initial =
                |joint: &str| table.joints.iter().find(|own| own.name == joint).map(|own| own.initial[0]);
            let length = tendon.terms.iter().filter_map(|(joint, c)| Some(c * initial(joint)?)).sum();
            return Some((tendon.name.clone(), length));
        }
        let found = robot.spatial_tendons.iter().find(|own| own.name == name);
        if found.is_none() {
            self.refuse_unknown_name(element, "tendon", name);
        }
        found.map(|tendon| (tendon.name.clone(), 0.0))
    }

    /// A joint with one degree of freedom, and its q in the pose of the file.
    fn single_joint(&mut self, element: &Element, name: &str, table: &ElementTable) -> Option<(String, f64)> {
        let joint = self.joint_named(element, name, table)?;
        if !matches!(joint.motion, JointType::Hinge | JointType::Slide) {
            self.refuse(
                element,
                format!("joint {name:?} is a {} joint; use a hinge or slide joint", joint.motion.word()),
            );
            return None;
        }
        Some((joint.name.clone(), joint.initial[0]))
    }

    /// The joint of this name, which must exist.
    pub(crate) fn joint_named<'p>(
        &mut self,
        element: &Element,
        name: &str,
        table: &'p ElementTable,
    ) -> Option<&'p JointEntry> {
        let found = table.joint(name);
        if found.is_none() {
            self.refuse_unknown_name(element, "joint", name);
        }
        found
    }

    fn connect_constraint(
        &mut self,
        element: &Element,
        bodies: &[Body],
        table: &ElementTable,
        world_from_body: &[Isometry3<f64>],
    ) -> Option<Equality> {
        if self.text(element, "site1").is_some() {
            let [a, b] = self.two_sites(element, table)?;
            let point = |(link, place): (String, Isometry3<f64>)| (link, place.translation.vector.into());
            return Some(Equality::Connect { a: point(a), b: point(b) });
        }
        let [a, b] = self.two_bodies(element, bodies)?;
        self.required_text(element, "anchor", "X Y Z");
        let anchor = self.numbers::<3>(element, "anchor")?;
        // The coordinates of the same point in the other body, in the pose of the file.
        let other = world_from_body[b].inverse_transform_point(&(world_from_body[a] * Point3::from(anchor)));
        let link = |body: usize| table.links[body].clone();
        Some(Equality::Connect { a: (link(a), anchor), b: (link(b), other.coords.into()) })
    }

    fn weld_constraint(
        &mut self,
        element: &Element,
        bodies: &[Body],
        table: &ElementTable,
        world_from_body: &[Isometry3<f64>],
    ) -> Option<Equality> {
        if self.text(element, "site1").is_some() {
            let [(a, a_from_site), (b, b_from_site)] = self.two_sites(element, table)?;
            let anchor = b_from_site.translation.vector.into();
            let ends = (a, b, pose(&(a_from_site * b_from_site.inverse())));
            return Some(self.weld_at(element, ends, anchor));
        }
        let [a, b] = self.two_bodies(element, bodies)?;
        let anchor = self.numbers::<3>(element, "anchor").unwrap_or_default();
        let written = self.numbers::<7>(element, "relpose").and_then(|[x, y, z, qw, qx, qy, qz]| {
            // A quaternion of zeros stands for the pose of the file.
            let turn = UnitQuaternion::try_new(Quaternion::new(qw, qx, qy, qz), 0.0)?;
            // The position is that of the anchor.
            let origin = Translation3::from(Vector3::new(x, y, z) - turn * Vector3::from(anchor));
            Some(Isometry3::from_parts(origin, turn))
        });
        let a_from_b = written.unwrap_or_else(|| world_from_body[a].inverse() * world_from_body[b]);
        let link = |body: usize| table.links[body].clone();
        Some(self.weld_at(element, (link(a), link(b), pose(&a_from_b)), anchor))
    }

    /// A weld of two links, given the pose of the second one in the first one. With a torque scale of 0 it is
    /// a connection of the two points.
    fn weld_at(
        &mut self,
        element: &Element,
        (a, b, a_from_b): (String, String, Pose),
        anchor: [f64; 3],
    ) -> Equality {
        let torque_scale = self.number(element, "torquescale").map_or(1.0, f64::abs);
        if torque_scale == 0.0 {
            return Equality::Connect { a: (a, a_from_b.apply(anchor)), b: (b, anchor) };
        }
        Equality::Weld { a, b, a_from_b, anchor, torque_scale }
    }

    /// `body1` and `body2`, whose default is the world.
    fn two_bodies(&mut self, element: &Element, bodies: &[Body]) -> Option<[usize; 2]> {
        let first = self.body_named(element, "body1", bodies)?;
        let second = match self.text(element, "body2") {
            Some(_) => self.body_named(element, "body2", bodies)?,
            None => 0,
        };
        Some([first, second])
    }

    /// `site1` and `site2`: the link of each, and the pose of the site in the link.
    fn two_sites(
        &mut self,
        element: &Element,
        table: &ElementTable,
    ) -> Option<[(String, Isometry3<f64>); 2]> {
        let mut site = |attribute| {
            let name = self.required_text(element, attribute, "SITE")?;
            let found = table.site(name);
            if found.is_none() {
                self.refuse_unknown_name(element, "site", name);
            }
            found.map(|site| (table.links[site.body].clone(), site.body_from_site))
        };
        let (first, second) = (site("site1"), site("site2"));
        Some([first?, second?])
    }
}

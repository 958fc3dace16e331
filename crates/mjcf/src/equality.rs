//! `<equality>`: joints that follow each other, points that stay together, bodies welded to each other.

use multibody::{Equality, EqualityDescription, RobotDescription};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

use crate::assemble::{Placed, Places};
use crate::body::Body;
use crate::classes::MAIN;
use crate::joint::Motion;
use crate::names::Names;
use crate::orientation::pose;
use crate::reader::{Element, Reader};
use crate::tree::Id;

impl Reader<'_> {
    /// All equalities that are read, in the file's order.
    pub(crate) fn equalities(&mut self, bodies: &[Body], places: &Places, robot: &mut RobotDescription) {
        let mut names = Names::default();
        // Where each body is in the file's own pose.
        let mut world_from_body: Vec<Isometry3<f64>> = Vec::with_capacity(bodies.len());
        for body in bodies {
            let parent = world_from_body.get(body.parent).copied().unwrap_or_else(Isometry3::identity);
            world_from_body.push(parent * body.parent_from_body);
        }
        let all: Vec<Id> = self.tree.in_sections("equality").collect();
        for (index, id) in all.into_iter().enumerate() {
            let sort = self.tree.nodes[id].name.as_str();
            if !["joint", "connect", "weld"].contains(&sort) {
                continue;
            }
            let mut element = self.element(id, MAIN);
            let class = self.text(&self.plain(id), "class").and_then(|name| self.classes.named(name));
            element.defaults = self.classes.of_sort(class.unwrap_or(MAIN), "equality");
            let kind = match sort {
                "joint" => self.coupled_joints(&element, places),
                "connect" => self.connected(&element, bodies, places, &world_from_body),
                _ => self.welded(&element, bodies, places, &world_from_body),
            };
            let Some(kind) = kind else { continue };
            let name = match self.tree.nodes[id].attribute("name") {
                Some(name) if !name.is_empty() => names.free(name),
                _ => names.free(&format!("equality_{index}")),
            };
            let mut equality = EqualityDescription::new(name, kind);
            equality.active = self.truth(&element, "active").unwrap_or(true);
            equality.solref = self.overlay(&element, "solref", equality.solref);
            equality.solimp = self.overlay(&element, "solimp", equality.solimp);
            self.read(&element, "a constraint beside the tree");
            robot.equalities.push(equality);
        }
    }

    fn coupled_joints(&mut self, element: &Element, places: &Places) -> Option<Equality> {
        let name = self.required_text(element, "joint1", "JOINT")?;
        let joint = self.single_joint(element, name, places)?;
        let leader = match self.text(element, "joint2") {
            Some(name) => Some(self.single_joint(element, name, places)?),
            None => None,
        };
        let polynomial = self.overlay(element, "polycoef", [0.0, 1.0, 0.0, 0.0, 0.0]);
        Some(Equality::Joints { joint, leader, polynomial })
    }

    /// A joint of one freedom, and its q in the file's own pose.
    fn single_joint(&mut self, element: &Element, name: &str, places: &Places) -> Option<(String, f64)> {
        let joint = self.joint_named(element, name, places)?;
        if !matches!(joint.motion, Motion::Hinge | Motion::Slide) {
            self.misplaced(
                element,
                format!(
                    "joint {name:?} is a {} joint; only hinges and slides have one number",
                    joint.motion.word()
                ),
            );
            return None;
        }
        Some((joint.name.clone(), joint.initial[0]))
    }

    /// The joint of this name, which must be there.
    pub(crate) fn joint_named<'p>(
        &mut self,
        element: &Element,
        name: &str,
        places: &'p Places,
    ) -> Option<&'p Placed> {
        let found = places.joint(name);
        if found.is_none() {
            self.unknown_name(element, "joint", name);
        }
        found
    }

    fn connected(
        &mut self,
        element: &Element,
        bodies: &[Body],
        places: &Places,
        world_from_body: &[Isometry3<f64>],
    ) -> Option<Equality> {
        if self.text(element, "site1").is_some() {
            let [a, b] = self.two_sites(element, places)?;
            let point = |(link, place): (String, Isometry3<f64>)| (link, place.translation.vector.into());
            return Some(Equality::Connect { a: point(a), b: point(b) });
        }
        let [a, b] = self.two_bodies(element, bodies)?;
        self.required_text(element, "anchor", "X Y Z");
        let anchor = self.numbers::<3>(element, "anchor")?;
        // The same point of the other body, where the file places both.
        let other = world_from_body[b].inverse_transform_point(&(world_from_body[a] * Point3::from(anchor)));
        let link = |body: usize| places.links[body].clone();
        Some(Equality::Connect { a: (link(a), anchor), b: (link(b), other.coords.into()) })
    }

    fn welded(
        &mut self,
        element: &Element,
        bodies: &[Body],
        places: &Places,
        world_from_body: &[Isometry3<f64>],
    ) -> Option<Equality> {
        if self.text(element, "site1").is_some() {
            let [(a, a_from_site), (b, b_from_site)] = self.two_sites(element, places)?;
            return Some(Equality::Weld { a, b, a_from_b: pose(&(a_from_site * b_from_site.inverse())) });
        }
        let [a, b] = self.two_bodies(element, bodies)?;
        let written = self.numbers::<7>(element, "relpose").and_then(|[x, y, z, qw, qx, qy, qz]| {
            // A quaternion of zeros asks for the file's own pose.
            let turn = UnitQuaternion::try_new(Quaternion::new(qw, qx, qy, qz), 0.0)?;
            Some(Isometry3::from_parts(Translation3::new(x, y, z), turn))
        });
        let a_from_b = written.unwrap_or_else(|| world_from_body[a].inverse() * world_from_body[b]);
        let link = |body: usize| places.links[body].clone();
        Some(Equality::Weld { a: link(a), b: link(b), a_from_b: pose(&a_from_b) })
    }

    /// `body1` and `body2`, which is the world where it is left out.
    fn two_bodies(&mut self, element: &Element, bodies: &[Body]) -> Option<[usize; 2]> {
        let first = self.body_named(element, "body1", bodies)?;
        let second = match self.text(element, "body2") {
            Some(_) => self.body_named(element, "body2", bodies)?,
            None => 0,
        };
        Some([first, second])
    }

    /// `site1` and `site2`: the link of each, and the site in it.
    fn two_sites(&mut self, element: &Element, places: &Places) -> Option<[(String, Isometry3<f64>); 2]> {
        let mut site = |attribute| {
            let name = self.required_text(element, attribute, "SITE")?;
            let found = places.site(name);
            if found.is_none() {
                self.unknown_name(element, "site", name);
            }
            found.map(|site| (places.links[site.body].clone(), site.body_from_site))
        };
        let (first, second) = (site("site1"), site("site2"));
        Some([first?, second?])
    }
}

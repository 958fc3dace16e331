//! The walk through `<worldbody>`: bodies with what is in them, frames and replicates resolved.

use std::rc::Rc;

use multibody::Treatment;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::MjcfError;
use crate::body::{Body, Site};
use crate::classes::{Class, MAIN};
use crate::joint::Motion;
use crate::reader::{Element, Reader};
use crate::tree::{Id, Tree};

/// The most elements that replicates may make of a file.
const MOST: usize = 2_000_000;

/// What stands around an element.
#[derive(Clone)]
struct Around {
    /// Index of the body that it belongs to.
    body: usize,
    /// Of the `<frame>` elements around it, in the body's frame.
    frame: Isometry3<f64>,
    class: Class,
    /// What the replicates around it add to names.
    suffix: Rc<str>,
}

impl Reader<'_> {
    /// All bodies, the world first, each after the one it is in.
    pub(crate) fn bodies(&mut self) -> Vec<Body> {
        let sections: Vec<Id> = self.tree.children(Tree::ROOT, "worldbody").collect();
        self.walk(&sections, MAIN)
    }

    /// The joints of a frame that may be nowhere in the tree, each with its element; nothing is told of them.
    pub(crate) fn joints_in(&mut self, frame: Id) -> Vec<(Id, Motion)> {
        let told = (self.errors.len(), self.refused_warnings.len(), self.angles.len(), self.copied);
        let report = self.report.clone();
        let node = &self.tree.nodes[frame];
        let class = node.attribute("childclass").and_then(|name| self.classes.named(name));
        let bodies = self.walk(&[frame], class.unwrap_or(MAIN));
        self.errors.truncate(told.0);
        self.refused_warnings.truncate(told.1);
        self.angles.truncate(told.2);
        (self.copied, self.report) = (told.3, report);
        let joints = bodies.iter().flat_map(|body| &body.joints);
        joints.map(|joint| (joint.element.node, joint.motion)).collect()
    }

    /// What is in these elements, the world first.
    fn walk(&mut self, sections: &[Id], class: Class) -> Vec<Body> {
        let world = self.plain(Tree::ROOT);
        let mut bodies = vec![Body::new("world".into(), world, 0, Isometry3::identity())];
        let around = Around { body: 0, frame: Isometry3::identity(), class, suffix: Rc::from("") };
        let around = Rc::new(around);
        // Reversed on a stack they come out in order, whatever is nested before what follows.
        let mut pending: Vec<(Id, Rc<Around>)> = Vec::new();
        for &section in sections.iter().rev() {
            self.push_children(section, &around, &mut pending);
        }
        while let Some((node, around)) = pending.pop() {
            self.element_of_body(node, &around, &mut bodies, &mut pending);
        }
        bodies
    }

    fn push_children(&self, node: Id, around: &Rc<Around>, pending: &mut Vec<(Id, Rc<Around>)>) {
        pending.extend(self.tree.nodes[node].children.iter().rev().map(|&child| (child, Rc::clone(around))));
    }

    fn element_of_body(
        &mut self,
        node: Id,
        around: &Rc<Around>,
        bodies: &mut Vec<Body>,
        pending: &mut Vec<(Id, Rc<Around>)>,
    ) {
        let tree = self.tree;
        let own_name = tree.nodes[node].attribute("name").unwrap_or_default();
        let name = if own_name.is_empty() { String::new() } else { format!("{own_name}{}", around.suffix) };
        let is_world = around.body == 0;
        match tree.nodes[node].name.as_str() {
            "body" => {
                let element = self.plain(node);
                let class = self.child_class(&element, around.class);
                let parent_from_body = around.frame * self.placement(&element);
                let mut body = Body::new(name, element.clone(), around.body, parent_from_body);
                body.gravity_compensation = self.number(&element, "gravcomp").unwrap_or(0.0);
                body.mocap = self.truth(&element, "mocap").unwrap_or(false);
                let inside = Around {
                    body: bodies.len(),
                    frame: Isometry3::identity(),
                    class,
                    suffix: Rc::clone(&around.suffix),
                };
                bodies.push(body);
                self.push_children(node, &Rc::new(inside), pending);
            }
            "frame" => {
                let element = self.plain(node);
                let class = self.child_class(&element, around.class);
                let frame = around.frame * self.placement(&element);
                let inside = Around { frame, class, ..Around::clone(around) };
                self.push_children(node, &Rc::new(inside), pending);
            }
            "replicate" => self.replicate(node, around, pending),
            "inertial" if is_world => {
                let element = self.plain(node);
                self.misplaced(&element, "the world has no inertia; put it into a body");
            }
            "inertial" => {
                let element = self.plain(node);
                let place = format!("{}/inertial", bodies[around.body].element.place);
                let element = Element { place, ..element };
                if let Some(first) = &bodies[around.body].inertial {
                    let message = format!(
                        "a second <inertial>; the first, on line {}, counts; delete one of them",
                        first.element.line
                    );
                    self.as_written(&element, message);
                } else {
                    bodies[around.body].inertial = Some(Box::new(self.inertial(element)));
                }
            }
            "joint" | "freejoint" if is_world => {
                let element = self.plain(node);
                self.misplaced(&element, "the world has no joints; put it into a body");
            }
            "joint" => {
                let element = self.element(node, around.class);
                let joint = self.joint(&element, name, &around.frame);
                push(&mut bodies[around.body].joints, joint);
            }
            "freejoint" => {
                let element = self.plain(node);
                let joint = self.free_joint(&element, name);
                push(&mut bodies[around.body].joints, joint);
            }
            "geom" => {
                let element = self.element(node, around.class);
                let geom = self.geom(element, name, &around.frame);
                push(&mut bodies[around.body].geoms, geom);
            }
            "site" => {
                let element = self.element(node, around.class);
                let placement = match self.numbers::<6>(&element, "fromto") {
                    Some([a, b, c, d, e, f]) => {
                        // Its frame is in the middle, z along it.
                        let (from, to) = ([a, b, c].into(), [d, e, f].into());
                        segment(from, to)
                    }
                    None => self.placement(&element),
                };
                if !name.is_empty() {
                    let body_from_site = around.frame * placement;
                    push(&mut bodies[around.body].sites, Site { name, element, body_from_site });
                }
            }
            // Told by the account of what is not read.
            _ => {}
        }
    }

    /// `childclass`, or else the class around.
    fn child_class(&mut self, element: &Element, around: Class) -> Class {
        match self.tree.nodes[element.node].attribute("childclass") {
            Some(name) => self.class_named(name, element).unwrap_or(around),
            None => around,
        }
    }

    /// Whether `<replicate>`s made more than is read of them.
    pub(crate) fn has_too_many_copies(&self) -> bool {
        self.copied > MOST
    }

    /// How many elements a copy of a `<replicate>` has, itself and those at any depth; a replicate in it counts its own copies where it is met.
    fn elements_of_copy(&self, node: Id) -> usize {
        let (mut count, mut pending) = (1, self.tree.nodes[node].children.clone());
        while let Some(id) = pending.pop() {
            count += 1;
            if self.tree.nodes[id].name != "replicate" {
                pending.extend(&self.tree.nodes[id].children);
            }
        }
        count
    }

    /// `<replicate>`: `count` copies, each shifted by `offset` and turned by `euler` from the one before, their number
    /// behind their names.
    fn replicate(&mut self, node: Id, around: &Rc<Around>, pending: &mut Vec<(Id, Rc<Around>)>) {
        let element = self.plain(node);
        let class = self.child_class(&element, around.class);
        let count = self.required_number(&element, "count");
        if !(0.0..=1e6).contains(&count) || count.fract() != 0.0 {
            if !count.is_nan() {
                self.misplaced(&element, format!("count={count} is not a number of copies"));
            }
            return;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked just now
        let count = count as usize;
        self.copied = self.copied.saturating_add(count.saturating_mul(self.elements_of_copy(node)));
        if self.has_too_many_copies() {
            let (line, place) = (element.line, element.place);
            self.errors.push(MjcfError::TooMany { line, place, what: "elements in bodies", limit: MOST });
            pending.clear();
            return;
        }
        let offset = self.numbers::<3>(&element, "offset").unwrap_or_default();
        let euler = self.numbers::<3>(&element, "euler").unwrap_or_default();
        let separator = self.text(&element, "sep").unwrap_or_default();
        let digits = count.to_string().len();
        let compiler = self.compiler(&element);
        let turn = |times: f64| self.euler(&element, euler.map(|angle| times * compiler.angle(angle)));
        let step = Isometry3::from_parts(Translation3::from(offset), turn(1.0));
        let mut place = Isometry3::identity();
        let mut copies = Vec::new();
        for copy in 0..count {
            // The turn afresh for each copy, so that no rounding adds up.
            let here = Isometry3::from_parts(place.translation, turn(copy as f64));
            let suffix = format!("{separator}{copy:0digits$}{}", around.suffix);
            copies.push(Rc::new(Around {
                frame: around.frame * here,
                class,
                suffix: Rc::from(suffix),
                ..Around::clone(around)
            }));
            place *= step;
        }
        for copy in copies.iter().rev() {
            self.push_children(node, copy, pending);
        }
        self.push(element.line, element.place, Treatment::Read, format!("{count} copies"));
    }
}

/// Adds to what a body has. Most have one of a kind, for which a vector would take memory of four.
fn push<T>(list: &mut Vec<T>, item: T) {
    if list.is_empty() {
        list.reserve_exact(1);
    }
    list.push(item);
}

/// In the middle between two points, z from the second to the first.
fn segment(from: nalgebra::Vector3<f64>, to: nalgebra::Vector3<f64>) -> Isometry3<f64> {
    let along = from - to;
    let length = along.norm();
    let turn =
        if length > 0.0 { crate::orientation::from_z_to(along / length) } else { UnitQuaternion::identity() };
    Isometry3::from_parts(Translation3::from((from + to) * 0.5), turn)
}

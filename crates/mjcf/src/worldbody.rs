//! Reads `<worldbody>`: bodies with their content, with frames and replicates resolved.

use std::rc::Rc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use robot_dynamics_description::Disposition;
use robot_dynamics_xml::Resource;

use crate::body::{Body, Site};
use crate::classes::{Class, MAIN};
use crate::element::Element;
use crate::frame_scale::FrameScale;
use crate::joint::JointType;
use crate::reader::Reader;
use crate::tree::{Id, Tree};

/// The context of an element.
#[derive(Clone)]
struct Context {
    /// The index of its body.
    body: usize,
    /// The pose of the `<frame>` elements around it, in the body.
    frame: Isometry3<f64>,
    /// The factors of the `<frame>` elements around it.
    scale: FrameScale,
    class: Class,
    /// The suffix of the replicates around it.
    suffix: Rc<str>,
}

impl Reader<'_> {
    /// Reads all bodies, the world first, parents before children.
    pub(crate) fn bodies(&mut self) -> Vec<Body> {
        let sections: Vec<Id> = self.tree.children(Tree::ROOT, "worldbody").collect();
        self.walk(&sections, MAIN)
    }

    /// The joints in a frame, which need not be in the tree, with their elements. Reports nothing.
    pub(crate) fn joints_in(&mut self, frame: Id) -> Vec<(Id, JointType)> {
        let saved = (self.errors.len(), self.refused_warnings.len(), self.angles.len());
        let report = self.report.clone();
        let node = &self.tree.nodes[frame];
        let class = node.attribute("childclass").and_then(|name| self.classes.find(name));
        let bodies = self.walk(&[frame], class.unwrap_or(MAIN));
        self.errors.truncate(saved.0);
        self.refused_warnings.truncate(saved.1);
        self.angles.truncate(saved.2);
        self.report = report;
        let joints = bodies.iter().flat_map(|body| &body.joints);
        joints.map(|joint| (joint.element.node, joint.motion)).collect()
    }

    /// Reads the bodies in these elements, the world first.
    fn walk(&mut self, sections: &[Id], class: Class) -> Vec<Body> {
        let world = self.raw_element(Tree::ROOT);
        let mut bodies = vec![Body::new("world".into(), world, 0, Isometry3::identity())];
        let context = Context {
            body: 0,
            frame: Isometry3::identity(),
            scale: FrameScale::ONE,
            class,
            suffix: Rc::from(""),
        };
        let context = Rc::new(context);
        // A stack of reversed children gives the order of the file, depth first.
        let mut pending: Vec<(Id, Rc<Context>)> = Vec::new();
        for &section in sections.iter().rev() {
            self.push_children(section, &context, &mut pending);
        }
        while let Some((node, context)) = pending.pop() {
            self.read_body_element(node, &context, &mut bodies, &mut pending);
        }
        bodies
    }

    fn push_children(&self, node: Id, context: &Rc<Context>, pending: &mut Vec<(Id, Rc<Context>)>) {
        pending.extend(self.tree.nodes[node].children.iter().rev().map(|&child| (child, Rc::clone(context))));
    }

    /// Reads an element in a body. The elements in it are added to `pending`.
    fn read_body_element(
        &mut self,
        node: Id,
        context: &Rc<Context>,
        bodies: &mut Vec<Body>,
        pending: &mut Vec<(Id, Rc<Context>)>,
    ) {
        let tree = self.tree;
        let own_name = tree.nodes[node].attribute("name").unwrap_or_default();
        let name = if own_name.is_empty() { String::new() } else { format!("{own_name}{}", context.suffix) };
        let is_world = context.body == 0;
        if !context.suffix.is_empty() && !self.charge(node, Resource::Characters, name.len()) {
            pending.clear();
            return;
        }
        match tree.nodes[node].name.as_str() {
            "body" => self.read_body(node, name, context, bodies, pending),
            "frame" => self.read_frame(node, context, pending),
            "replicate" => self.replicate(node, context, pending),
            "inertial" if is_world => {
                let element = self.raw_element(node);
                self.refuse(&element, "the world cannot have an <inertial>; put it into a body");
            }
            "inertial" => self.read_inertial(node, context.scale, &mut bodies[context.body]),
            "joint" | "freejoint" if is_world => {
                let element = self.raw_element(node);
                self.refuse(&element, "the world cannot have joints; put the joint into a body");
            }
            "joint" => {
                let element = self.element(node, context.class);
                let mut joint = self.joint(&element, name, &context.frame);
                if context.scale != FrameScale::ONE {
                    // The anchor is in the body, and its offset from the frame is scaled.
                    let origin = context.frame.translation.vector;
                    joint.anchor = origin + (joint.anchor - origin) * context.scale.length;
                    context.scale.joint(&mut joint);
                }
                push(&mut bodies[context.body].joints, joint);
            }
            "freejoint" => {
                let element = self.raw_element(node);
                let joint = self.free_joint(&element, name);
                push(&mut bodies[context.body].joints, joint);
            }
            "geom" => {
                let element = self.element(node, context.class);
                let geom = self.geom(element, name, (&context.frame, context.scale));
                push(&mut bodies[context.body].geoms, geom);
            }
            "site" => self.read_site(node, name, context, &mut bodies[context.body]),
            // Reported by `list_unread`.
            _ => {}
        }
    }

    /// Reads a `<body>` without its content.
    fn read_body(
        &mut self,
        node: Id,
        name: String,
        context: &Context,
        bodies: &mut Vec<Body>,
        pending: &mut Vec<(Id, Rc<Context>)>,
    ) {
        let element = self.raw_element(node);
        let class = self.child_class(&element, context.class);
        let parent_from_body = context.frame * context.scale.place(self.placement(&element));
        let mut body = Body::new(name, element.clone(), context.body, parent_from_body);
        body.gravity_compensation = self.number(&element, "gravcomp").unwrap_or(0.0);
        body.mocap = self.boolean(&element, "mocap").unwrap_or(false);
        let inside = Context {
            body: bodies.len(),
            frame: Isometry3::identity(),
            scale: context.scale,
            class,
            suffix: Rc::clone(&context.suffix),
        };
        bodies.push(body);
        self.push_children(node, &Rc::new(inside), pending);
    }

    /// Reads a `<frame>`, which moves the elements in it.
    fn read_frame(&mut self, node: Id, context: &Context, pending: &mut Vec<(Id, Rc<Context>)>) {
        let element = self.raw_element(node);
        let class = self.child_class(&element, context.class);
        let frame = context.frame * context.scale.place(self.placement(&element));
        let scale = self.frame_scale(&element, context.scale);
        let inside = Context { frame, scale, class, ..Context::clone(context) };
        self.push_children(node, &Rc::new(inside), pending);
    }

    /// Reads the `<inertial>` of a body, unless it already has one.
    fn read_inertial(&mut self, node: Id, scale: FrameScale, body: &mut Body) {
        let element = self.raw_element(node);
        let place = format!("{}/inertial", body.element.place);
        let element = Element { place, ..element };
        if let Some(first) = &body.inertial {
            let message = format!(
                "a second <inertial>; the first, on line {}, counts; delete one of them",
                first.element.line
            );
            self.warn(&element, message);
        } else {
            let mut inertial = self.inertial(element);
            scale.inertial(&mut inertial);
            body.inertial = Some(Box::new(inertial));
        }
    }

    /// Reads a `<site>`; without a name nothing refers to it.
    fn read_site(&mut self, node: Id, name: String, context: &Context, body: &mut Body) {
        let element = self.element(node, context.class);
        let placement = match self.numbers::<6>(&element, "fromto") {
            Some([a, b, c, d, e, f]) => segment([a, b, c].into(), [d, e, f].into()),
            None => self.placement(&element),
        };
        if !name.is_empty() {
            push(
                &mut body.sites,
                Site { name, element, body_from_site: context.frame * context.scale.place(placement) },
            );
        }
    }

    /// The class of `childclass`, or that of the context.
    fn child_class(&mut self, element: &Element, context: Class) -> Class {
        match self.tree.nodes[element.node].attribute("childclass") {
            Some(name) => self.class_named(name, element).unwrap_or(context),
            None => context,
        }
    }

    /// The number of elements in one copy of a `<replicate>`, including itself. A nested replicate counts its
    /// own copies when it is read.
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

    /// Reads a `<replicate>`: `count` copies, each translated by `offset` and rotated by `euler` relative to
    /// the one before. The number of a copy is appended to its names.
    fn replicate(&mut self, node: Id, context: &Rc<Context>, pending: &mut Vec<(Id, Rc<Context>)>) {
        let element = self.raw_element(node);
        let class = self.child_class(&element, context.class);
        let count = self.required_number(&element, "count");
        if !(0.0..=1e6).contains(&count) || count.fract() != 0.0 {
            if !count.is_nan() {
                self.refuse(&element, format!("count={count} is not a valid number of copies"));
            }
            return;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked just now
        let count = count as usize;
        let elements = count.saturating_mul(self.elements_of_copy(node));
        let separator = self.text(&element, "sep").unwrap_or_default();
        let digits = count.to_string().len();
        let suffixes = count.saturating_mul(separator.len() + digits + context.suffix.len());
        if !self.charge(node, Resource::Elements, elements)
            || !self.charge(node, Resource::Characters, suffixes)
        {
            pending.clear();
            return;
        }
        let offset = self.numbers::<3>(&element, "offset").unwrap_or_default();
        let euler = self.numbers::<3>(&element, "euler").unwrap_or_default();
        let compiler = self.compiler(&element);
        let turn = |times: f64| self.euler(&element, euler.map(|angle| times * compiler.angle(angle)));
        let step = context.scale.place(Isometry3::from_parts(Translation3::from(offset), turn(1.0)));
        let mut place = Isometry3::identity();
        let mut copies = Vec::new();
        for copy in 0..count {
            // The rotation is computed anew for each copy, so that rounding does not accumulate.
            let here = Isometry3::from_parts(place.translation, turn(copy as f64));
            let suffix = format!("{separator}{copy:0digits$}{}", context.suffix);
            copies.push(Rc::new(Context {
                frame: context.frame * here,
                class,
                suffix: Rc::from(suffix),
                ..Context::clone(context)
            }));
            place *= step;
        }
        for copy in copies.iter().rev() {
            self.push_children(node, copy, pending);
        }
        self.push(element.line, element.place, Disposition::Read, format!("{count} copies"));
    }
}

/// Adds an item. Most bodies have one of a kind, for which a vector would reserve four.
fn push<T>(list: &mut Vec<T>, item: T) {
    if list.is_empty() {
        list.reserve_exact(1);
    }
    list.push(item);
}

/// The frame at the midpoint of a segment, with z from the second point to the first.
fn segment(from: nalgebra::Vector3<f64>, to: nalgebra::Vector3<f64>) -> Isometry3<f64> {
    let along = from - to;
    let length = along.norm();
    let turn =
        if length > 0.0 { crate::orientation::from_z_to(along / length) } else { UnitQuaternion::identity() };
    Isometry3::from_parts(Translation3::from((from + to) * 0.5), turn)
}

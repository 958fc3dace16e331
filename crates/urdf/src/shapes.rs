//! `<visual>` and `<collision>`: the shapes of links, and the angles of all frames as they are written.
//!
//! None of it moves the robot, so none of it can be wrong enough to refuse a file: what cannot be read is
//! left out, with an entry in the report.

use multibody::plausibility::WrittenAngles;
use multibody::{LinkShape, Pose, Shape, ShapeRole};
use robot_xml::roxmltree::Node;

use crate::element::Element;
use crate::reader::Reader;
use robot_xml::excerpt;

/// What a file shows beside its dynamics.
#[derive(Default)]
pub(crate) struct Appearance {
    pub(crate) shapes: Vec<LinkShape>,
    pub(crate) angles: Vec<WrittenAngles>,
}

impl<'a> Reader<'a> {
    /// The shapes and written angles of a robot whose links and joints have been read.
    pub(crate) fn appearance(&mut self, robot: &Element<'a>) -> Appearance {
        let mut found = Appearance::default();
        let colors = self.colors(robot.node);
        for node in robot.node.children() {
            if self.is(node, "link") {
                for part in node.children().filter(Node::is_element) {
                    if self.is(part, "inertial") {
                        found.angles.extend(self.written_angles(part, || self.named(node, "link").place));
                    }
                    let role = match part.tag_name().name() {
                        "visual" if self.is_own(part) => ShapeRole::Visual,
                        "collision" if self.is_own(part) => ShapeRole::Collision,
                        _ => continue,
                    };
                    let place = format!("{}/{}", self.named(node, "link").place, part.tag_name().name());
                    found.angles.extend(self.written_angles(part, || place.clone()));
                    if let Some(link) = node.attribute("name") {
                        let shape = self.shape(part, link, role, place);
                        let color = self.color(part, &colors);
                        found.shapes.extend(shape.map(|shape| match color {
                            Some(color) => shape.with_color(color),
                            None => shape,
                        }));
                    }
                }
            } else if self.is(node, "joint") {
                let place = || self.named(node, "joint").place;
                found.angles.extend(self.written_angles(node, place));
            }
        }
        found
    }

    /// The numbers of `<origin rpy>`, if there are three.
    fn written_angles(&self, parent: Node<'a, 'a>, place: impl FnOnce() -> String) -> Option<WrittenAngles> {
        let origin = parent.children().find(|&node| self.is(node, "origin"))?;
        let angles = numbers(origin.attribute("rpy")?).ok()?;
        Some(WrittenAngles::new(place(), angles))
    }

    /// The shape in a `<visual>` or `<collision>`; one that cannot be read is noted and left out.
    fn shape(&mut self, part: Node<'a, 'a>, link: &str, role: ShapeRole, place: String) -> Option<LinkShape> {
        let read = || -> Result<LinkShape, (Node<'a, 'a>, String)> {
            let child = |name: &str| part.children().find(|&node| self.is(node, name));
            let geometry = child("geometry").ok_or_else(|| (part, "no <geometry>".to_owned()))?;
            let form = geometry.children().find(|&node| self.is_own(node));
            let form = form.ok_or_else(|| (geometry, "an empty <geometry>".to_owned()))?;
            let shape = form_and_size(form).map_err(|message| (form, message))?;
            let link_from_shape = match child("origin") {
                Some(origin) => pose(origin).map_err(|message| (origin, message))?,
                None => Pose::IDENTITY,
            };
            let name = part.attribute("name").unwrap_or_default();
            Ok(LinkShape::new(link, role, link_from_shape, shape).with_name(name))
        };
        match read() {
            Ok(shape) => Some(shape),
            Err((node, message)) => {
                let line = self.line(node);
                self.ignored(line, place, format!("a shape that cannot be read: {message}"));
                None
            }
        }
    }
}

/// `<box size>`, `<cylinder radius length>`, `<sphere radius>`, `<capsule radius length>`, `<mesh filename scale>`.
fn form_and_size(form: Node<'_, '_>) -> Result<Shape, String> {
    let length = |name: &str| -> Result<f64, String> {
        let text = form.attribute(name).ok_or_else(|| format!("no {name}"))?;
        let [value] = numbers(text)?;
        if value < 0.0 { Err(format!("{name}={:?} is negative", excerpt(text))) } else { Ok(value) }
    };
    match form.tag_name().name() {
        "box" => {
            let text = form.attribute("size").ok_or("no size")?;
            let size = numbers(text)?;
            if size.iter().any(|&edge| edge < 0.0) {
                return Err(format!("size={:?} is negative", excerpt(text)));
            }
            Ok(Shape::Box { size })
        }
        "cylinder" => Ok(Shape::Cylinder { radius: length("radius")?, length: length("length")? }),
        "capsule" => Ok(Shape::Capsule { radius: length("radius")?, length: length("length")? }),
        "sphere" => Ok(Shape::Sphere { radius: length("radius")? }),
        "mesh" => {
            let name = form.attribute("filename").ok_or("no filename")?.to_owned();
            let scale = form.attribute("scale").map_or(Ok([1.0; 3]), numbers)?;
            Ok(Shape::Mesh { name, file: None, scale })
        }
        other => Err(format!("<{}> is no shape known here", excerpt(other))),
    }
}

/// `<origin xyz rpy>`, both optional.
fn pose(origin: Node<'_, '_>) -> Result<Pose, String> {
    let read = |name: &str| origin.attribute(name).map_or(Ok([0.0; 3]), numbers);
    Ok(Pose::from_xyz_rpy(read("xyz")?, read("rpy")?))
}

/// `N` finite numbers between white space.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let shown = excerpt(text);
    let mut values = [0.0; N];
    let mut words = text.split_ascii_whitespace();
    for value in &mut values {
        let word = words.next().ok_or_else(|| format!("{shown:?} has fewer than {N} numbers"))?;
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        *value = number.ok_or_else(|| format!("{shown:?} is not a number"))?;
    }
    if words.next().is_some() {
        return Err(format!("{shown:?} has more than {N} numbers"));
    }
    Ok(values)
}

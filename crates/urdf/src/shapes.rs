//! Reads `<visual>` and `<collision>`, and the angles of all frames as written.
//!
//! Shapes do not affect the motion, so a bad shape does not refuse the file: it is omitted and reported.

use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{LinkShape, Pose, Shape, ShapeRole};
use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::element::Element;
use crate::reader::Reader;

/// The shapes of a robot and the angles of its frames as written.
#[derive(Default)]
pub(crate) struct Appearance {
    pub(crate) shapes: Vec<LinkShape>,
    pub(crate) angles: Vec<WrittenAngles>,
}

impl<'a> Reader<'a> {
    /// Reads the shapes and the angles of a robot.
    pub(crate) fn appearance(&mut self, robot: &Element<'a>) -> Appearance {
        let mut appearance = Appearance::default();
        let colors = self.colors(robot.node);
        for node in robot.node.children() {
            if self.is(node, "link") {
                for part in node.children().filter(Node::is_element) {
                    if self.is(part, "inertial") {
                        appearance
                            .angles
                            .extend(self.written_angles(part, || self.named_element(node, "link").place));
                    }
                    let role = match part.tag_name().name() {
                        "visual" if self.is_own(part) => ShapeRole::Visual,
                        "collision" if self.is_own(part) => ShapeRole::Collision,
                        _ => continue,
                    };
                    let place =
                        format!("{}/{}", self.named_element(node, "link").place, part.tag_name().name());
                    appearance.angles.extend(self.written_angles(part, || place.clone()));
                    if let Some(link) = node.attribute("name") {
                        let shape = self.shape(part, link, role, place);
                        let color = self.color(part, &colors);
                        appearance.shapes.extend(shape.map(|shape| match color {
                            Some(color) => shape.with_color(color),
                            None => shape,
                        }));
                    }
                }
            } else if self.is(node, "joint") {
                let place = || self.named_element(node, "joint").place;
                appearance.angles.extend(self.written_angles(node, place));
            }
        }
        appearance
    }

    /// The three numbers of `<origin rpy>`.
    fn written_angles(&self, parent: Node<'a, 'a>, place: impl FnOnce() -> String) -> Option<WrittenAngles> {
        let origin = parent.children().find(|&node| self.is(node, "origin"))?;
        let angles = parse_numbers(origin.attribute("rpy")?).ok()?;
        Some(WrittenAngles::new(place(), angles))
    }

    /// Reads the shape of a `<visual>` or `<collision>`. A bad shape is reported and omitted.
    fn shape(&mut self, part: Node<'a, 'a>, link: &str, role: ShapeRole, place: String) -> Option<LinkShape> {
        let read = || -> Result<LinkShape, (Node<'a, 'a>, String)> {
            let child = |name: &str| part.children().find(|&node| self.is(node, name));
            let geometry = child("geometry").ok_or_else(|| (part, "no <geometry>".to_owned()))?;
            let form = geometry.children().find(|&node| self.is_own(node));
            let form = form.ok_or_else(|| (geometry, "an empty <geometry>".to_owned()))?;
            let shape = parse_shape(form).map_err(|message| (form, message))?;
            let link_from_shape = match child("origin") {
                Some(origin) => parse_pose(origin).map_err(|message| (origin, message))?,
                None => Pose::IDENTITY,
            };
            let name = part.attribute("name").unwrap_or_default();
            Ok(LinkShape::new(link, role, link_from_shape, shape).with_name(name))
        };
        match read() {
            Ok(shape) => Some(shape),
            Err((node, message)) => {
                let line = self.line(node);
                self.report_ignored(line, place, format!("invalid shape: {message}"));
                None
            }
        }
    }
}

/// `<box size>`, `<cylinder radius length>`, `<sphere radius>`, `<capsule radius length>`, `<mesh filename
/// scale>`.
fn parse_shape(form: Node<'_, '_>) -> Result<Shape, String> {
    let length = |name: &str| -> Result<f64, String> {
        let text = form.attribute(name).ok_or_else(|| format!("no {name}"))?;
        let [value] = parse_numbers(text)?;
        if value < 0.0 { Err(format!("{name}={:?} is negative", excerpt(text))) } else { Ok(value) }
    };
    match form.tag_name().name() {
        "box" => {
            let text = form.attribute("size").ok_or("no size")?;
            let size = parse_numbers(text)?;
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
            let scale = form.attribute("scale").map_or(Ok([1.0; 3]), parse_numbers)?;
            Ok(Shape::Mesh { name, file: None, scale })
        }
        other => Err(format!("unknown shape <{}>", excerpt(other))),
    }
}

/// The pose of `<origin xyz rpy>`; both attributes are optional.
fn parse_pose(origin: Node<'_, '_>) -> Result<Pose, String> {
    let read = |name: &str| origin.attribute(name).map_or(Ok([0.0; 3]), parse_numbers);
    Ok(Pose::from_xyz_rpy(read("xyz")?, read("rpy")?))
}

/// `N` finite numbers separated by white space.
pub(crate) fn parse_numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
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

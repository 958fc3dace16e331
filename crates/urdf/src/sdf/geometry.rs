//! Reads `<collision>` and `<visual>`.
//!
//! Shapes do not affect the motion, so a bad shape does not refuse the file: it is omitted and reported.

use robot_dynamics_description::{Pose, Shape, ShapeRole, Surface, z_onto};
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Resource, excerpt};

use super::parts::{Parts, Scope, SdfShape};
use crate::element::Element;
use crate::reader::Reader;
use crate::shapes::parse_numbers;
use crate::unread_parts::UnknownPart;

impl Parts<'_> {
    pub(super) fn shape<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        role: ShapeRole,
        scope: &Scope,
    ) -> Option<SdfShape> {
        let known = [
            "pose",
            "geometry",
            "surface",
            "material",
            "density",
            "auto_inertia_params",
            "laser_retro",
            "max_contacts",
            "cast_shadows",
            "transparency",
            "visibility_flags",
            "plugin",
            "meta",
        ];
        reader.list_unread(element, &["name"], &known, UnknownPart::Harmless);
        if !self.charge(reader, element, Resource::Characters, 2 * scope.prefix.len()) {
            return None;
        }
        let written = reader.pose(element);
        let relative_to = written.relative_to.map(|name| scope.target(name));
        let read = reader.child(element, "geometry").ok_or_else(|| "no <geometry>".to_owned());
        let shape = read.and_then(|geometry| {
            let form = geometry.node.children().find(Node::is_element);
            form.ok_or_else(|| "an empty <geometry>".to_owned()).and_then(|form| self.form(form))
        });
        let (shape, shape_from_form) = match shape {
            Ok(Some(found)) => found,
            Ok(None) => return None,
            Err(message) => {
                let (line, place) = (element.line, element.place.clone());
                if message.contains("not read") && role == ShapeRole::Collision {
                    reader.warn(element, message);
                } else {
                    reader.report_ignored(line, place, format!("invalid shape: {message}"));
                }
                return None;
            }
        };
        let surface = match reader.child(element, "surface") {
            Some(surface) if role == ShapeRole::Collision => read_surface(reader, &surface),
            _ => Surface::default(),
        };
        Some(SdfShape {
            at: self.place(element),
            name: format!("{}{}", scope.prefix, element.text("name").unwrap_or_default()),
            role,
            relative_to,
            pose: written.pose.compose(&shape_from_form),
            shape,
            color: color(reader, element.node),
            surface,
        })
    }

    /// The shape of a geometry, with its pose; `None` for an empty one.
    fn form(&mut self, form: Node<'_, '_>) -> Result<Option<(Shape, Pose)>, String> {
        let text = |name: &str| {
            let child = form.children().find(|child| child.tag_name().name() == name);
            child.and_then(|child| child.text()).map(str::trim)
        };
        let length = |name: &str| -> Result<f64, String> {
            let [value] = parse_numbers(text(name).ok_or_else(|| format!("no <{name}>"))?)?;
            if value < 0.0 { Err(format!("{name} {value} is negative")) } else { Ok(value) }
        };
        let lengths = |name: &str| -> Result<[f64; 3], String> {
            let values: [f64; 3] = parse_numbers(text(name).ok_or_else(|| format!("no <{name}>"))?)?;
            let is_valid = values.iter().all(|&value| value >= 0.0);
            if is_valid { Ok(values) } else { Err(format!("{name} is negative")) }
        };
        let shape = match form.tag_name().name() {
            "box" => Shape::Box { size: lengths("size")? },
            "cylinder" => Shape::Cylinder { radius: length("radius")?, length: length("length")? },
            "capsule" => Shape::Capsule { radius: length("radius")?, length: length("length")? },
            "sphere" => Shape::Sphere { radius: length("radius")? },
            "ellipsoid" => Shape::Ellipsoid { half_axes: lengths("radii")? },
            "plane" => {
                let normal = text("normal").map_or(Ok([0.0, 0.0, 1.0]), parse_numbers)?;
                if normal.iter().all(|c: &f64| c.abs() < 1e-100) {
                    return Err("the normal is zero".to_owned());
                }
                let size: [f64; 2] = text("size").map_or(Ok([1.0; 2]), parse_numbers)?;
                return Ok(Some((
                    Shape::Plane { half_size: size.map(|edge| 0.5 * edge.abs()) },
                    z_onto(normal),
                )));
            }
            "mesh" => {
                let name = text("uri").filter(|name| !name.is_empty()).ok_or("no <uri>")?.to_owned();
                let scale = text("scale").map_or(Ok([1.0; 3]), parse_numbers)?;
                let file = if self.locates { self.search.find(&name) } else { None };
                if self.locates && file.is_none() {
                    self.missing_meshes.insert(name.clone());
                }
                Shape::Mesh { name, file, scale }
            }
            "empty" => return Ok(None),
            other => return Err(format!("the shape <{}> is not read", excerpt(other))),
        };
        Ok(Some((shape, Pose::IDENTITY)))
    }
}

/// The diffuse colour of a visual.
fn color<'a>(reader: &Reader<'a>, visual: Node<'a, 'a>) -> Option<[f64; 4]> {
    let child = |node: Node<'a, 'a>, name: &str| node.children().find(|&child| reader.is(child, name));
    let material = child(visual, "material")?;
    let text = child(material, "diffuse").or_else(|| child(material, "ambient"))?.text()?;
    parse_numbers(text).ok().or_else(|| {
        let [red, green, blue] = parse_numbers(text).ok()?;
        Some([red, green, blue, 1.0])
    })
}

/// Friction and masks of a collision shape. Other parameters belong to one physics engine each.
fn read_surface<'a>(reader: &mut Reader<'a>, element: &Element<'a>) -> Surface {
    let mut surface = Surface::default();
    let known = ["friction", "contact", "bounce", "soft_contact"];
    reader.list_unread(element, &[], &known, UnknownPart::Harmless);
    if let Some(friction) = reader.child(element, "friction") {
        if let Some(ode) = reader.child(&friction, "ode")
            && let Some(mu) = reader.child_number(&ode, "mu")
        {
            surface.friction[0] = mu.abs();
        }
        if let Some(torsional) = reader.child(&friction, "torsional")
            && let Some(coefficient) = reader.child_number(&torsional, "coefficient")
        {
            surface.friction[1] = coefficient.abs();
        }
    }
    if let Some(contact) = reader.child(element, "contact") {
        let is_off = reader.child_flag(&contact, "collide_without_contact") == Some(true)
            || reader
                .child_text(&contact, "collide_bitmask")
                .is_some_and(|(_, mask)| matches!(mask, "0" | "0x0" | "0x00"));
        if is_off {
            (surface.contype, surface.conaffinity) = (0, 0);
        }
    }
    let of_an_engine =
        ["mu2", "fdir1", "slip1", "slip2", "bullet", "kp", "kd", "soft_cfm", "soft_erp", "poissons_ratio"];
    let is_left_out = |node: &Node<'a, 'a>| of_an_engine.contains(&node.tag_name().name());
    if element.node.descendants().any(|node| is_left_out(&node)) {
        let (line, place) = (element.line, element.place.clone());
        reader.report_ignored(line, place, "contact parameters of one physics engine");
    }
    for name in ["bounce", "soft_contact"] {
        if let Some(part) = reader.child(element, name) {
            reader.report_ignored(part.line, part.place, "a contact parameter that the model does not have");
        }
    }
    surface
}

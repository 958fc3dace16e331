//! Writes `<visual>` and `<collision>`.

use robot_dynamics_description::{LinkShape, Shape, ShapeRole, Surface};
use robot_dynamics_xml::{excerpt, is_name, way_from};

use super::UrdfWriter;

impl UrdfWriter<'_> {
    pub(super) fn write_shape(&mut self, shape: &LinkShape) {
        let place = format!("a shape of link {:?}", excerpt(&shape.link));
        let word = match shape.shape {
            Shape::Box { .. }
            | Shape::Cylinder { .. }
            | Shape::Sphere { .. }
            | Shape::Capsule { .. }
            | Shape::Mesh { .. } => None,
            Shape::Ellipsoid { .. } => Some("ellipsoids"),
            Shape::Plane { .. } => Some("planes"),
            Shape::HeightField { .. } => Some("height fields"),
        };
        if let Some(word) = word {
            self.add_note(&place, format!("omitted: URDF has no {word}"));
            return;
        }
        let collides = shape.role == ShapeRole::Collision;
        self.xml.start(if collides { "collision" } else { "visual" });
        if is_name(&shape.name) {
            self.xml.attribute("name", &shape.name);
        }
        self.write_origin(&shape.link_from_shape);
        self.xml.start("geometry");
        match &shape.shape {
            Shape::Box { size } => self.xml.start("box").numbers("size", size),
            Shape::Cylinder { radius, length } => {
                self.xml.start("cylinder").numbers("radius", &[*radius]).numbers("length", &[*length])
            }
            Shape::Capsule { radius, length } => {
                self.xml.start("capsule").numbers("radius", &[*radius]).numbers("length", &[*length])
            }
            Shape::Sphere { radius } => self.xml.start("sphere").numbers("radius", &[*radius]),
            Shape::Mesh { name, file, scale } => {
                // Names with a scheme, such as package://, do not depend on the folder.
                let is_place = name.contains("://");
                let found = self.folder.zip(file.as_deref()).filter(|_| !is_place);
                let name = found.map_or_else(|| name.clone(), |(folder, file)| way_from(folder, file));
                self.xml.start("mesh").attribute("filename", &name);
                if *scale != [1.0; 3] {
                    self.xml.numbers("scale", scale);
                }
                &mut self.xml
            }
            _ => &mut self.xml,
        };
        self.xml.end().end();
        if let Some(color) = shape.color.filter(|_| !collides) {
            let known = self.colors.iter().position(|known| *known == color);
            let number = known.unwrap_or(self.colors.len());
            self.xml.start("material").attribute("name", &format!("color_{}", number + 1));
            if known.is_none() {
                self.colors.push(color);
            }
            self.xml.start("color").numbers("rgba", &color).end().end();
        }
        self.xml.end();
        if collides && (shape.surface != Surface::default() || !shape.surface_velocity.is_zero()) {
            self.add_note(&place, "contact properties of its surface: not supported by URDF");
        }
    }
}

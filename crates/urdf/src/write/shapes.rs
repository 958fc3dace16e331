//! `<visual>` and `<collision>`.

use multibody::{LinkShape, Shape, ShapeRole, Surface};
use robot_xml::{excerpt, is_name, way_from};

use super::Writing;

impl Writing<'_> {
    pub(super) fn shape(&mut self, shape: &LinkShape) {
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
            _ => Some("shapes of its kind"),
        };
        if let Some(word) = word {
            self.note(&place, format!("left out: the format has no {word}"));
            return;
        }
        let collides = shape.role == ShapeRole::Collision;
        self.xml.start(if collides { "collision" } else { "visual" });
        if is_name(&shape.name) {
            self.xml.attribute("name", &shape.name);
        }
        self.origin(&shape.link_from_shape);
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
                // A package is found from anywhere.
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
        if collides && shape.surface != Surface::default() {
            self.note(&place, "friction and other properties of its surface: the format has none");
        }
    }
}

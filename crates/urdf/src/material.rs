//! Reads `<material>`: the colours of shapes.

use std::collections::HashMap;

use robot_dynamics_xml::roxmltree::Node;

use crate::reader::Reader;
use crate::shapes::parse_numbers;

/// Colours of all named materials in the file: red, green, blue, opacity.
pub(crate) type Colors<'a> = HashMap<&'a str, [f64; 4]>;

impl<'a> Reader<'a> {
    /// Collects the materials with a name and a colour. The first one of a name counts.
    pub(crate) fn colors(&self, robot: Node<'a, 'a>) -> Colors<'a> {
        let mut colors = Colors::new();
        for material in robot.descendants().filter(|&node| self.is(node, "material")) {
            if let (Some(name), Some(color)) = (material.attribute("name"), self.own_color(material)) {
                colors.entry(name).or_insert(color);
            }
        }
        colors
    }

    /// The colour of a `<visual>`: that of its material, or of the material with the same name.
    pub(crate) fn color(&self, visual: Node<'a, 'a>, colors: &Colors<'a>) -> Option<[f64; 4]> {
        let material = visual.children().find(|&node| self.is(node, "material"))?;
        self.own_color(material).or_else(|| colors.get(material.attribute("name")?).copied())
    }

    fn own_color(&self, material: Node<'a, 'a>) -> Option<[f64; 4]> {
        let color = material.children().find(|&node| self.is(node, "color"))?;
        parse_numbers(color.attribute("rgba")?).ok()
    }
}

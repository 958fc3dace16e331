//! `<contact>/<exclude>`: bodies that never touch.

use multibody::RobotDescription;

use crate::assemble::Places;
use crate::body::Body;
use crate::reader::{Element, Reader};
use crate::tree::Id;

impl Reader<'_> {
    /// Pairs of links by name.
    pub(crate) fn exclusions(&mut self, bodies: &[Body], places: &Places, robot: &mut RobotDescription) {
        let all: Vec<Id> =
            self.tree.in_sections("contact").filter(|&id| self.tree.nodes[id].name == "exclude").collect();
        for id in all {
            let element = self.plain(id);
            let first = self.body_named(&element, "body1", bodies);
            let second = self.body_named(&element, "body2", bodies);
            if let (Some(first), Some(second)) = (first, second) {
                let link = |body: usize| places.links[body].clone();
                robot.contact_exclusions.push((link(first), link(second)));
            }
        }
    }

    /// The body that an attribute names, which must be there.
    pub(crate) fn body_named(
        &mut self,
        element: &Element,
        attribute: &'static str,
        bodies: &[Body],
    ) -> Option<usize> {
        let name = self.required_text(element, attribute, "BODY")?;
        let index = self.body_index(name, bodies);
        if index.is_none() {
            self.unknown_name(element, "body", name);
        }
        index
    }

    fn body_index(&mut self, name: &str, bodies: &[Body]) -> Option<usize> {
        if self.body_indices.is_empty() {
            self.body_indices =
                bodies.iter().enumerate().rev().map(|(index, body)| (body.name.clone(), index)).collect();
        }
        self.body_indices.get(name).copied()
    }
}

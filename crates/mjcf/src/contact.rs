//! Reads `<contact>`: excluded pairs of bodies, and explicit pairs of geoms.

use std::collections::HashSet;

use robot_dynamics_description::{ContactPairDescription, Disposition, RobotDescription};

use crate::assembly::ElementTable;
use crate::body::Body;
use crate::classes::MAIN;
use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Id;

impl Reader<'_> {
    /// Reads `<exclude>`: pairs of links.
    pub(crate) fn exclusions(&mut self, bodies: &[Body], table: &ElementTable, robot: &mut RobotDescription) {
        let all: Vec<Id> =
            self.tree.in_sections("contact").filter(|&id| self.tree.nodes[id].name == "exclude").collect();
        for id in all {
            let element = self.raw_element(id);
            let first = self.body_named(&element, "body1", bodies);
            let second = self.body_named(&element, "body2", bodies);
            if let (Some(first), Some(second)) = (first, second) {
                let link = |body: usize| table.links[body].clone();
                robot.contact_exclusions.push((link(first), link(second)));
            }
        }
    }

    /// Reads `<pair>`: pairs of geoms. The contact parameters are those of the pair, not those of the geoms.
    pub(crate) fn pairs(&mut self, bodies: &[Body]) -> Vec<(Element, ContactPairDescription)> {
        let all: Vec<Id> =
            self.tree.in_sections("contact").filter(|&id| self.tree.nodes[id].name == "pair").collect();
        if all.is_empty() {
            return Vec::new();
        }
        let geoms: HashSet<&str> =
            bodies.iter().flat_map(|body| &body.geoms).map(|geom| geom.name.as_str()).collect();
        let mut found = Vec::new();
        for id in all {
            let element = self.element(id, MAIN);
            let first = self.geom_named(&element, "geom1", &geoms);
            let second = self.geom_named(&element, "geom2", &geoms);
            let (Some(first), Some(second)) = (first, second) else { continue };
            let mut pair = ContactPairDescription::new([first, second]);
            self.tree.nodes[id].attribute("name").unwrap_or_default().clone_into(&mut pair.name);
            pair.friction = self.overlay(&element, "friction", pair.friction);
            pair.solref = self.overlay(&element, "solref", pair.solref);
            let of_friction = self.overlay(&element, "solreffriction", [0.0; 2]);
            // Zeros mean that the numbers of the normal force apply.
            pair.solreffriction = Some(of_friction).filter(|solref| *solref != [0.0; 2]);
            pair.solimp = self.overlay(&element, "solimp", pair.solimp);
            pair.margin = self.number(&element, "margin").unwrap_or(pair.margin);
            pair.gap = self.number(&element, "gap").unwrap_or(pair.gap);
            match self.number(&element, "condim") {
                None => {}
                Some(dimensions) if dimensions.is_nan() => {}
                Some(1.0) => pair.condim = 1,
                Some(3.0) => pair.condim = 3,
                Some(4.0) => pair.condim = 4,
                Some(6.0) => pair.condim = 6,
                Some(dimensions) => {
                    self.refuse(&element, format!("invalid condim={dimensions}; use 1, 3, 4 or 6"));
                }
            }
            let [slide, across, _, roll, other] = pair.friction;
            if slide < across || across < slide || roll < other || other < roll {
                let message = "friction differs in two directions: contacts use the first for both";
                let (line, place) = (element.line, element.place.clone());
                self.push(line, place, Disposition::Ignored { physics: false }, message.into());
            }
            found.push((element, pair));
        }
        found
    }

    /// Adds the pairs whose two shapes are both kept.
    pub(crate) fn keep_pairs(
        &mut self,
        pairs: Vec<(Element, ContactPairDescription)>,
        robot: &mut RobotDescription,
    ) {
        let kept: HashSet<&str> = robot.shapes.iter().map(|shape| shape.name.as_str()).collect();
        for (Element { line, place, .. }, pair) in pairs {
            if pair.shapes.iter().all(|shape| kept.contains(shape.as_str())) {
                robot.contact_pairs.push(pair);
            } else {
                let message = "omitted, because the shape of one of its geoms is not kept";
                self.push(line, place, Disposition::Ignored { physics: false }, message.into());
            }
        }
    }

    fn geom_named(
        &mut self,
        element: &Element,
        attribute: &'static str,
        geoms: &HashSet<&str>,
    ) -> Option<String> {
        let name = self.required_text(element, attribute, "GEOM")?;
        if geoms.contains(name) {
            return Some(name.to_owned());
        }
        self.refuse_unknown_name(element, "geom", name);
        None
    }

    /// The body that a required attribute names.
    pub(crate) fn body_named(
        &mut self,
        element: &Element,
        attribute: &'static str,
        bodies: &[Body],
    ) -> Option<usize> {
        let name = self.required_text(element, attribute, "BODY")?;
        let index = self.body_index(name, bodies);
        if index.is_none() {
            self.refuse_unknown_name(element, "body", name);
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

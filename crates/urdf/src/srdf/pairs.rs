//! Pairs of links that never touch.

use std::collections::HashSet;

use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Budget, ExceededLimit, Resource};

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The pairs of an SRDF file.
pub(super) struct CollisionPairs<'a> {
    /// Each once.
    pub(super) pairs: Vec<(String, String)>,
    /// All names of links, with their elements.
    pub(super) names: Vec<(Element<'a>, &'a str)>,
}

/// The pairs of links whose collisions are disabled and not enabled again. A missing name is listed as an
/// error.
pub(super) fn collision_pairs<'a>(
    reader: &mut Reader<'a>,
    budget: &mut Budget,
    root: &Element<'a>,
    links: &[&str],
) -> CollisionPairs<'a> {
    let mut found = CollisionPairs { pairs: Vec::new(), names: Vec::new() };
    let (mut pairs, mut enabled) = (Vec::<(&str, &str)>::new(), HashSet::new());
    for node in root.node.children().filter(Node::is_element) {
        let name = node.tag_name().name();
        let attributes: &[&str] = match name {
            "disable_collisions" | "enable_collisions" if reader.is(node, name) => &["link1", "link2"],
            "disable_default_collisions" if reader.is(node, name) => &["link"],
            _ => continue,
        };
        let element = Element { node, line: reader.line(node), place: format!("<{name}>") };
        reader.list_unread(&element, &[attributes, &["reason"]].concat(), &[], UnknownPart::Harmless);
        let mut named = attributes.iter().map(|attribute| {
            reader.required_name(&element, attribute, &format!("{attribute}=\"…\", the name of a link"))
        });
        let (own, other) = (named.next().unwrap_or_default(), named.next());
        let added = match other {
            Some(other) if name == "enable_collisions" => {
                enabled.extend([(own, other), (other, own)]);
                1
            }
            Some(other) => {
                pairs.push((own, other));
                1
            }
            None => links.len(),
        };
        found.names.extend(core::iter::once(own).chain(other).map(|name| (element.clone(), name)));
        if let Err(ExceededLimit { limit, .. }) = budget.charge(Resource::Elements, added) {
            reader.refuse(UrdfError::TooMany { line: element.line, what: "pairs of links", limit });
            return found;
        }
        if other.is_none() {
            pairs.extend(links.iter().filter(|other| **other != own).map(|other| (own, *other)));
        }
    }
    let mut seen = HashSet::new();
    for (a, b) in pairs {
        let is_new = seen.insert((a, b));
        seen.insert((b, a));
        if is_new && !enabled.contains(&(a, b)) {
            found.pairs.push((a.to_owned(), b.to_owned()));
        }
    }
    found
}

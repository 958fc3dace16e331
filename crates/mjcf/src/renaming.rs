//! Renames copied elements: which attributes hold names, and of which kind of object.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use robot_dynamics_xml::{Budget, ExceededLimit, Resource};

use crate::path::stem;
use crate::tree::{Id, Node, Tree};

/// The kind of object that a name belongs to: `body`, `joint`, `site`, `geom`, `frame`, `tendon`, `actuator`.
pub(crate) type ObjectKind = &'static str;

/// The sections outside bodies whose elements refer to elements in bodies. A section comes before those that
/// refer to it.
pub(crate) const OUTER_SECTIONS: [&str; 5] = ["contact", "tendon", "equality", "actuator", "sensor"];

/// Attributes that refer to an object, with its kind.
const REFERENCES: &[(&str, ObjectKind)] = &[
    ("joint", "joint"),
    ("jointinparent", "joint"),
    ("joint1", "joint"),
    ("joint2", "joint"),
    ("tendon", "tendon"),
    ("actuator", "actuator"),
    ("tendon1", "tendon"),
    ("tendon2", "tendon"),
    ("site", "site"),
    ("site1", "site"),
    ("site2", "site"),
    ("refsite", "site"),
    ("slidersite", "site"),
    ("cranksite", "site"),
    ("sidesite", "site"),
    ("body", "body"),
    ("body1", "body"),
    ("body2", "body"),
    ("geom", "geom"),
    ("geom1", "geom"),
    ("geom2", "geom"),
];

/// Attributes that refer to an object, with the attribute that gives its kind.
const BY_KIND: [(&str, &str); 2] = [("objname", "objtype"), ("refname", "reftype")];

/// The kind of object that an attribute of the element refers to.
fn kind_of(node: &Node, attribute: &str) -> Option<ObjectKind> {
    if let Some((_, kind)) = REFERENCES.iter().find(|(own, _)| *own == attribute) {
        return Some(kind);
    }
    let (_, kind) = BY_KIND.iter().find(|(own, _)| *own == attribute)?;
    match node.attribute(kind)? {
        "body" | "xbody" => Some("body"),
        "geom" => Some("geom"),
        "site" => Some("site"),
        _ => None,
    }
}

/// Attributes that refer to assets. A copy within the same file shares the assets.
const ASSETS: [&str; 4] = ["mesh", "material", "hfield", "texture"];

/// The changes of names in a copy.
#[derive(Default)]
pub(crate) struct Renaming<'a> {
    pub(crate) prefix: &'a str,
    pub(crate) suffix: &'a str,
    /// The new names of the classes of an attached model; `None` for a copy within the same model.
    pub(crate) classes: Option<&'a HashMap<String, String>>,
    /// Names that do not change.
    pub(crate) kept: HashSet<(ObjectKind, String)>,
}

impl Renaming<'_> {
    pub(crate) fn name(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }

    /// The largest length of an attribute in the copy.
    pub(crate) fn length(&self, text: &str) -> usize {
        self.prefix.len() + text.len() + self.suffix.len()
    }

    /// The new name of a class. A class that the model lacks is renamed like other names.
    pub(crate) fn class(&self, name: &str) -> String {
        let Some(classes) = self.classes else { return name.to_owned() };
        classes.get(name).cloned().unwrap_or_else(|| self.name(name))
    }

    /// The text of an attribute in the copy.
    pub(crate) fn attribute(&self, node: &Node, name: &str, text: &str) -> String {
        let kind = kind_of(node, name);
        let stays = |kind| (kind, text) == ("body", "world") || self.kept.contains(&(kind, text.to_owned()));
        let is_name = name == "name" || kind.is_some_and(|kind| !stays(kind));
        let is_asset = self.classes.is_some() && ASSETS.contains(&name);
        match name {
            "class" | "childclass" => self.class(text),
            _ if (is_name || is_asset) && !text.is_empty() => self.name(text),
            _ => text.to_owned(),
        }
    }
}

/// The kind and name of an element in this section.
pub(crate) fn of_element(node: &Node, section: &str) -> Option<(ObjectKind, String)> {
    let kind = match (section, node.name.as_str()) {
        ("worldbody", "body") => "body",
        ("worldbody", "joint" | "freejoint") => "joint",
        ("worldbody", "site") => "site",
        ("worldbody", "geom") => "geom",
        ("worldbody", "frame") => "frame",
        ("tendon", _) => "tendon",
        ("actuator", _) => "actuator",
        _ => return None,
    };
    let name = node.attribute("name").filter(|name| !name.is_empty())?;
    Some((kind, name.to_owned()))
}

/// The name of an asset, or that of its file.
pub(crate) fn asset_name(node: &Node) -> String {
    let own = node.attribute("name").filter(|name| !name.is_empty());
    own.or_else(|| node.attribute("file").map(stem)).unwrap_or_default().to_owned()
}

/// All objects that an element outside bodies and its descendants refer to.
pub(crate) fn references(tree: &Tree, element: Id) -> Vec<(ObjectKind, String)> {
    let mut found = Vec::new();
    let mut pending = vec![element];
    while let Some(id) = pending.pop() {
        let node = &tree.nodes[id];
        for own in REFERENCES.iter().map(|(own, _)| *own).chain(BY_KIND.map(|(own, _)| own)) {
            let name = node.attribute(own).filter(|name| !name.is_empty());
            found.extend(name.and_then(|name| Some((kind_of(node, own)?, name.to_owned()))));
        }
        pending.extend(&node.children);
    }
    found
}

/// The names in a part of the bodies, including its own, with the suffixes of replicates.
pub(crate) fn names_in(
    budget: &mut Budget,
    tree: &Tree,
    part: Id,
) -> Result<Vec<(ObjectKind, String)>, ExceededLimit> {
    let mut found = Vec::new();
    let mut pending: Vec<(Id, Rc<str>)> = vec![(part, Rc::from(""))];
    while let Some((id, suffix)) = pending.pop() {
        let node = &tree.nodes[id];
        found.extend(of_element(node, "worldbody").map(|(kind, name)| (kind, format!("{name}{suffix}"))));
        let replicate = Some(node).filter(|node| node.name == "replicate").and_then(Suffixes::of);
        let count = replicate.as_ref().map_or(1, |replicate| replicate.count);
        let length = replicate.as_ref().map_or(0, |replicate| replicate.suffix(0).len() + suffix.len() + 1);
        let steps = count.saturating_mul(node.children.len() + 1);
        budget.charge(Resource::Steps, steps)?;
        budget.charge(Resource::Characters, count.saturating_mul(length))?;
        for copy in 0..count {
            let suffix = replicate.as_ref().map_or_else(
                || Rc::clone(&suffix),
                |replicate| Rc::from(format!("{}{suffix}", replicate.suffix(copy))),
            );
            pending.extend(node.children.iter().map(|&child| (child, Rc::clone(&suffix))));
        }
    }
    Ok(found)
}

/// The suffixes that a `<replicate>` adds to the names in its copies.
pub(crate) struct Suffixes {
    pub(crate) count: usize,
    separator: String,
}

impl Suffixes {
    /// Reads the attributes of a `<replicate>`; `None` if its count is invalid.
    pub(crate) fn of(node: &Node) -> Option<Self> {
        let count: f64 = node.attribute("count")?.trim().parse().ok()?;
        if !(0.0..=1e6).contains(&count) || count.fract() != 0.0 {
            return None;
        }
        let separator = node.attribute("sep").unwrap_or_default().to_owned();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked just now
        Some(Self { count: count as usize, separator })
    }

    /// The separator and the number of the copy, padded to the digits of the count.
    pub(crate) fn suffix(&self, copy: usize) -> String {
        let digits = self.count.to_string().len();
        format!("{}{copy:0digits$}", self.separator)
    }
}

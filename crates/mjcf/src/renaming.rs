//! Names under a prefix: which attributes hold them, and of what.

use std::collections::{HashMap, HashSet};

use crate::tree::{Id, Node, Tree};

/// How much copies may make of a file: names count one each.
pub(crate) const MOST: usize = 2_000_000;

/// The sort of object that a name belongs to: `body`, `joint`, `site`, `geom`, `frame`, `tendon`, `actuator`.
pub(crate) type Sort = &'static str;

/// The sections outside bodies whose elements name what is in bodies, those first that others name.
pub(crate) const OUTER: [&str; 5] = ["contact", "tendon", "equality", "actuator", "sensor"];

/// Attributes that name something, and of what sort it is.
const REFERENCES: &[(&str, Sort)] = &[
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

/// Attributes that name an object, each with the attribute that gives its sort.
const BY_SORT: [(&str, &str); 2] = [("objname", "objtype"), ("refname", "reftype")];

/// The sort of object that an attribute of the element names.
fn sort_of(node: &Node, attribute: &str) -> Option<Sort> {
    if let Some((_, sort)) = REFERENCES.iter().find(|(own, _)| *own == attribute) {
        return Some(sort);
    }
    let (_, sort) = BY_SORT.iter().find(|(own, _)| *own == attribute)?;
    match node.attribute(sort)? {
        "body" | "xbody" => Some("body"),
        "geom" => Some("geom"),
        "site" => Some("site"),
        _ => None,
    }
}

/// Attributes that name assets, which a part of the same file shares.
const ASSETS: [&str; 4] = ["mesh", "material", "hfield", "texture"];

/// How a copy's names differ.
#[derive(Default)]
pub(crate) struct Renaming<'a> {
    pub(crate) prefix: &'a str,
    pub(crate) suffix: &'a str,
    /// What the classes of another model are called here; `None` for a part of the same one.
    pub(crate) classes: Option<&'a HashMap<String, String>>,
    /// Names that stay as they are, as that of the world does.
    pub(crate) kept: HashSet<(Sort, String)>,
}

impl Renaming<'_> {
    pub(crate) fn name(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }

    /// A class of a name that the model lacks is one here, too.
    pub(crate) fn class(&self, name: &str) -> String {
        let Some(classes) = self.classes else { return name.to_owned() };
        classes.get(name).cloned().unwrap_or_else(|| self.name(name))
    }

    /// An attribute's text in the copy.
    pub(crate) fn attribute(&self, node: &Node, name: &str, text: &str) -> String {
        let sort = sort_of(node, name);
        let stays = |sort| (sort, text) == ("body", "world") || self.kept.contains(&(sort, text.to_owned()));
        let is_name = name == "name" || sort.is_some_and(|sort| !stays(sort));
        let is_asset = self.classes.is_some() && ASSETS.contains(&name);
        match name {
            "class" | "childclass" => self.class(text),
            _ if (is_name || is_asset) && !text.is_empty() => self.name(text),
            _ => text.to_owned(),
        }
    }
}

/// What an element in this section names itself as.
pub(crate) fn of_element(node: &Node, section: &str) -> Option<(Sort, String)> {
    let sort = match (section, node.name.as_str()) {
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
    Some((sort, name.to_owned()))
}

/// The name of an asset, or that of its file.
pub(crate) fn asset_name(node: &Node) -> String {
    let own = node.attribute("name").filter(|name| !name.is_empty());
    own.or_else(|| node.attribute("file").map(crate::mesh::stem)).unwrap_or_default().to_owned()
}

/// All that an element outside bodies names, with what is in it.
pub(crate) fn references(tree: &Tree, element: Id) -> Vec<(Sort, String)> {
    let mut found = Vec::new();
    let mut pending = vec![element];
    while let Some(id) = pending.pop() {
        let node = &tree.nodes[id];
        for own in REFERENCES.iter().map(|(own, _)| *own).chain(BY_SORT.map(|(own, _)| own)) {
            let name = node.attribute(own).filter(|name| !name.is_empty());
            found.extend(name.and_then(|name| Some((sort_of(node, own)?, name.to_owned()))));
        }
        pending.extend(&node.children);
    }
    found
}

/// What is in a part of the bodies, itself included, as replicates name it.
pub(crate) fn names_in(tree: &Tree, part: Id) -> Vec<(Sort, String)> {
    let mut found = Vec::new();
    let mut pending = vec![(part, String::new())];
    while let Some((id, suffix)) = pending.pop() {
        let node = &tree.nodes[id];
        found.extend(of_element(node, "worldbody").map(|(sort, name)| (sort, format!("{name}{suffix}"))));
        let replicate = Some(node).filter(|node| node.name == "replicate").and_then(Suffixes::of);
        let count = replicate.as_ref().map_or(1, |replicate| replicate.count);
        if (found.len() + pending.len()).saturating_add(count.saturating_mul(node.children.len())) > MOST {
            return found; // told where the bodies are made
        }
        for copy in 0..count {
            let own = replicate.as_ref().map_or_else(String::new, |replicate| replicate.suffix(copy));
            let suffix = format!("{own}{suffix}");
            pending.extend(node.children.iter().map(|&child| (child, suffix.clone())));
        }
    }
    found
}

/// What a `<replicate>` adds to the names in each of its copies.
pub(crate) struct Suffixes {
    pub(crate) count: usize,
    separator: String,
}

impl Suffixes {
    /// `None` where its count is none that is read.
    pub(crate) fn of(node: &Node) -> Option<Self> {
        let count: f64 = node.attribute("count")?.trim().parse().ok()?;
        if !(0.0..=1e6).contains(&count) || count.fract() != 0.0 {
            return None;
        }
        let separator = node.attribute("sep").unwrap_or_default().to_owned();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked just now
        Some(Self { count: count as usize, separator })
    }

    /// The separator and the copy's number, with as many digits as the count has.
    pub(crate) fn suffix(&self, copy: usize) -> String {
        let digits = self.count.to_string().len();
        format!("{}{copy:0digits$}", self.separator)
    }
}

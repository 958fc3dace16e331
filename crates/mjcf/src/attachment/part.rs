//! The part of a model that an `<attach>` copies.

use std::collections::HashMap;
use std::rc::Rc;

use super::{AttachedPart, Expansion, Parts};
use crate::MjcfError;
use crate::renaming::{ObjectKind, of_element};
use crate::tree::{Id, Tree};

impl Expansion<'_> {
    /// Reads the attributes of an `<attach>`; `None`, with an error, if they are invalid.
    pub(super) fn read_part(&mut self, id: Id) -> Option<AttachedPart> {
        let attribute = |name| self.tree().nodes[id].attribute(name).map(str::to_owned);
        let [model, body, frame, prefix] = ["model", "body", "frame", "prefix"].map(attribute);
        let Some(prefix) = prefix else {
            let (line, place) = self.place(id);
            let (attribute, example) = ("prefix", "PREFIX");
            self.source.errors.push(MjcfError::MissingAttribute { line, place, attribute, example });
            return None;
        };
        let part = match (body, frame) {
            (Some(_), Some(_)) => {
                self.refuse(id, "both body and frame are given; keep one of them");
                return None;
            }
            (Some(name), None) => Some(("body", name)),
            (None, Some(name)) => Some(("frame", name)),
            (None, None) => None,
        };
        let model = match &model {
            Some(name) => {
                let root = self.assets.get(name).copied();
                if root.is_none() {
                    self.refuse_unknown_name(id, "model in <asset>", name);
                }
                root?
            }
            None if part.is_none() => {
                self.refuse(id, "give it a model, or a body or a frame of this file");
                return None;
            }
            None => self.root,
        };
        let (elements, childclass) = match part {
            Some((kind, name)) => {
                let (found, childclass) = self.find_part(id, model, (kind, name), &prefix)?;
                (vec![found], childclass)
            }
            None => (self.tree().in_sections_of(model, "worldbody"), None),
        };
        Some(AttachedPart { model, prefix, elements, childclass })
    }

    /// The body or the frame that an `<attach>` names, with the `childclass` that applies to it; `None`,
    /// with an error, if it cannot be copied.
    fn find_part(
        &mut self,
        id: Id,
        model: Id,
        key: (ObjectKind, String),
        prefix: &str,
    ) -> Option<(Id, Option<Rc<str>>)> {
        let found = if model == self.root {
            self.parts.get(&key).cloned()
        } else {
            let tree = &self.source.tree;
            let parts = self.parts_of.entry(model).or_insert_with(|| parts_of(tree, model));
            parts.get(&key).cloned()
        };
        let (kind, name) = key;
        let Some((found, childclass)) = found else {
            let what = if kind == "body" { "body to be attached" } else { "frame to be attached" };
            self.refuse_unknown_name(id, what, &name);
            return None;
        };
        if self.ancestors.contains(&found) {
            self.refuse(id, format!("it attaches the {kind} {name:?} that contains it"));
            return None;
        }
        if self.names.contains(&(kind, format!("{prefix}{name}"))) {
            self.refuse(id, format!("the {kind} {prefix}{name} already exists; use another prefix"));
            return None;
        }
        Some((found, childclass))
    }
}

/// All bodies and frames of a model by name, with the `childclass` that applies to each.
fn parts_of(tree: &Tree, root: Id) -> Parts {
    let mut parts = HashMap::new();
    let mut pending: Vec<(Id, Option<Rc<str>>)> =
        tree.children(root, "worldbody").map(|section| (section, None)).collect();
    while let Some((id, class)) = pending.pop() {
        let node = &tree.nodes[id];
        if let Some((kind, name)) =
            of_element(node, "worldbody").filter(|(kind, _)| matches!(*kind, "body" | "frame"))
        {
            parts.insert((kind, name), (id, class.clone()));
        }
        let class = node.attribute("childclass").map(Rc::from).or(class);
        pending.extend(node.children.iter().map(|&child| (child, class.clone())));
    }
    parts
}

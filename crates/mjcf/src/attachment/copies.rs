//! Copies elements under new names, within the limits that all steps of reading share.

use std::collections::{HashMap, HashSet};

use robot_dynamics_xml::Resource;

use super::{Expansion, NAME_SIZE};
use crate::renaming::{OUTER_SECTIONS, ObjectKind, Renaming, Suffixes, asset_name, of_element, references};
use crate::tree::{Id, Node};

impl Expansion<'_> {
    /// Copies the elements of a section whose references exist into a new section after the others.
    pub(super) fn copy_outer(
        &mut self,
        section: &'static str,
        elements: &[Id],
        renaming: &Renaming<'_>,
    ) -> HashMap<Id, Id> {
        let (mut copies, mut own_copy) = (Vec::new(), HashMap::new());
        if !self.source.charge(self.root, Resource::Steps, elements.len()) {
            return own_copy;
        }
        for &element in elements {
            let tree = &self.source.tree;
            if section == "contact" && !matches!(tree.nodes[element].name.as_str(), "exclude" | "pair") {
                continue;
            }
            let (own, others): (Vec<_>, Vec<_>) = references(tree, element)
                .into_iter()
                .filter(|name| *name != ("body", "world".to_owned()))
                .partition(|(kind, name)| self.names.contains(&(*kind, renaming.name(name))));
            // For a tendon or a pair one attached name suffices; the other names refer to elements of this
            // model.
            let is_shared = matches!(section, "tendon" | "contact");
            let is_here = |name| is_shared && self.names.contains(name);
            if section != "keyframe" && (own.is_empty() || !others.iter().all(is_here)) {
                if renaming.classes.is_some() {
                    let why = "it refers to an element that is not attached: omitted, as in MuJoCo";
                    self.source.tree.omissions.push((element, why));
                }
                continue;
            }
            let renaming = Renaming { kept: others.into_iter().collect(), ..*renaming };
            let Some(copy) = self.copy_whole(element, &renaming) else { break };
            if section == "sensor" {
                // Sensors have no class.
                self.source.tree.nodes[copy].attributes.retain(|(name, _)| name != "class");
            }
            if let Some(name) = of_element(&self.source.tree.nodes[copy], section) {
                self.enter(copy, name);
            }
            copies.push(copy);
            own_copy.insert(element, copy);
        }
        if !copies.is_empty() {
            let node =
                Node { name: section.into(), children: copies, ..self.tree().nodes[self.root].empty_copy() };
            let section = self.source.tree.push(node);
            self.source.tree.nodes[self.root].children.push(section);
        }
        own_copy
    }

    /// Copies each element outside bodies that refers to a replicated element, once for each replica.
    pub(super) fn replicate(&mut self, id: Id) {
        let inside = self.replicate_names.pop().unwrap_or_default();
        let Some(suffixes) = Suffixes::of(&self.tree().nodes[id]) else { return };
        let length = suffixes.suffix(0).len() + NAME_SIZE;
        let names: usize = inside.iter().map(|(_, name)| name.len() + length).sum();
        let characters = suffixes.count.saturating_mul(names + length);
        if inside.is_empty() || !self.source.charge(id, Resource::Characters, characters) {
            return;
        }
        let suffixes: Vec<String> = (0..suffixes.count).map(|copy| suffixes.suffix(copy)).collect();
        for name in &inside {
            self.names.remove(name);
            self.parts.remove(name);
        }
        for suffix in &suffixes {
            for (kind, name) in &inside {
                self.enter(id, (*kind, format!("{name}{suffix}")));
            }
        }
        let mut inside: HashSet<(ObjectKind, String)> = inside.into_iter().collect();
        for section in OUTER_SECTIONS {
            let elements = self.tree().in_sections_of(self.root, section);
            let steps = elements.len() + self.tree().origins.len();
            if !self.source.charge(id, Resource::Steps, steps) {
                return;
            }
            let tree = &self.source.tree;
            let is_over = |element: Id| references(tree, element).iter().any(|name| inside.contains(name));
            let moved: Vec<Id> = elements.into_iter().filter(|&element| is_over(element)).collect();
            if moved.is_empty() {
                continue;
            }
            // Elements that refer to a copied tendon or actuator are copied, too.
            inside.extend(moved.iter().filter_map(|&element| of_element(&tree.nodes[element], section)));
            self.source.tree.has_copies = true;
            let gone: HashSet<Id> = moved.iter().copied().collect();
            for section in self.tree().children(self.root, section).collect::<Vec<_>>() {
                self.source.tree.nodes[section].children.retain(|child| !gone.contains(child));
            }
            for (at, suffix) in suffixes.iter().enumerate() {
                let renaming = Renaming { suffix, ..Renaming::default() };
                let copies = self.copy_outer(section, &moved, &renaming);
                // The keyframes of an attached model hold for the first copies.
                for origin in self.source.tree.origins.values_mut().filter(|_| at == 0) {
                    for own in
                        origin.actuators.iter_mut().filter(|own| own.is_some_and(|own| gone.contains(&own)))
                    {
                        *own = own.and_then(|own| copies.get(&own).copied());
                    }
                }
            }
        }
    }

    /// Copies an element outside bodies. An element of another model keeps the classes of that model.
    pub(super) fn copy_whole(&mut self, from: Id, renaming: &Renaming<'_>) -> Option<Id> {
        let copy = self.copy(from, renaming, &mut HashMap::new())?;
        let node = &mut self.source.tree.nodes[copy];
        if renaming.classes.is_some() {
            let has_no_class = ["key", "exclude", "hfield", "texture", "skin"].contains(&node.name.as_str());
            if node.attribute("class").is_none() && !has_no_class {
                node.attributes.push(("class".into(), renaming.class("main")));
            }
            if matches!(node.name.as_str(), "mesh" | "hfield") && node.attribute("name").is_none() {
                let name = renaming.name(&asset_name(node));
                node.attributes.push(("name".into(), name));
            }
        }
        Some(copy)
    }

    /// Copies an element and its descendants under new names; `None` above the limit.
    pub(super) fn copy(
        &mut self,
        from: Id,
        renaming: &Renaming<'_>,
        copies: &mut HashMap<Id, Id>,
    ) -> Option<Id> {
        let mut pending = vec![from];
        while let Some(old) = pending.pop() {
            let node = &self.tree().nodes[old];
            let characters: usize = node.attributes.iter().map(|(_, text)| renaming.length(text)).sum();
            if !self.source.charge(old, Resource::Elements, 1)
                || !self.source.charge(old, Resource::Characters, characters)
            {
                return None;
            }
            let node = &self.tree().nodes[old];
            let attributes = node.attributes.iter();
            let attributes =
                attributes.map(|(name, text)| (name.clone(), renaming.attribute(node, name, text)));
            let copy = Node { attributes: attributes.collect(), children: Vec::new(), ..node.empty_copy() };
            pending.extend(&node.children);
            let copy = self.source.tree.push(copy);
            copies.insert(old, copy);
        }
        let mut pending = vec![from];
        while let Some(old) = pending.pop() {
            let children = self.tree().nodes[old].children.clone();
            let own = children.iter().map(|child| copies[child]).collect();
            self.source.tree.nodes[copies[&old]].children = own;
            pending.extend(children);
        }
        copies.get(&from).copied()
    }
}

//! Reads `<default>`: the default attributes of each class.

use std::collections::HashMap;
use std::rc::Rc;

use robot_dynamics_xml::excerpt;

use crate::MjcfError;
use crate::classes::{Class, MAIN, default_kind};
use crate::reader::Reader;
use crate::tree::{Id, Tree};

/// The largest number of default elements that apply to one element. Every attribute is looked up in each of
/// them.
const DEFAULTS_LIMIT: usize = 100;

impl Reader<'_> {
    /// Reads all `<default>` sections.
    pub(crate) fn read_classes(&mut self) {
        let tree = self.tree;
        self.classes.names.insert("main".into(), MAIN);
        self.classes.chains.push(HashMap::new());
        for section in tree.children(Tree::ROOT, "default") {
            let node = &tree.nodes[section];
            let main = if node.model == 0 { MAIN } else { self.attached_main(section) };
            let other =
                node.attribute("class").filter(|name| !["", "main"].contains(name) && node.model == 0);
            if let Some(name) = other {
                let element = self.raw_element(section);
                self.warn(
                    &element,
                    format!("the outermost default class is `main`: the name {:?} is ignored", excerpt(name)),
                );
            }
            self.fill_class(section, main);
            // An outer class is complete before nested classes inherit from it.
            let mut pending: Vec<(Id, Class)> = Vec::new();
            self.nested(section, main, &mut pending);
            while let Some((node, parent)) = pending.pop() {
                if let Some(class) = self.add_class(node, parent) {
                    self.fill_class(node, class);
                    self.nested(node, class, &mut pending);
                }
            }
        }
    }

    /// The outermost class of an attached model, which inherits from no class.
    fn attached_main(&mut self, section: Id) -> Class {
        let name = self.tree.nodes[section].attribute("class").unwrap_or_default().to_owned();
        if let Some(known) = self.classes.find(&name) {
            return known;
        }
        let class = self.classes.chains.len();
        self.classes.names.insert(name, class);
        self.classes.chains.push(HashMap::new());
        class
    }

    fn nested(&self, section: Id, class: Class, pending: &mut Vec<(Id, Class)>) {
        let nested: Vec<Id> = self.tree.children(section, "default").collect();
        pending.extend(nested.into_iter().rev().map(|node| (node, class)));
    }

    /// Adds a class that inherits from its parent.
    fn add_class(&mut self, node: Id, parent: Class) -> Option<Class> {
        let element = self.raw_element(node);
        let (line, place) = (element.line, element.place.clone());
        let Some(name) = self.tree.nodes[node].attribute("class").filter(|name| !name.is_empty()) else {
            self.errors.push(MjcfError::MissingAttribute {
                line,
                place,
                attribute: "class",
                example: "NAME",
            });
            return None;
        };
        let class = self.classes.chains.len();
        if self.classes.names.insert(name.to_owned(), class).is_some() {
            self.refuse(&element, "a default class of this name already exists; give each its own name");
        }
        self.classes.chains.push(self.classes.chains[parent].clone());
        Some(class)
    }

    /// Adds the elements of a `<default>` to its class, at most one of each kind.
    fn fill_class(&mut self, section: Id, class: Class) {
        let mut kinds: Vec<&'static str> = Vec::new();
        for &child in &self.tree.nodes[section].children {
            let name = self.tree.nodes[child].name.as_str();
            let Some(kind) = default_kind(name) else { continue };
            // Several actuator elements set the same numbers, one after the other.
            if kinds.contains(&kind) && kind != "actuator" {
                let element = self.raw_element(child);
                self.warn(
                    &element,
                    "a second default of this kind in the class; the first counts; delete one of them",
                );
                continue;
            }
            kinds.push(kind);
            let chain = self.classes.chains[class].entry(kind).or_insert_with(|| Rc::from([]));
            if chain.len() >= DEFAULTS_LIMIT {
                let (line, place) = (self.tree.nodes[child].line, self.place(child));
                self.errors.push(MjcfError::TooMany {
                    line,
                    place,
                    what: "defaults of one element",
                    limit: DEFAULTS_LIMIT,
                });
                return;
            }
            *chain = chain.iter().copied().chain([child]).collect();
        }
    }
}

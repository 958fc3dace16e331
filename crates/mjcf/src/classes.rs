//! `<default>`: what an element of a class takes where it leaves something out.

use std::collections::HashMap;
use std::rc::Rc;

use robot_xml::excerpt;

use crate::MjcfError;
use crate::reader::Reader;
use crate::tree::{Id, Tree};

/// Which class.
pub(crate) type Class = usize;

/// The outermost class, `main`, which everything takes after.
pub(crate) const MAIN: Class = 0;

/// The most default elements that may stand behind one element: each is looked into for each attribute.
const MOST: usize = 100;

/// Elements of actuators; a class has one actuator, which each of them writes to.
pub(crate) const ACTUATORS: [&str; 14] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
    "actuator",
];

/// All classes with their elements.
#[derive(Default)]
pub(crate) struct Classes {
    names: HashMap<String, Class>,
    /// For each class and sort of element: the default elements from the outermost class to this one.
    chains: Vec<HashMap<&'static str, Rc<[Id]>>>,
}

/// The sort of default that an element takes: all actuators share one, and so do tendons and equalities.
fn sort(name: &str) -> Option<&'static str> {
    match name {
        "joint" => Some("joint"),
        "geom" => Some("geom"),
        "site" => Some("site"),
        "mesh" => Some("mesh"),
        "material" => Some("material"),
        "pair" => Some("pair"),
        "equality" | "connect" | "weld" | "flex" => Some("equality"),
        "tendon" | "fixed" | "spatial" => Some("tendon"),
        name if ACTUATORS.contains(&name) => Some("actuator"),
        _ => None,
    }
}

impl Classes {
    /// The class of this name.
    pub(crate) fn named(&self, name: &str) -> Option<Class> {
        self.names.get(name).copied()
    }

    /// The default elements behind an element of this name, the outermost class first.
    pub(crate) fn defaults(&self, class: Class, element: &str) -> Rc<[Id]> {
        sort(element).map_or_else(|| Rc::from([]), |sort| self.of_sort(class, sort))
    }

    /// The default elements of a sort.
    pub(crate) fn of_sort(&self, class: Class, sort: &str) -> Rc<[Id]> {
        self.chains.get(class).and_then(|chain| chain.get(sort)).cloned().unwrap_or_else(|| Rc::from([]))
    }
}

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
                let element = self.plain(section);
                self.as_written(
                    &element,
                    format!(
                        "the outermost default class is `main`: {:?} is not taken as its name",
                        excerpt(name)
                    ),
                );
            }
            self.fill_class(section, main);
            // Outer classes are complete before what is nested in them takes after them.
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

    /// The outermost class of an attached model, which takes after no other.
    fn attached_main(&mut self, section: Id) -> Class {
        let name = self.tree.nodes[section].attribute("class").unwrap_or_default().to_owned();
        if let Some(known) = self.classes.named(&name) {
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

    /// A class that takes after its parent.
    fn add_class(&mut self, node: Id, parent: Class) -> Option<Class> {
        let element = self.plain(node);
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
            self.misplaced(&element, "there is a default class of this name already; give each its own name");
        }
        self.classes.chains.push(self.classes.chains[parent].clone());
        Some(class)
    }

    /// Adds a `<default>`'s own elements to its class: at most one of a sort, as the format has it.
    fn fill_class(&mut self, section: Id, class: Class) {
        let mut filled: Vec<&'static str> = Vec::new();
        for &child in &self.tree.nodes[section].children {
            let name = self.tree.nodes[child].name.as_str();
            let Some(sort) = sort(name) else { continue };
            // Actuators of several kinds fill one set of numbers, one after the other.
            if filled.contains(&sort) && sort != "actuator" {
                let element = self.plain(child);
                self.as_written(&element, "a second one in this class; the first counts; delete one of them");
                continue;
            }
            filled.push(sort);
            let chain = self.classes.chains[class].entry(sort).or_insert_with(|| Rc::from([]));
            if chain.len() >= MOST {
                let (line, place) = (self.tree.nodes[child].line, self.place(child));
                self.errors.push(MjcfError::TooMany {
                    line,
                    place,
                    what: "defaults of one element",
                    limit: MOST,
                });
                return;
            }
            *chain = chain.iter().copied().chain([child]).collect();
        }
    }
}

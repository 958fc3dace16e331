//! Reads `<default>`: the default attributes of each class.

use std::collections::HashMap;
use std::rc::Rc;

use robot_dynamics_xml::excerpt;

use crate::MjcfError;
use crate::reader::Reader;
use crate::tree::{Id, Tree};

/// The index of a class.
pub(crate) type Class = usize;

/// The outermost class, `main`, from which all classes of the main file inherit.
pub(crate) const MAIN: Class = 0;

/// The largest number of default elements that apply to one element. Every attribute is looked up in each of
/// them.
const DEFAULTS_LIMIT: usize = 100;

/// The elements of actuators. They all set the one default actuator of a class.
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

/// All classes with their default elements.
#[derive(Default)]
pub(crate) struct Classes {
    names: HashMap<String, Class>,
    /// For each class and kind of element the default elements, from the outermost class to this one.
    chains: Vec<HashMap<&'static str, Rc<[Id]>>>,
}

/// The kind of default that applies to an element. All actuators share one kind, as do tendons and
/// equalities.
fn default_kind(name: &str) -> Option<&'static str> {
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
    pub(crate) fn find(&self, name: &str) -> Option<Class> {
        self.names.get(name).copied()
    }

    /// The default elements that apply to an element of this name, the outermost class first.
    pub(crate) fn defaults(&self, class: Class, element: &str) -> Rc<[Id]> {
        default_kind(element).map_or_else(|| Rc::from([]), |kind| self.of_kind(class, kind))
    }

    /// The default elements of a kind.
    pub(crate) fn of_kind(&self, class: Class, kind: &str) -> Rc<[Id]> {
        self.chains.get(class).and_then(|chain| chain.get(kind)).cloned().unwrap_or_else(|| Rc::from([]))
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

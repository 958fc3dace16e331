//! The default attributes of each class.

use std::collections::HashMap;
use std::rc::Rc;

use crate::tree::Id;

/// The index of a class.
pub(crate) type Class = usize;

/// The outermost class, `main`, from which all classes of the main file inherit.
pub(crate) const MAIN: Class = 0;

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
    pub(crate) names: HashMap<String, Class>,
    /// For each class and kind of element the default elements, from the outermost class to this one.
    pub(crate) chains: Vec<HashMap<&'static str, Rc<[Id]>>>,
}

/// The kind of default that applies to an element. All actuators share one kind, as do tendons and
/// equalities.
pub(crate) fn default_kind(name: &str) -> Option<&'static str> {
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

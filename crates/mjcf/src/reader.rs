//! The state of reading one file: options, settings, report and errors.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{Disposition, Finding, LoadReport, Severity};
use robot_dynamics_xml::{Budget, ExceededLimit, Resource, excerpt};

use crate::assets::Meshes;
use crate::classes::{Class, Classes};
use crate::element::Element;
use crate::settings::Compiler;
use crate::tree::{Id, Node, Tree, in_file_place};
use crate::{LoadOptions, MjcfError};

/// Reads the elements of one file and collects findings and errors.
pub(crate) struct Reader<'a> {
    pub(crate) tree: &'a Tree,
    /// The path of the main file; `None` for a text and for files in memory.
    pub(crate) main: Option<&'a Path>,
    pub(crate) classes: Classes,
    /// The settings of each model, the main file first.
    pub(crate) compilers: Vec<Compiler>,
    pub(crate) meshes: Meshes,
    /// The limits that all steps of reading share.
    pub(crate) budget: Budget,
    /// The index of each body by name; filled on first use.
    pub(crate) body_indices: HashMap<String, usize>,
    /// The `<material>` elements by name.
    pub(crate) materials: HashMap<String, Id>,
    /// The `<hfield>` elements by name.
    pub(crate) height_fields: HashMap<String, Id>,
    /// The beginnings of the names of bodies, joints and other parts of deformable bodies.
    deformable_prefixes: Vec<String>,
    pub(crate) options: LoadOptions,
    /// The Euler angles of all frames.
    pub(crate) angles: Vec<WrittenAngles>,
    pub(crate) report: LoadReport,
    /// All errors so far. A file with an error is refused.
    pub(crate) errors: Vec<MjcfError>,
    /// Warnings of a strict reading, which refuses the file for them. Reading continues with the values as
    /// written.
    pub(crate) refused_warnings: Vec<MjcfError>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(tree: &'a Tree, options: LoadOptions) -> Self {
        Self {
            tree,
            main: None,
            classes: Classes::default(),
            compilers: Vec::new(),
            meshes: Meshes::default(),
            budget: Budget::default(),
            body_indices: HashMap::new(),
            materials: HashMap::new(),
            height_fields: HashMap::new(),
            deformable_prefixes: tree.nodes.iter().filter_map(deformable_prefix).collect(),
            options,
            angles: Vec::new(),
            report: LoadReport::default(),
            errors: Vec::new(),
            refused_warnings: Vec::new(),
        }
    }

    /// The settings of the model that the element belongs to.
    pub(crate) fn compiler(&self, element: &Element) -> &Compiler {
        &self.compilers[self.tree.nodes[element.node].model]
    }

    /// An element without defaults.
    pub(crate) fn raw_element(&self, node: Id) -> Element {
        Element { node, defaults: Rc::from([]), line: self.tree.nodes[node].line, place: self.place(node) }
    }

    /// An element with the defaults of the class that it names, or of `class`.
    pub(crate) fn element(&mut self, node: Id, class: Class) -> Element {
        let mut element = self.raw_element(node);
        let class = match self.tree.nodes[node].attribute("class") {
            Some(name) => self.class_named(name, &element).unwrap_or(class),
            None => class,
        };
        element.defaults = self.classes.defaults(class, &self.tree.nodes[node].name);
        element
    }

    /// The class of this name, which must exist.
    pub(crate) fn class_named(&mut self, name: &str, element: &Element) -> Option<Class> {
        let class = self.classes.find(name);
        if class.is_none() {
            self.refuse_unknown_name(element, "default class", name);
        }
        class
    }

    /// The place of an element, as in `joint "elbow"`, after the name of the file if it is an included one.
    pub(crate) fn place(&self, node: Id) -> String {
        let node = &self.tree.nodes[node];
        let place = match node.attribute("name").or_else(|| node.attribute("class")) {
            Some(name) => format!("{} {:?}", excerpt(&node.name), excerpt(name)),
            None => excerpt(&node.name),
        };
        in_file_place(&self.tree.files[node.file], &place)
    }

    pub(crate) fn report_read(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::Read, message.into());
    }

    pub(crate) fn report_default(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::Defaulted, message.into());
    }

    /// Reports a suspicious value that is taken as written.
    pub(crate) fn warn(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::AsWritten, message.into());
    }

    /// Reports a part that is not in the model although it affects, or may affect, the motion.
    pub(crate) fn report_ignored_physics(&mut self, element: &Element, message: impl Into<String>) {
        self.push(
            element.line,
            element.place.clone(),
            Disposition::Ignored { physics: true },
            message.into(),
        );
    }

    /// Lists a reference to an element that does not exist. A reference to a part of a deformable body is
    /// ignored with its element, as the body is.
    pub(crate) fn refuse_unknown_name(&mut self, element: &Element, what: &'static str, name: &str) {
        if self.deformable_prefixes.iter().any(|prefix| is_part_of_deformable(name, prefix)) {
            let name = excerpt(name);
            self.report_ignored_physics(
                element,
                format!("the {what} {name:?} of a deformable body is not in the model"),
            );
            return;
        }
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::UnknownName { line, place, what, name: excerpt(name) });
    }

    /// Charges the budget on behalf of this element; `false`, with an error, above the limit.
    pub(crate) fn charge(&mut self, node: Id, resource: Resource, count: usize) -> bool {
        let is_first = !self.budget.is_exceeded();
        let Err(ExceededLimit { what, limit }) = self.budget.charge(resource, count) else { return true };
        if is_first {
            let (line, place) = (self.tree.nodes[node].line, self.place(node));
            self.errors.push(MjcfError::TooMany { line, place, what, limit });
        }
        false
    }

    /// Lists an error; reading continues.
    pub(crate) fn refuse(&mut self, element: &Element, reason: impl Into<String>) {
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::Misplaced { line, place, reason: reason.into() });
    }

    /// Adds a finding. In a strict reading a warning becomes an error.
    pub(crate) fn push(&mut self, line: usize, place: String, disposition: Disposition, message: String) {
        if self.options.strict && disposition.severity() == Severity::Warning {
            self.refused_warnings.push(MjcfError::Strict { line, place, message });
        } else {
            self.report.add(Finding::new(line, place, disposition, message));
        }
    }
}

/// The beginning of the names of the parts that this element would make, if it is a deformable body.
fn deformable_prefix(node: &Node) -> Option<String> {
    match node.name.as_str() {
        "flexcomp" => Some(format!("{}_", node.attribute("name")?)),
        "composite" => Some(node.attribute("prefix").unwrap_or_default().to_owned()),
        _ => None,
    }
}

/// Whether MuJoCo would give this name to a part of a deformable body: a number after the prefix, or, for
/// `composite`, a letter for the kind and a place, as in `B_first` or `J12`.
fn is_part_of_deformable(name: &str, prefix: &str) -> bool {
    let Some(rest) = name.strip_prefix(prefix) else { return false };
    let place = rest.strip_prefix(['B', 'G', 'J', 'S', 'T']).unwrap_or(rest);
    let is_number = !place.is_empty() && place.bytes().all(|byte| byte.is_ascii_digit());
    is_number || (place.len() < rest.len() && matches!(place, "_first" | "_last"))
}

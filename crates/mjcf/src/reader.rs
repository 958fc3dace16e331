//! The walk through a file: elements in, findings out.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use multibody::plausibility::WrittenAngles;
use multibody::{Finding, LoadReport, Severity, Treatment};
use robot_xml::excerpt;

use crate::classes::{Class, Classes};
use crate::compiler::Compiler;
use crate::mesh::Meshes;
use crate::source::in_file_place;
use crate::tree::{Id, Tree};
use crate::{MjcfError, Options};

/// What the walk carries along.
pub(crate) struct Reader<'a> {
    pub(crate) tree: &'a Tree,
    /// The main file on the disk; `None` for a text and for files in memory.
    pub(crate) main: Option<&'a Path>,
    pub(crate) classes: Classes,
    /// Of each model of the tree, the main file's first.
    pub(crate) compilers: Vec<Compiler>,
    pub(crate) meshes: Meshes,
    /// Elements that replicates have made.
    pub(crate) copied: usize,
    /// Which body has which name; filled where it is first asked for.
    pub(crate) body_indices: HashMap<String, usize>,
    /// By name.
    pub(crate) materials: HashMap<String, Id>,
    pub(crate) options: Options,
    /// The Euler angles of all frames.
    pub(crate) angles: Vec<WrittenAngles>,
    pub(crate) report: LoadReport,
    /// Every error so far; a file with one is refused.
    pub(crate) errors: Vec<MjcfError>,
    /// Warnings that a strict reading refuses; the walk takes them as written all the same.
    pub(crate) refused_warnings: Vec<MjcfError>,
}

/// An element with the defaults that stand behind it.
#[derive(Clone)]
pub(crate) struct Element {
    pub(crate) node: Id,
    /// The default elements of its class, from the outermost class to the innermost.
    pub(crate) defaults: Rc<[Id]>,
    /// Of the element itself.
    pub(crate) line: usize,
    /// As in `joint "elbow"`.
    pub(crate) place: String,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(tree: &'a Tree, options: Options) -> Self {
        Self {
            tree,
            main: None,
            classes: Classes::default(),
            compilers: Vec::new(),
            meshes: Meshes::default(),
            copied: 0,
            body_indices: HashMap::new(),
            materials: HashMap::new(),
            options,
            angles: Vec::new(),
            report: LoadReport::default(),
            errors: Vec::new(),
            refused_warnings: Vec::new(),
        }
    }

    /// How the file means it that the element is from.
    pub(crate) fn compiler(&self, element: &Element) -> &Compiler {
        &self.compilers[self.tree.nodes[element.node].model]
    }

    /// An element that no defaults stand behind.
    pub(crate) fn plain(&self, node: Id) -> Element {
        Element { node, defaults: Rc::from([]), line: self.tree.nodes[node].line, place: self.place(node) }
    }

    /// An element that takes what it leaves out from the class it names, or else from `class`.
    pub(crate) fn element(&mut self, node: Id, class: Class) -> Element {
        let mut element = self.plain(node);
        let class = match self.tree.nodes[node].attribute("class") {
            Some(name) => self.class_named(name, &element).unwrap_or(class),
            None => class,
        };
        element.defaults = self.classes.defaults(class, &self.tree.nodes[node].name);
        element
    }

    /// The class of this name, which must exist.
    pub(crate) fn class_named(&mut self, name: &str, element: &Element) -> Option<Class> {
        let class = self.classes.named(name);
        if class.is_none() {
            self.unknown_name(element, "default class", name);
        }
        class
    }

    /// An element placed as in `joint "elbow"`, behind the name of the file if it is an included one.
    pub(crate) fn place(&self, node: Id) -> String {
        let node = &self.tree.nodes[node];
        let place = match node.attribute("name").or_else(|| node.attribute("class")) {
            Some(name) => format!("{} {:?}", excerpt(&node.name), excerpt(name)),
            None => excerpt(&node.name),
        };
        in_file_place(&self.tree.files[node.file], &place)
    }

    pub(crate) fn read(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Read, message.into());
    }

    pub(crate) fn defaulted(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Defaulted, message.into());
    }

    /// Something suspicious that is taken as the file has it.
    pub(crate) fn as_written(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::AsWritten, message.into());
    }

    /// Something that stays out of the model though it changes, or may change, how the robot moves.
    pub(crate) fn ignored_physics(&mut self, element: &Element, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Ignored { physics: true }, message.into());
    }

    /// Lists a name of something that is not in the file.
    pub(crate) fn unknown_name(&mut self, element: &Element, what: &'static str, name: &str) {
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::UnknownName { line, place, what, name: excerpt(name) });
    }

    /// Lists an error; the walk goes on.
    pub(crate) fn misplaced(&mut self, element: &Element, reason: impl Into<String>) {
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::Misplaced { line, place, reason: reason.into() });
    }

    /// Adds a finding; strict reading refuses a warning.
    pub(crate) fn push(&mut self, line: usize, place: String, treatment: Treatment, message: String) {
        if self.options.strict && treatment.severity() == Severity::Warning {
            self.refused_warnings.push(MjcfError::Strict { line, place, message });
        } else {
            self.report.add(Finding::new(line, place, treatment, message));
        }
    }
}

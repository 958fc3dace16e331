//! The state of reading one file: options, report and errors.

use std::collections::HashSet;

use robot_dynamics_description::{Disposition, Finding, LoadReport, Severity};
use robot_dynamics_xml::roxmltree::{Node, NodeId};
use robot_dynamics_xml::{Lines, excerpt};

use crate::element::Element;
use crate::{LoadOptions, UrdfError};

/// Reads the elements of one file and collects findings and errors.
pub(crate) struct Reader<'a> {
    pub(crate) options: LoadOptions,
    pub(crate) report: LoadReport,
    /// All errors so far. A file with an error is refused.
    pub(crate) errors: Vec<UrdfError>,
    /// Warnings of a strict reading, which refuses the file for them. Reading continues with the values as
    /// written.
    pub(crate) refused_warnings: Vec<UrdfError>,
    lines: Lines,
    /// Foreign elements that are read.
    pub(crate) understood: HashSet<NodeId>,
    /// The namespace of `<robot>`. Elements of other namespaces are foreign.
    namespace: Option<&'a str>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &str, root: Node<'a, 'a>, options: LoadOptions) -> Self {
        Self {
            options,
            report: LoadReport::default(),
            errors: Vec::new(),
            refused_warnings: Vec::new(),
            lines: Lines::of(text),
            understood: HashSet::new(),
            namespace: root.tag_name().namespace(),
        }
    }

    pub(crate) fn line(&self, node: Node<'a, 'a>) -> usize {
        self.line_of_byte(node.range().start)
    }

    pub(crate) fn line_of_byte(&self, byte: usize) -> usize {
        self.lines.line(byte)
    }

    /// Whether the node is a URDF element of this name.
    pub(crate) fn is(&self, node: Node<'a, 'a>, name: &str) -> bool {
        self.is_own(node) && node.tag_name().name() == name
    }

    /// Whether the node is an element in the namespace of `<robot>`.
    pub(crate) fn is_own(&self, node: Node<'a, 'a>) -> bool {
        node.is_element() && node.tag_name().namespace() == self.namespace
    }

    /// A link or a joint with its place, as in `link "hand"`.
    pub(crate) fn named_element(&self, node: Node<'a, 'a>, kind: &str) -> Element<'a> {
        let place = match node.attribute("name") {
            Some(name) => format!("{kind} {:?}", excerpt(name)),
            None => kind.to_owned(),
        };
        Element { node, line: self.line(node), place }
    }

    /// The first child of this name. Further ones are reported by a warning.
    pub(crate) fn child(&mut self, parent: &Element<'a>, name: &str) -> Option<Element<'a>> {
        let mut found: Option<Element<'a>> = None;
        for node in parent.node.children().filter(Node::is_element) {
            if !self.is(node, name) {
                continue;
            }
            let line = self.line(node);
            let place = format!("{}/{name}", parent.place);
            match &found {
                Some(first) => {
                    let message = format!(
                        "a second <{name}>; the first, on line {}, counts; delete one of them",
                        first.line
                    );
                    self.push(line, place, Disposition::AsWritten, message);
                }
                None => found = Some(Element { node, line, place }),
            }
        }
        found
    }

    /// The required child of this name.
    pub(crate) fn required_child(
        &mut self,
        parent: &Element<'a>,
        name: &'static str,
        advice: &'static str,
    ) -> Option<Element<'a>> {
        let found = self.child(parent, name);
        if found.is_none() {
            self.refuse(UrdfError::MissingElement {
                line: parent.line,
                place: parent.place.clone(),
                element: name,
                advice,
            });
        }
        found
    }

    /// Lists an error; reading continues.
    pub(crate) fn refuse(&mut self, error: UrdfError) {
        self.errors.push(error);
    }

    pub(crate) fn report_read(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::Read, message.into());
    }

    pub(crate) fn report_default(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::Defaulted, message.into());
    }

    /// Reports a suspicious value that is taken as written.
    pub(crate) fn warn(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Disposition::AsWritten, message.into());
    }

    /// Reports a part that is not in the model and does not affect the motion.
    pub(crate) fn report_ignored(&mut self, line: usize, place: String, message: impl Into<String>) {
        self.push(line, place, Disposition::Ignored { physics: false }, message.into());
    }

    /// Reports a part that is not in the model although it affects, or may affect, the motion.
    pub(crate) fn report_ignored_physics(&mut self, line: usize, place: String, message: impl Into<String>) {
        self.push(line, place, Disposition::Ignored { physics: true }, message.into());
    }

    /// Adds a finding. In a strict reading a warning becomes an error.
    pub(crate) fn push(&mut self, line: usize, place: String, disposition: Disposition, message: String) {
        if self.options.strict && disposition.severity() == Severity::Warning {
            self.refused_warnings.push(UrdfError::Strict { line, place, message });
        } else {
            self.report.add(Finding::new(line, place, disposition, message));
        }
    }
}

//! The walk through a file: elements in, findings out.

use multibody::{Finding, LoadReport, Severity, Treatment};
use robot_xml::roxmltree::Node;

use crate::element::Element;
use crate::{Options, UrdfError};
use robot_xml::Lines;
use robot_xml::excerpt;

/// What the walk carries along.
pub(crate) struct Reader<'a> {
    pub(crate) options: Options,
    pub(crate) report: LoadReport,
    /// Every error so far; a file with one is refused.
    pub(crate) errors: Vec<UrdfError>,
    /// Warnings that a strict reading refuses; the walk takes them as written all the same.
    pub(crate) refused_warnings: Vec<UrdfError>,
    lines: Lines,
    /// The robot element's namespace; elements of any other are foreign.
    namespace: Option<&'a str>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &str, root: Node<'a, 'a>, options: Options) -> Self {
        Self {
            options,
            report: LoadReport::default(),
            errors: Vec::new(),
            refused_warnings: Vec::new(),
            lines: Lines::of(text),
            namespace: root.tag_name().namespace(),
        }
    }

    pub(crate) fn line(&self, node: Node<'a, 'a>) -> usize {
        self.line_of_byte(node.range().start)
    }

    pub(crate) fn line_of_byte(&self, byte: usize) -> usize {
        self.lines.line(byte)
    }

    /// Whether the node is URDF's own element of this name.
    pub(crate) fn is(&self, node: Node<'a, 'a>, name: &str) -> bool {
        self.is_own(node) && node.tag_name().name() == name
    }

    /// Whether the node is an element in URDF's own namespace.
    pub(crate) fn is_own(&self, node: Node<'a, 'a>) -> bool {
        node.is_element() && node.tag_name().namespace() == self.namespace
    }

    /// A link or a joint: placed as `link "hand"`.
    pub(crate) fn named(&self, node: Node<'a, 'a>, kind: &str) -> Element<'a> {
        let place = match node.attribute("name") {
            Some(name) => format!("{kind} {:?}", excerpt(name)),
            None => kind.to_owned(),
        };
        Element { node, line: self.line(node), place }
    }

    /// The child of this name; a second one is not read, with a warning.
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
                    self.push(line, place, Treatment::AsWritten, message);
                }
                None => found = Some(Element { node, line, place }),
            }
        }
        found
    }

    /// The child of this name, which must be there.
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

    /// Lists an error; the walk goes on.
    pub(crate) fn refuse(&mut self, error: UrdfError) {
        self.errors.push(error);
    }

    pub(crate) fn read(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Read, message.into());
    }

    pub(crate) fn defaulted(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Defaulted, message.into());
    }

    /// Something suspicious that is taken as the file has it.
    pub(crate) fn as_written(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::AsWritten, message.into());
    }

    /// Something that stays out of the model without changing how the robot moves.
    pub(crate) fn ignored(&mut self, line: usize, place: String, message: impl Into<String>) {
        self.push(line, place, Treatment::Ignored { physics: false }, message.into());
    }

    /// Something that stays out of the model though it changes, or may change, how the robot moves.
    pub(crate) fn ignored_physics(&mut self, line: usize, place: String, message: impl Into<String>) {
        self.push(line, place, Treatment::Ignored { physics: true }, message.into());
    }

    /// Adds a finding; strict reading refuses a warning.
    pub(crate) fn push(&mut self, line: usize, place: String, treatment: Treatment, message: String) {
        if self.options.strict && treatment.severity() == Severity::Warning {
            self.refused_warnings.push(UrdfError::Strict { line, place, message });
        } else {
            self.report.add(Finding::new(line, place, treatment, message));
        }
    }
}

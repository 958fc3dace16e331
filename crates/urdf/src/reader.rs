//! The walk through a file: elements in, report entries out.

use roxmltree::Node;

use crate::element::Element;
use crate::error::excerpt;
use crate::lines::Lines;
use crate::report::{Entry, LoadReport, Treatment};
use crate::{Options, UrdfError};

/// What the walk carries along.
pub(crate) struct Reader<'a> {
    pub(crate) options: Options,
    pub(crate) report: LoadReport,
    lines: Lines,
    /// The robot element's namespace; elements of any other are foreign.
    namespace: Option<&'a str>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &str, root: Node<'a, 'a>, options: Options) -> Self {
        Self {
            options,
            report: LoadReport::default(),
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

    /// The child of this name; a second one is an error.
    pub(crate) fn child(&self, parent: &Element<'a>, name: &str) -> Result<Option<Element<'a>>, UrdfError> {
        let mut found: Option<Element<'a>> = None;
        for node in parent.node.children().filter(|&node| self.is(node, name)) {
            let line = self.line(node);
            if let Some(first) = found {
                return Err(UrdfError::RepeatedElement {
                    line,
                    place: parent.place.clone(),
                    element: name.to_owned(),
                    first: first.line,
                });
            }
            found = Some(Element { node, line, place: format!("{}/{name}", parent.place) });
        }
        Ok(found)
    }

    /// The child of this name, which must be there.
    pub(crate) fn required_child(
        &self,
        parent: &Element<'a>,
        name: &'static str,
        advice: &'static str,
    ) -> Result<Element<'a>, UrdfError> {
        self.child(parent, name)?.ok_or_else(|| UrdfError::MissingElement {
            line: parent.line,
            place: parent.place.clone(),
            element: name,
            advice,
        })
    }

    pub(crate) fn read(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Read, message.into());
    }

    pub(crate) fn defaulted(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Defaulted, message.into());
    }

    pub(crate) fn repaired(&mut self, element: &Element<'a>, message: impl Into<String>) {
        self.push(element.line, element.place.clone(), Treatment::Repaired, message.into());
    }

    /// Something that stays out of the model without changing how the robot moves.
    pub(crate) fn ignored(&mut self, line: usize, place: String, message: impl Into<String>) {
        self.push(line, place, Treatment::Ignored { physics: false }, message.into());
    }

    /// Something that stays out of the model though it changes, or may change, how the robot moves.
    pub(crate) fn ignored_physics(
        &mut self,
        line: usize,
        place: String,
        message: impl Into<String>,
    ) -> Result<(), UrdfError> {
        let message = message.into();
        if self.options.strict {
            return Err(UrdfError::IgnoredPhysics { line, place, message });
        }
        self.push(line, place, Treatment::Ignored { physics: true }, message);
        Ok(())
    }

    pub(crate) fn push(&mut self, line: usize, place: String, treatment: Treatment, message: String) {
        self.report.push(Entry { line, place, treatment, message });
    }
}

//! One XML element and its attributes. Every error gives line and place.

use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::UrdfError;

/// Larger numbers are refused: they cannot be lengths, masses, inertias or forces in SI units, and their
/// products overflow.
const LARGEST_NUMBER: f64 = 1e30;

/// An element with its line and its place for messages.
#[derive(Clone)]
pub(crate) struct Element<'a> {
    pub(crate) node: Node<'a, 'a>,
    pub(crate) line: usize,
    /// As in `joint "elbow"/limit`.
    pub(crate) place: String,
}

impl<'a> Element<'a> {
    /// The attribute's text.
    pub(crate) fn text(&self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    /// Parses one finite number of an attribute's text.
    pub(crate) fn parse_finite(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let value = self.parse_real(attribute, text, word)?;
        if !value.is_finite() {
            return Err(self.not_finite(attribute, text));
        }
        if value.abs() > LARGEST_NUMBER {
            return Err(UrdfError::TooBig {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
            });
        }
        Ok(value)
    }

    /// Parses a number or an infinity, which bounds may be.
    pub(crate) fn parse_real(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let Ok(value) = word.trim().parse::<f64>() else {
            return Err(UrdfError::NotANumber {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                advice: match word {
                    _ if text.contains("${") => "; it looks like xacro, so expand the file with xacro first",
                    _ if word.contains(',') => {
                        "; it has a comma: use decimal points, and white space between numbers"
                    }
                    _ => "",
                },
            });
        };
        if value.is_nan() { Err(self.not_finite(attribute, text)) } else { Ok(value) }
    }

    fn not_finite(&self, attribute: &str, text: &str) -> UrdfError {
        UrdfError::NotFinite {
            line: self.line,
            place: self.place.clone(),
            attribute: attribute.to_owned(),
            text: excerpt(text),
            advice: "give a finite number in SI units",
        }
    }
}

//! One XML element and its attributes, each complaint with line and place.
//!
//! A value that cannot be read is listed as an error, and the walk goes on, so that all of a file's errors are found
//! at once; NaN stands in for it and silences what would only follow from it. A file with an error is refused, so
//! no stand-in reaches a robot.

use robot_xml::roxmltree::Node;

use crate::UrdfError;
use crate::reader::Reader;
use robot_xml::excerpt;

/// Larger numbers are no length, mass, inertia or force in SI units, and their products overflow.
const BIGGEST: f64 = 1e30;

/// An element with the words that say where it is.
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

    /// One number of an attribute's text.
    fn finite(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let value = self.real(attribute, text, word)?;
        if !value.is_finite() {
            return Err(self.not_finite(attribute, text));
        }
        if value.abs() > BIGGEST {
            return Err(UrdfError::TooBig {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
            });
        }
        Ok(value)
    }

    /// A number or an infinity, as bounds may be.
    fn real(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let Ok(value) = word.trim().parse::<f64>() else {
            return Err(UrdfError::NotANumber {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                advice: match word {
                    _ if text.contains("${") => "; it looks like xacro, so run xacro on the file first",
                    _ if word.contains(',') => {
                        "; it has a comma: write a decimal point, and white space between numbers"
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
            advice: "write an ordinary number in SI units",
        }
    }
}

impl<'a> Reader<'a> {
    /// The attribute's text, which must be there; `example` shows how to write it.
    pub(crate) fn required_text(
        &mut self,
        element: &Element<'a>,
        attribute: &str,
        example: &str,
    ) -> Option<&'a str> {
        let text = element.text(attribute);
        if text.is_none() {
            self.refuse(UrdfError::MissingAttribute {
                line: element.line,
                place: element.place.clone(),
                attribute: attribute.to_owned(),
                example: example.to_owned(),
            });
        }
        text
    }

    /// A name, which must be there and not be blank; an empty one stands in for it.
    pub(crate) fn required_name(&mut self, element: &Element<'a>, attribute: &str, example: &str) -> &'a str {
        let Some(name) = self.required_text(element, attribute, example) else { return "" };
        if name.trim().is_empty() {
            self.refuse(UrdfError::EmptyName {
                line: element.line,
                place: element.place.clone(),
                attribute: attribute.to_owned(),
            });
            return "";
        }
        name
    }

    /// A number that must be there.
    pub(crate) fn required_number(&mut self, element: &Element<'a>, attribute: &str) -> f64 {
        match self.required_text(element, attribute, &format!("{attribute}=\"NUMBER\"")) {
            Some(text) => self.or_refuse(element.finite(attribute, text, text)),
            None => f64::NAN,
        }
    }

    /// A number of physical size.
    pub(crate) fn number(&mut self, element: &Element<'a>, attribute: &str) -> Option<f64> {
        element.text(attribute).map(|text| self.or_refuse(element.finite(attribute, text, text)))
    }

    /// A number of any size, or an infinity, as bounds are. The largest of all numbers is how programs write none.
    pub(crate) fn bound(&mut self, element: &Element<'a>, attribute: &str) -> Option<f64> {
        let bound =
            self.or_refuse(element.real(attribute, element.text(attribute)?, element.text(attribute)?));
        Some(if bound.abs() == f64::MAX { f64::INFINITY.copysign(bound) } else { bound })
    }

    /// `N` numbers between white space.
    pub(crate) fn numbers<const N: usize>(
        &mut self,
        element: &Element<'a>,
        attribute: &str,
    ) -> Option<[f64; N]> {
        let text = element.text(attribute)?;
        let found = text.split_ascii_whitespace().count();
        let mut values = [f64::NAN; N];
        // A comma makes one word of two numbers, or two words of one: it is the better complaint.
        let misread =
            text.split_ascii_whitespace().find_map(|word| element.finite(attribute, text, word).err());
        if let Some(error) = misread.filter(|_| found == N || text.contains(',')) {
            self.refuse(error);
        } else if found != N {
            self.refuse(UrdfError::WrongCount {
                line: element.line,
                place: element.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                expected: N,
                found,
            });
        } else {
            for (value, word) in values.iter_mut().zip(text.split_ascii_whitespace()) {
                *value = self.or_refuse(element.finite(attribute, text, word));
            }
        }
        Some(values)
    }

    fn or_refuse(&mut self, number: Result<f64, UrdfError>) -> f64 {
        number.unwrap_or_else(|error| {
            self.refuse(error);
            f64::NAN
        })
    }
}

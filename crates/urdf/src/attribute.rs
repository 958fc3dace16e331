//! Reads the attributes of an element.
//!
//! A value that cannot be read is listed as an error and replaced by NaN, and reading continues, so that one
//! pass finds all errors of a file. NaN suppresses errors that would only follow from the first one. A file
//! with an error is refused, so no replacement value reaches a robot.

use robot_dynamics_xml::excerpt;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;

impl<'a> Reader<'a> {
    /// The text of a required attribute; `example` shows how to write it.
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

    /// A required name that is not blank. After an error the name is empty.
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

    /// A required number.
    pub(crate) fn required_number(&mut self, element: &Element<'a>, attribute: &str) -> f64 {
        match self.required_text(element, attribute, &format!("{attribute}=\"NUMBER\"")) {
            Some(text) => self.or_refuse(element.parse_finite(attribute, text, text)),
            None => f64::NAN,
        }
    }

    /// An optional number whose magnitude is at most the limit.
    pub(crate) fn number(&mut self, element: &Element<'a>, attribute: &str) -> Option<f64> {
        element.text(attribute).map(|text| self.or_refuse(element.parse_finite(attribute, text, text)))
    }

    /// A bound: a number of any size, or an infinity. Programs write the largest double for "no bound".
    pub(crate) fn bound(&mut self, element: &Element<'a>, attribute: &str) -> Option<f64> {
        let bound =
            self.or_refuse(element.parse_real(attribute, element.text(attribute)?, element.text(attribute)?));
        Some(if bound.abs() == f64::MAX { f64::INFINITY.copysign(bound) } else { bound })
    }

    /// `N` numbers separated by white space.
    pub(crate) fn numbers<const N: usize>(
        &mut self,
        element: &Element<'a>,
        attribute: &str,
    ) -> Option<[f64; N]> {
        let text = element.text(attribute)?;
        let found = text.split_ascii_whitespace().count();
        let mut values = [f64::NAN; N];
        // A comma changes the number of words, so its error is more helpful than the wrong count.
        let misread =
            text.split_ascii_whitespace().find_map(|word| element.parse_finite(attribute, text, word).err());
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
                *value = self.or_refuse(element.parse_finite(attribute, text, word));
            }
        }
        Some(values)
    }

    /// Any number of numbers in an attribute's text; `None` after an error.
    pub(crate) fn list(&mut self, element: &Element<'a>, attribute: &str, text: &str) -> Option<Vec<f64>> {
        let words = text.split_ascii_whitespace();
        let read: Result<Vec<f64>, UrdfError> =
            words.map(|word| element.parse_finite(attribute, text, word)).collect();
        read.map_err(|error| self.refuse(error)).ok()
    }

    fn or_refuse(&mut self, number: Result<f64, UrdfError>) -> f64 {
        number.unwrap_or_else(|error| {
            self.refuse(error);
            f64::NAN
        })
    }
}

//! One XML element and its attributes, each complaint with line and place.

use roxmltree::Node;

use crate::UrdfError;
use crate::error::excerpt;

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

    /// The attribute's text, which must be there; `example` shows how to write it.
    pub(crate) fn required_text(&self, attribute: &str, example: &str) -> Result<&'a str, UrdfError> {
        self.text(attribute).ok_or_else(|| UrdfError::MissingAttribute {
            line: self.line,
            place: self.place.clone(),
            attribute: attribute.to_owned(),
            example: example.to_owned(),
        })
    }

    /// A name, which must be there and not be blank.
    pub(crate) fn required_name(&self, attribute: &str, example: &str) -> Result<&'a str, UrdfError> {
        let name = self.required_text(attribute, example)?;
        if name.trim().is_empty() {
            return Err(UrdfError::EmptyName {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
            });
        }
        Ok(name)
    }

    /// A number that must be there.
    pub(crate) fn required_number(&self, attribute: &str) -> Result<f64, UrdfError> {
        self.required_text(attribute, &format!("{attribute}=\"NUMBER\""))?;
        Ok(self.number(attribute)?.unwrap_or_default())
    }

    /// A number of physical size.
    pub(crate) fn number(&self, attribute: &str) -> Result<Option<f64>, UrdfError> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        self.physical(attribute, text, text).map(Some)
    }

    /// A finite number of any size, as bounds are.
    pub(crate) fn bound(&self, attribute: &str) -> Result<Option<f64>, UrdfError> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        self.finite(attribute, text, text).map(Some)
    }

    /// `N` numbers between white space.
    pub(crate) fn numbers<const N: usize>(&self, attribute: &str) -> Result<Option<[f64; N]>, UrdfError> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        let found = text.split_ascii_whitespace().count();
        if found != N {
            return Err(UrdfError::WrongCount {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                expected: N,
                found,
            });
        }
        let mut values = [0.0; N];
        for (value, word) in values.iter_mut().zip(text.split_ascii_whitespace()) {
            *value = self.physical(attribute, text, word)?;
        }
        Ok(Some(values))
    }

    fn physical(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let value = self.finite(attribute, text, word)?;
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

    fn finite(&self, attribute: &str, text: &str, word: &str) -> Result<f64, UrdfError> {
        let Ok(value) = word.trim().parse::<f64>() else {
            return Err(UrdfError::NotANumber {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                advice: match word {
                    _ if text.contains("${") => "; it looks like xacro, so run xacro on the file first",
                    _ if word.contains(',') => "; write a decimal point, and white space between numbers",
                    _ => "",
                },
            });
        };
        if !value.is_finite() {
            return Err(UrdfError::NotFinite {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                text: excerpt(text),
                advice: "write an ordinary number in SI units",
            });
        }
        Ok(value)
    }

    /// Refuses a negative value.
    pub(crate) fn not_negative(
        &self,
        attribute: &str,
        value: f64,
        advice: &'static str,
    ) -> Result<f64, UrdfError> {
        if value < 0.0 {
            return Err(UrdfError::Negative {
                line: self.line,
                place: self.place.clone(),
                attribute: attribute.to_owned(),
                value,
                advice,
            });
        }
        Ok(value)
    }
}

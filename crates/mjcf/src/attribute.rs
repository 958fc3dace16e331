//! Reads the attributes of an element and of its defaults. Every error gives line and place.
//!
//! A value that cannot be read is listed as an error and replaced by NaN, and reading continues, so that one
//! pass finds all errors of a file. NaN suppresses errors that would only follow from the first one. A file
//! with an error is refused, so no replacement value reaches a robot.

use robot_dynamics_xml::{Resource, excerpt};

use crate::MjcfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Id;

/// Larger numbers are refused: they cannot be lengths, masses, inertias or forces in SI units, and their
/// products overflow.
const LARGEST_NUMBER: f64 = 1e30;

/// A list with more numbers is charged to the limit on numbers.
const LONG_LIST: usize = 16;
/// The weight of a number in a list: its text is longer than the number, and may be read many times.
const LIST_WEIGHT: usize = 4;

impl<'a> Reader<'a> {
    /// The attribute's text and its node: the element, or the innermost default that has the attribute.
    pub(crate) fn text_at(&self, element: &Element, attribute: &str) -> Option<(&'a str, Id)> {
        let mut nodes = element.defaults.iter().copied().chain([element.node]).rev();
        nodes.find_map(|node| Some((self.tree.nodes[node].attribute(attribute)?, node)))
    }

    /// The attribute's text.
    pub(crate) fn text(&self, element: &Element, attribute: &str) -> Option<&'a str> {
        self.text_at(element, attribute).map(|(text, _)| text)
    }

    /// The text of a required attribute, which must not be blank.
    pub(crate) fn required_text(
        &mut self,
        element: &Element,
        attribute: &'static str,
        example: &'static str,
    ) -> Option<&'a str> {
        let text = self.text(element, attribute).filter(|text| !text.trim().is_empty());
        if text.is_none() {
            let (line, place) = (element.line, element.place.clone());
            self.errors.push(MjcfError::MissingAttribute { line, place, attribute, example });
        }
        text
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&mut self, element: &Element, attribute: &str) -> Option<bool> {
        self.word(element, attribute, &["false", "true"]).map(|word| word == "true")
    }

    /// One of the known words.
    pub(crate) fn word(&mut self, element: &Element, attribute: &str, known: &[&'a str]) -> Option<&'a str> {
        let (text, node) = self.text_at(element, attribute)?;
        let found = known.contains(&text.trim());
        if !found {
            let (line, place) = (self.tree.nodes[node].line, self.place(node));
            self.errors.push(MjcfError::UnknownWord {
                line,
                place,
                attribute: attribute.to_owned(),
                text: excerpt(text),
                known: known.join(", "),
            });
        }
        found.then(|| text.trim())
    }

    /// A number.
    pub(crate) fn number(&mut self, element: &Element, attribute: &str) -> Option<f64> {
        self.numbers::<1>(element, attribute).map(|[value]| value)
    }

    /// A required number.
    pub(crate) fn required_number(&mut self, element: &Element, attribute: &'static str) -> f64 {
        self.required_text(element, attribute, "NUMBER");
        self.number(element, attribute).unwrap_or(f64::NAN)
    }

    /// A number that is zero or positive.
    pub(crate) fn magnitude(&mut self, element: &Element, attribute: &str) -> Option<f64> {
        let value = self.number(element, attribute)?;
        if value < 0.0 {
            let (line, place) = (element.line, element.place.clone());
            self.errors.push(MjcfError::Negative { line, place, attribute: attribute.to_owned(), value });
            return Some(f64::NAN);
        }
        Some(value)
    }

    /// `N` numbers separated by white space.
    pub(crate) fn numbers<const N: usize>(&mut self, element: &Element, attribute: &str) -> Option<[f64; N]> {
        let (text, node) = self.text_at(element, attribute)?;
        let mut values = [f64::NAN; N];
        match self.list(text, attribute, node) {
            Some(list) if list.len() == N => values.copy_from_slice(&list),
            Some(list) => self.refuse_count(attribute, text, node, N.to_string(), list.len()),
            None => {}
        }
        Some(values)
    }

    /// The two numbers of a range. A bound can be infinite, as `inf` or `-inf`.
    pub(crate) fn bounds(&mut self, element: &Element, attribute: &str) -> Option<[f64; 2]> {
        let (text, node) = self.text_at(element, attribute)?;
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let [first, second] = words[..] else { return self.numbers(element, attribute) };
        Some([first, second].map(|word| match infinity(word) {
            Some(bound) => bound,
            None => self.list(word, attribute, node).map_or(f64::NAN, |list| list[0]),
        }))
    }

    /// Up to `N` numbers that replace the first of `values`. The defaults are applied before the element, the
    /// outermost first.
    pub(crate) fn overlay<const N: usize>(
        &mut self,
        element: &Element,
        attribute: &str,
        mut values: [f64; N],
    ) -> [f64; N] {
        let nodes: Vec<Id> = element.defaults.iter().copied().chain([element.node]).collect();
        for node in nodes {
            let Some(text) = self.tree.nodes[node].attribute(attribute) else { continue };
            match self.list(text, attribute, node) {
                Some(list) if list.len() <= N => values[..list.len()].copy_from_slice(&list),
                Some(list) => {
                    self.refuse_count(attribute, text, node, format!("at most {N}"), list.len());
                }
                None => values = [f64::NAN; N],
            }
        }
        values
    }

    /// Any number of numbers.
    pub(crate) fn all_numbers(&mut self, element: &Element, attribute: &str) -> Option<Vec<f64>> {
        let (text, node) = self.text_at(element, attribute)?;
        self.list(text, attribute, node)
    }

    pub(crate) fn refuse_count(
        &mut self,
        attribute: &str,
        text: &str,
        node: Id,
        expected: String,
        found: usize,
    ) {
        let (line, place) = (self.tree.nodes[node].line, self.place(node));
        let (attribute, text) = (attribute.to_owned(), excerpt(text));
        self.errors.push(MjcfError::WrongCount { line, place, attribute, text, expected, found });
    }

    /// The numbers in a text; `None`, with an error, if a word is not a valid number.
    fn list(&mut self, text: &str, attribute: &str, node: Id) -> Option<Vec<f64>> {
        let mut values = Vec::new();
        for word in text.split_ascii_whitespace() {
            match word.parse::<f64>() {
                Ok(value) if value.abs() <= LARGEST_NUMBER => values.push(value),
                outcome => {
                    let (line, place) = (self.tree.nodes[node].line, self.place(node));
                    let (attribute, text) = (attribute.to_owned(), excerpt(text));
                    self.errors.push(match outcome {
                        Err(_) if word.contains(',') => {
                            let advice =
                                "; it has a comma: use decimal points, and white space between numbers";
                            MjcfError::NotANumber { line, place, attribute, text, advice }
                        }
                        Err(_) => MjcfError::NotANumber { line, place, attribute, text, advice: "" },
                        Ok(value) if value.is_finite() => MjcfError::TooBig { line, place, attribute, text },
                        Ok(_) => MjcfError::NotFinite { line, place, attribute, text },
                    });
                    return None;
                }
            }
        }
        // A long list in a default may be read for many elements.
        let is_long = values.len() > LONG_LIST;
        (!is_long || self.charge(node, Resource::Numbers, LIST_WEIGHT * values.len())).then_some(values)
    }
}

/// The value of a word for infinity; `None` for numbers, also for one that overflows.
fn infinity(word: &str) -> Option<f64> {
    let value: f64 = word.parse().ok()?;
    (value.is_infinite() && !word.bytes().any(|byte| byte.is_ascii_digit())).then_some(value)
}

//! The errors of a scene's file.

use core::fmt;

use robot_dynamics_description::{LoadReport, RefusedFile};
use thiserror::Error;

/// One error of a scene's file, with its line, its place and advice.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}{}{message}", Line(*line), Place(place))]
pub struct SceneFault {
    line: Option<usize>,
    place: String,
    message: String,
    /// Whether it is a limit on the whole file.
    is_limit: bool,
}

struct Line(Option<usize>);

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |line| write!(f, "line {line}: "))
    }
}

struct Place<'a>(&'a str);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { Ok(()) } else { write!(f, "{}: ", self.0) }
    }
}

impl SceneFault {
    pub(super) fn new(line: usize, place: &str, message: impl Into<String>) -> Self {
        Self { line: Some(line), place: place.to_owned(), message: message.into(), is_limit: false }
    }

    /// An error of the whole file, whose text has its line.
    pub(super) fn of_file(line: Option<usize>, error: &impl ToString) -> Self {
        let text = error.to_string();
        let message = match line.and_then(|line| text.strip_prefix(&format!("line {line}: "))) {
            Some(message) => {
                return Self { line, place: String::new(), message: message.to_owned(), is_limit: false };
            }
            None => text,
        };
        Self { line: None, place: String::new(), message, is_limit: false }
    }

    /// A limit on the whole file, which ends the reading.
    pub(super) fn of_limit(line: usize, place: &str, message: impl Into<String>) -> Self {
        Self { is_limit: true, ..Self::new(line, place, message) }
    }

    /// The line by which errors are sorted. A limit comes first, so that it is always among the listed
    /// errors.
    pub(super) fn sorted_at(&self) -> Option<usize> {
        if self.is_limit { None } else { self.line }
    }

    pub(super) fn refused(self) -> RefusedFile<Self> {
        RefusedFile::new(vec![self], Self::line, LoadReport::default())
    }

    /// Its line, from 1; `None` for an error of the whole file.
    pub fn line(&self) -> Option<usize> {
        self.line
    }

    /// The element, as in `robot "arm.urdf"`.
    pub fn place(&self) -> &str {
        &self.place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_listed_before_a_thousand_errors() {
        let mut faults: Vec<_> = (1..2000).map(|line| SceneFault::new(line, "box", "no size")).collect();
        faults.push(SceneFault::of_limit(2000, "box", "the scene has more than 5 links"));
        let refused = RefusedFile::new(faults, SceneFault::sorted_at, LoadReport::default());
        assert_eq!((refused.errors()[0].line(), refused.errors()[1].line()), (Some(2000), Some(1)));
        assert_eq!(refused.unlisted(), 1000);
    }
}

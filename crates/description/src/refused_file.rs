//! The error of a rejected robot file, for any format.

use core::error::Error;
use core::fmt;

use robot_dynamics_number::{Classified, ErrorKind};

use crate::LoadReport;

/// All errors of a robot file, in the order of its lines, with its other findings. E is an error of the
/// format.
#[derive(Debug)]
pub struct RefusedFile<E> {
    errors: Vec<E>,
    unlisted: usize,
    report: Box<LoadReport>,
}

impl<E> RefusedFile<E> {
    /// The largest number of errors that are listed one by one.
    pub const LISTED: usize = 1000;

    /// For readers of robot files: takes at least one error, and the line of each.
    ///
    /// ```
    /// use robot_dynamics::description::{LoadReport, RefusedFile};
    /// let errors = vec!["line 7: no mass", "line 2: no name"];
    /// let line = |error: &&str| error[5..6].parse().ok();
    /// let refused = RefusedFile::new(errors, line, LoadReport::default());
    /// assert_eq!(refused.errors()[0], "line 2: no name");
    /// assert_eq!(refused.to_string(), "2 errors\n  line 2: no name\n  line 7: no mass");
    /// ```
    pub fn new(mut errors: Vec<E>, line: impl Fn(&E) -> Option<usize>, report: LoadReport) -> Self {
        errors.sort_by_key(line);
        let unlisted = errors.len().saturating_sub(Self::LISTED);
        errors.truncate(Self::LISTED);
        Self { errors, unlisted, report: Box::new(report) }
    }

    /// The listed errors: at least one, at most [`LISTED`](Self::LISTED).
    pub fn errors(&self) -> &[E] {
        &self.errors
    }

    /// The number of errors beyond those listed.
    pub fn unlisted(&self) -> usize {
        self.unlisted
    }

    /// The warnings and notes of the part of the file that could be read.
    pub fn report(&self) -> &LoadReport {
        &self.report
    }
}

impl<E: fmt::Display> fmt::Display for RefusedFile<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let ([error], 0) = (&self.errors[..], self.unlisted) {
            return write!(f, "{error}");
        }
        write!(f, "{} errors", self.errors.len() + self.unlisted)?;
        for error in &self.errors {
            write!(f, "\n  {error}")?;
        }
        if self.unlisted > 0 {
            write!(f, "\n  and {} more", self.unlisted)?;
        }
        Ok(())
    }
}

impl<E: Error + 'static> Error for RefusedFile<E> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.errors.first().map(|error| error as _)
    }
}

impl<E: Error + Send + Sync + 'static> Classified for RefusedFile<E> {
    fn kind(&self) -> ErrorKind {
        ErrorKind::File
    }
}

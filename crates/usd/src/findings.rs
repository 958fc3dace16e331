//! The state of reading one file: options, report and errors.

use robot_dynamics_description::{Disposition, Finding, LoadReport, Severity};
use robot_dynamics_xml::{LoadOptions, excerpt};

use crate::UsdError;

/// Findings have no lines.
const NO_LINE: usize = 0;

/// Collects findings and errors.
pub(crate) struct Findings {
    pub(crate) options: LoadOptions,
    pub(crate) report: LoadReport,
    /// All errors so far. A file with an error is refused.
    pub(crate) errors: Vec<UsdError>,
    /// Warnings of a strict reading.
    pub(crate) refused_warnings: Vec<UsdError>,
}

impl Findings {
    pub(crate) fn new(options: LoadOptions) -> Self {
        Self { options, report: LoadReport::default(), errors: Vec::new(), refused_warnings: Vec::new() }
    }

    /// Lists an error of a prim; reading continues.
    pub(crate) fn refuse(&mut self, path: &str, reason: impl Into<String>) {
        self.errors.push(UsdError::BadPrim { place: excerpt(path), reason: reason.into() });
    }

    /// Reports a suspicious value that is taken as written.
    pub(crate) fn warn(&mut self, path: &str, message: impl Into<String>) {
        self.push(path, Disposition::AsWritten, message);
    }

    /// Reports physics that the model leaves out.
    pub(crate) fn leave_out(&mut self, path: &str, message: impl Into<String>) {
        self.push(path, Disposition::Ignored { physics: true }, message);
    }

    /// Reports a part that is not in the model and does not affect the motion.
    pub(crate) fn ignore(&mut self, path: &str, message: impl Into<String>) {
        self.push(path, Disposition::Ignored { physics: false }, message);
    }

    pub(crate) fn default_value(&mut self, path: &str, message: impl Into<String>) {
        self.push(path, Disposition::Defaulted, message);
    }

    /// Adds a finding. In a strict reading a warning becomes an error.
    pub(crate) fn push(&mut self, path: &str, disposition: Disposition, message: impl Into<String>) {
        let (place, message) = (excerpt(path), message.into());
        if self.options.strict && disposition.severity() == Severity::Warning {
            self.refused_warnings.push(UsdError::Strict { place, message });
        } else {
            self.report.add(Finding::new(NO_LINE, place, disposition, message));
        }
    }
}

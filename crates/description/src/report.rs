//! A report of how a reader treated every part of a robot file, with one policy for all formats.
//!
//! A reader of robot files turns text into a [`RobotDescription`](crate::RobotDescription) and a
//! [`LoadReport`]. Each [`Finding`] has a [`Severity`], by one rule for all formats
//! ([`Disposition::severity`]). Values that are meaningless in the equations of motion are errors. Suspicious
//! values are used exactly as written, with a warning. Values that are defaulted or ignored without changing
//! the motion are notes.

use core::fmt;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::text::one_line;

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum Severity {
    /// Read, defaulted, or ignored without changing how the robot moves.
    Note,
    /// Suspicious and used as written, repaired on request, or physics that the model leaves out.
    Warning,
    /// Meaningless in the equations of motion: the file is rejected.
    Error,
}

/// The disposition of a part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[doc(alias = "Treatment")]
pub enum Disposition {
    /// The model has its values.
    Read,
    /// The file leaves it out; the message states the default.
    Defaulted,
    /// The model has the file's values unchanged, although they are suspicious.
    AsWritten,
    /// No rigid body has the file's values, and the reader was asked to repair them. The message states the
    /// old and the new values.
    Repaired,
    /// The model leaves it out.
    Ignored {
        /// Whether it affects the robot's motion.
        physics: bool,
    },
    /// It is meaningless; the file is rejected.
    Refused,
}

impl Disposition {
    /// The policy: the severity of each disposition.
    pub fn severity(self) -> Severity {
        match self {
            Self::Read | Self::Defaulted | Self::Ignored { physics: false } => Severity::Note,
            Self::AsWritten | Self::Repaired | Self::Ignored { physics: true } => Severity::Warning,
            Self::Refused => Severity::Error,
        }
    }
}

/// The disposition of one element or attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Finding {
    line: usize,
    place: String,
    severity: Severity,
    disposition: Disposition,
    message: String,
}

impl Finding {
    /// A finding at a line of the file (from 1), in an element such as `joint "elbow"/limit`, with a message
    /// in plain words.
    pub fn new(
        line: usize,
        place: impl Into<String>,
        disposition: Disposition,
        message: impl Into<String>,
    ) -> Self {
        let (place, message) = (place.into(), message.into());
        Self { line, place, severity: disposition.severity(), disposition, message }
    }

    /// Its line in the file, from 1; 0 for formats without lines.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The element, as in `joint "elbow"/limit`.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// Its severity.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// Its disposition.
    pub fn disposition(&self) -> Disposition {
        self.disposition
    }

    /// The message: the file's value, its deviation, the value used, and the remedy.
    pub fn message(&self) -> &str {
        &self.message
    }
}

/// The report of a loaded file. Every part that the model leaves out or changes has a finding.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LoadReport {
    /// The robot's name.
    pub robot: String,
    /// The totals.
    pub counts: LoadCounts,
    /// The findings; after [`sort`](Self::sort) in the order of the file's lines.
    pub findings: Vec<Finding>,
    /// The source files of the robot, as absolute paths: the main file, included files and attached models.
    /// Meshes and height fields are included if they were opened or if its shapes name them. No output may
    /// overwrite one of these files.
    #[cfg_attr(feature = "serde", serde(default, serialize_with = "paths_as_text"))]
    pub files: Vec<PathBuf>,
}

/// Leaves out paths that are not valid text, which JSON cannot represent.
#[cfg(feature = "serde")]
fn paths_as_text<S: serde::Serializer>(files: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(files.iter().filter_map(|file| file.to_str()))
}

/// Totals of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[doc(alias = "Counts")]
pub struct LoadCounts {
    /// Links.
    pub links: usize,
    /// Joints of every type, fixed ones included.
    pub joints: usize,
    /// Independent velocities: mimic joints add none, a floating base adds six.
    pub degrees_of_freedom: usize,
    /// Findings of values that were read.
    pub read: usize,
    /// Findings of defaulted values.
    pub defaulted: usize,
    /// Findings of suspicious values used as written.
    pub as_written: usize,
    /// Findings of repaired values.
    pub repaired: usize,
    /// Findings of ignored elements, whether or not they affect the motion.
    pub ignored: usize,
    /// Findings of ignored elements that affect the motion.
    pub ignored_physics: usize,
    /// Findings of severity [`Severity::Warning`].
    pub warnings: usize,
    /// Findings of severity [`Severity::Error`].
    pub errors: usize,
    /// Elements for appearance and collision. They do not affect the dynamics and have no findings.
    pub not_dynamics: usize,
    /// Findings counted above but not listed, because the file has more than [`LoadReport::LISTED`].
    pub unlisted: usize,
}

impl LoadReport {
    /// The largest number of findings that are listed; further ones are only counted.
    pub const LISTED: usize = 2_000_000;

    /// Adds a finding to the list and to the totals.
    pub fn add(&mut self, finding: Finding) {
        let counts = &mut self.counts;
        match finding.disposition {
            Disposition::Read => counts.read += 1,
            Disposition::Defaulted => counts.defaulted += 1,
            Disposition::AsWritten => counts.as_written += 1,
            Disposition::Repaired => counts.repaired += 1,
            Disposition::Ignored { physics } => {
                counts.ignored += 1;
                counts.ignored_physics += usize::from(physics);
            }
            Disposition::Refused => {}
        }
        match finding.severity {
            Severity::Note => {}
            Severity::Warning => counts.warnings += 1,
            Severity::Error => counts.errors += 1,
        }
        if self.findings.len() < Self::LISTED {
            self.findings.push(finding);
        } else {
            counts.unlisted += 1;
        }
    }

    /// Adds source files, each once. Symbolic links are resolved if the file exists.
    ///
    /// ```
    /// use std::path::Path;
    /// let mut report = robot_dynamics::description::LoadReport::default();
    /// report.add_files([Path::new("robot.urdf"), Path::new("./robot.urdf")]);
    /// assert!(report.files.len() == 1 && report.files[0].is_absolute());
    /// ```
    pub fn add_files<'a>(&mut self, paths: impl IntoIterator<Item = &'a Path>) {
        // Many shapes may name one mesh: the file system is queried once.
        let mut asked = HashSet::new();
        let mut known: HashSet<PathBuf> = self.files.iter().cloned().collect();
        for path in paths.into_iter().filter(|path| asked.insert(*path)) {
            let whole = path.canonicalize().or_else(|_| std::path::absolute(path));
            let whole = whole.unwrap_or_else(|_| path.to_owned());
            if known.insert(whole.clone()) {
                self.files.push(whole);
            }
        }
    }

    /// Sorts the findings by the file's lines; those of one line stay in order.
    pub fn sort(&mut self) {
        self.findings.sort_by_key(|finding| finding.line);
    }

    /// The findings of this severity.
    pub fn of_severity(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |finding| finding.severity == severity)
    }

    /// The findings that need attention: suspicious values, repaired ones, and physics that the model leaves
    /// out.
    pub fn warnings(&self) -> impl Iterator<Item = &Finding> {
        self.of_severity(Severity::Warning)
    }

    /// The findings of ignored elements that affect the motion.
    pub fn ignored_physics(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.disposition == Disposition::Ignored { physics: true })
    }
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LoadCounts { links, joints, degrees_of_freedom, not_dynamics, unlisted, .. } = self.counts;
        writeln!(
            f,
            "robot {:?}: {links} links, {joints} joints, {degrees_of_freedom} degrees of freedom",
            self.robot
        )?;
        writeln!(
            f,
            "{}; {not_dynamics} visual, collision or material elements, which dynamics does not need",
            self.counts.sums()
        )?;
        for Finding { line, place, disposition, message, .. } in &self.findings {
            let (place, message) = (one_line(place), one_line(message));
            writeln!(f, "{line:>6}  {disposition:<15}  {place}: {message}")?;
        }
        if unlisted > 0 {
            writeln!(f, "        and {unlisted} more")?;
        }
        Ok(())
    }
}

impl LoadCounts {
    /// The totals by disposition, in one line.
    pub fn sums(&self) -> String {
        let Self { read, defaulted, as_written, repaired, ignored, ignored_physics, .. } = self;
        format!(
            "{read} read, {defaulted} defaulted, {as_written} suspicious but taken as written, {repaired} repaired, \
             {ignored} ignored ({ignored_physics} of them physics)"
        )
    }
}

impl fmt::Display for Disposition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Read => "read",
            Self::Defaulted => "defaulted",
            Self::AsWritten => "AS WRITTEN",
            Self::Repaired => "REPAIRED",
            Self::Ignored { physics: false } => "ignored",
            Self::Ignored { physics: true } => "IGNORED PHYSICS",
            Self::Refused => "REFUSED",
        })
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

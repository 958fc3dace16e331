//! What became of every part of a robot file, of whatever format: one policy, one account.
//!
//! A reader of robot files turns text into a [`RobotDescription`](crate::RobotDescription) and a [`LoadReport`].
//! Each [`Finding`] has a [`Severity`], by one rule for all formats ([`Treatment::severity`]): what has no meaning
//! in the equations of motion is an error; what is suspicious is taken exactly as written, with a warning; what is
//! defaulted or ignored without changing the motion is a note.

use core::fmt;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::text::one_line;

/// How grave a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum Severity {
    /// Read, defaulted, or ignored without changing how the robot moves.
    Note,
    /// Suspicious and taken as written, replaced on request, or physics that is not in the model.
    Warning,
    /// The equations of motion have no meaning: the file is refused.
    Error,
}

/// What became of a part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Treatment {
    /// Its values are in the model.
    Read,
    /// The file leaves it out; the message says what was taken.
    Defaulted,
    /// Its values are in the model exactly as the file has them, though they are suspicious.
    AsWritten,
    /// No rigid body has what the file says, and the reader was asked to mend it; the message tells the old and
    /// the new values.
    Repaired,
    /// It is not in the model.
    Ignored {
        /// Whether it changes how the robot moves.
        physics: bool,
    },
    /// It has no meaning; a file with such a part is refused.
    Refused,
}

impl Treatment {
    /// The policy: how grave it is that a part of a file was treated so.
    pub fn severity(self) -> Severity {
        match self {
            Self::Read | Self::Defaulted | Self::Ignored { physics: false } => Severity::Note,
            Self::AsWritten | Self::Repaired | Self::Ignored { physics: true } => Severity::Warning,
            Self::Refused => Severity::Error,
        }
    }
}

/// What became of one element or attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Finding {
    line: usize,
    place: String,
    severity: Severity,
    treatment: Treatment,
    message: String,
}

impl Finding {
    /// At a line of the file (from 1), in an element such as `joint "elbow"/limit`, told in plain words.
    pub fn new(
        line: usize,
        place: impl Into<String>,
        treatment: Treatment,
        message: impl Into<String>,
    ) -> Self {
        let (place, message) = (place.into(), message.into());
        Self { line, place, severity: treatment.severity(), treatment, message }
    }

    /// Its line in the file, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The element, as in `joint "elbow"/limit`.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// How grave it is.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// What became of it.
    pub fn treatment(&self) -> Treatment {
        self.treatment
    }

    /// In plain words: what the file says, by how much it is off, what was taken, what to do.
    pub fn message(&self) -> &str {
        &self.message
    }
}

/// The account of a loaded file: nothing in it was lost without a finding here.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LoadReport {
    /// The robot's name.
    pub robot: String,
    /// The sums.
    pub counts: Counts,
    /// In the order of the file's lines, once it is read.
    pub findings: Vec<Finding>,
    /// The files that the robot comes from, as absolute paths: the main file, included files, attached models, and the
    /// meshes and height fields that were opened or that its shapes name. No output may replace one of them.
    #[cfg_attr(feature = "serde", serde(default, serialize_with = "paths_as_text"))]
    pub files: Vec<PathBuf>,
}

/// Paths that are no text are left out: JSON cannot hold them.
#[cfg(feature = "serde")]
fn paths_as_text<S: serde::Serializer>(files: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(files.iter().filter_map(|file| file.to_str()))
}

/// How many of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Counts {
    /// Links.
    pub links: usize,
    /// Joints of every type, fixed ones included.
    pub joints: usize,
    /// Independent velocities: joints that follow another add none, a floating base adds six.
    pub degrees_of_freedom: usize,
    /// Findings of things read.
    pub read: usize,
    /// Findings of values the file leaves out.
    pub defaulted: usize,
    /// Findings of suspicious values taken as written.
    pub as_written: usize,
    /// Findings of values replaced because no robot has them.
    pub repaired: usize,
    /// Findings of things ignored, physics or not.
    pub ignored: usize,
    /// Findings of ignored things that change how the robot moves.
    pub ignored_physics: usize,
    /// Findings of severity [`Severity::Warning`].
    pub warnings: usize,
    /// Findings of severity [`Severity::Error`].
    pub errors: usize,
    /// Elements that say how the robot looks and what it collides with: shape, not dynamics. They have no findings.
    pub not_dynamics: usize,
    /// Findings counted above but not listed, because a file had more of them than [`LoadReport::LISTED`].
    pub unlisted: usize,
}

impl LoadReport {
    /// The most findings that are listed one by one; beyond it they are only counted.
    pub const LISTED: usize = 2_000_000;

    /// Adds a finding to the list and to the sums.
    pub fn add(&mut self, finding: Finding) {
        let counts = &mut self.counts;
        match finding.treatment {
            Treatment::Read => counts.read += 1,
            Treatment::Defaulted => counts.defaulted += 1,
            Treatment::AsWritten => counts.as_written += 1,
            Treatment::Repaired => counts.repaired += 1,
            Treatment::Ignored { physics } => {
                counts.ignored += 1;
                counts.ignored_physics += usize::from(physics);
            }
            Treatment::Refused => {}
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

    /// Adds files that the robot comes from, each once: with links followed where the file is there.
    ///
    /// ```
    /// use std::path::Path;
    /// let mut report = multibody::LoadReport::default();
    /// report.add_files([Path::new("robot.urdf"), Path::new("./robot.urdf")]);
    /// assert!(report.files.len() == 1 && report.files[0].is_absolute());
    /// ```
    pub fn add_files<'a>(&mut self, paths: impl IntoIterator<Item = &'a Path>) {
        // Many shapes may name one mesh: the system is asked once.
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

    /// Puts the findings in the order of the file's lines, those of a line as they were added.
    pub fn sort(&mut self) {
        self.findings.sort_by_key(|finding| finding.line);
    }

    /// The findings of that severity.
    pub fn of_severity(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |finding| finding.severity == severity)
    }

    /// The findings that deserve a look: suspicious values, replaced ones, and physics that is not in the model.
    pub fn warnings(&self) -> impl Iterator<Item = &Finding> {
        self.of_severity(Severity::Warning)
    }

    /// The findings of ignored things that change how the robot moves.
    pub fn ignored_physics(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.treatment == Treatment::Ignored { physics: true })
    }
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { links, joints, degrees_of_freedom, not_dynamics, unlisted, .. } = self.counts;
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
        for Finding { line, place, treatment, message, .. } in &self.findings {
            let (place, message) = (one_line(place), one_line(message));
            writeln!(f, "{line:>6}  {treatment:<15}  {place}: {message}")?;
        }
        if unlisted > 0 {
            writeln!(f, "        and {unlisted} more")?;
        }
        Ok(())
    }
}

impl Counts {
    /// How the file's parts were treated, in one line.
    pub fn sums(&self) -> String {
        let Self { read, defaulted, as_written, repaired, ignored, ignored_physics, .. } = self;
        format!(
            "{read} read, {defaulted} defaulted, {as_written} suspicious but taken as written, {repaired} repaired, \
             {ignored} ignored ({ignored_physics} of them physics)"
        )
    }
}

impl fmt::Display for Treatment {
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

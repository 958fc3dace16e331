//! What became of every part of a robot file.

use core::fmt;

use serde::{Deserialize, Serialize};

/// The account of a loaded file: nothing in it was lost without an entry here.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoadReport {
    /// The robot's name.
    pub robot: String,
    /// The sums.
    pub counts: Counts,
    /// In the order of the file's lines.
    pub entries: Vec<Entry>,
}

/// How many of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Links.
    pub links: usize,
    /// Joints of every type, fixed ones included.
    pub joints: usize,
    /// Independent velocities: joints that follow another add none, a floating base adds six.
    pub degrees_of_freedom: usize,
    /// Entries of things read.
    pub read: usize,
    /// Entries of values the file leaves out.
    pub defaulted: usize,
    /// Entries of values replaced because no robot has them.
    pub repaired: usize,
    /// Entries of things ignored, physics or not.
    pub ignored: usize,
    /// Entries of ignored things that change how the robot moves.
    pub ignored_physics: usize,
    /// Elements `visual`, `collision` and `material`: shape, not dynamics. They have no entries.
    pub not_dynamics: usize,
    /// Entries counted above but not listed, because a file had more of them than [`LoadReport::LISTED`].
    pub unlisted: usize,
}

/// What became of one element or attribute.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Its line in the file, from 1.
    pub line: usize,
    /// The element, as in `joint "elbow"/limit`.
    pub place: String,
    /// Read, defaulted, repaired or ignored.
    pub treatment: Treatment,
    /// In plain words.
    pub message: String,
}

/// What became of a part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Treatment {
    /// Its values are in the model.
    Read,
    /// The file leaves it out; the message says what was taken.
    Defaulted,
    /// No rigid body has what the file says; the message tells what was taken instead.
    Repaired,
    /// It is not in the model.
    Ignored {
        /// Whether it changes how the robot moves.
        physics: bool,
    },
}

impl LoadReport {
    /// The most entries that are listed one by one; beyond it they are only counted.
    pub const LISTED: usize = 2_000_000;

    /// The entries of ignored things that change how the robot moves.
    pub fn ignored_physics(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|entry| entry.treatment == Treatment::Ignored { physics: true })
    }

    pub(crate) fn push(&mut self, entry: Entry) {
        match entry.treatment {
            Treatment::Read => self.counts.read += 1,
            Treatment::Defaulted => self.counts.defaulted += 1,
            Treatment::Repaired => self.counts.repaired += 1,
            Treatment::Ignored { physics } => {
                self.counts.ignored += 1;
                self.counts.ignored_physics += usize::from(physics);
            }
        }
        if self.entries.len() < Self::LISTED {
            self.entries.push(entry);
        } else {
            self.counts.unlisted += 1;
        }
    }
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts {
            links,
            joints,
            degrees_of_freedom,
            read,
            defaulted,
            repaired,
            ignored,
            ignored_physics,
            not_dynamics,
            unlisted,
        } = self.counts;
        writeln!(
            f,
            "robot {:?}: {links} links, {joints} joints, {degrees_of_freedom} degrees of freedom",
            self.robot
        )?;
        writeln!(
            f,
            "{read} read, {defaulted} defaulted, {repaired} repaired, {ignored} ignored ({ignored_physics} of them physics); \
             {not_dynamics} visual, collision or material elements, which dynamics does not need"
        )?;
        for Entry { line, place, treatment, message } in &self.entries {
            writeln!(f, "{line:>6}  {treatment:<15}  {place}: {message}")?;
        }
        if unlisted > 0 {
            writeln!(f, "        and {unlisted} more")?;
        }
        Ok(())
    }
}

impl fmt::Display for Treatment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Read => "read",
            Self::Defaulted => "defaulted",
            Self::Repaired => "REPAIRED",
            Self::Ignored { physics: false } => "ignored",
            Self::Ignored { physics: true } => "IGNORED PHYSICS",
        })
    }
}

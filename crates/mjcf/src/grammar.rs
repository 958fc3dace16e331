//! The table of all elements and attributes of MJCF, and whether they are read.
//!
//! The report of what is not read ([`crate::unread_parts`]) follows this table, so an attribute that is read
//! must be listed here.

mod bodies;
mod rule;
mod sections;
mod sensors;

pub(crate) use rule::{Handling, Rule};

/// The rule for an element of this name within another.
pub(crate) fn rule_of(name: &str, within: &str) -> Option<&'static Rule> {
    sections::RULES
        .iter()
        .chain(bodies::RULES)
        .chain(sensors::RULES)
        .find(|rule| rule.name == name && rule.within.contains(&within))
}

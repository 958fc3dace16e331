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

#[cfg(test)]
mod tests {
    use super::{Handling, bodies, rule_of, sections, sensors};

    /// The elements and attributes of MuJoCo 4.0.0: a line `PARENT NAME: ATTRIBUTES` for each element, from
    /// the list of its schema. `default` is the parent of all elements within it.
    const SCHEMA: &str = include_str!("grammar/schema.txt");

    /// The grammar knows every element whose parent is read, and every attribute of an element that is read.
    #[test]
    fn the_grammar_knows_the_schema_of_mujoco() {
        let (mut elements, mut attributes) = (0, 0);
        let mut unknown = Vec::new();
        let rules = || sections::RULES.iter().chain(bodies::RULES).chain(sensors::RULES);
        let is_read = |parent: &str| {
            parent == "mujoco" || rules().any(|rule| rule.name == parent && rule.handling == Handling::Read)
        };
        for line in SCHEMA.lines() {
            let (path, words) = line.split_once(':').expect("a line PARENT NAME: ATTRIBUTES");
            let (parent, name) = path.split_once(' ').expect("a parent and a name");
            if !is_read(parent) {
                continue;
            }
            let Some(rule) = rule_of(name, parent) else {
                unknown.push(path.to_owned());
                continue;
            };
            elements += 1;
            if rule.handling != Handling::Read {
                continue;
            }
            for word in words.split_ascii_whitespace() {
                attributes += 1;
                let known = rule.read.contains(&word)
                    || rule.ignored.contains(&word)
                    || rule.physics.iter().any(|(name, _)| *name == word);
                if !known {
                    unknown.push(format!("{path}: {word}"));
                }
            }
        }
        assert!(elements > 100 && attributes > 500, "{elements} {attributes}");
        assert!(unknown.is_empty(), "{unknown:#?}");
    }
}

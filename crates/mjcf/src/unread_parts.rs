//! Reports the elements and attributes that are not read, and whether they affect the motion.

use robot_dynamics_description::Disposition;
use robot_dynamics_xml::excerpt;

use crate::grammar::{Handling, Rule, rule_of};
use crate::reader::Reader;
use crate::tree::{Id, Tree};

impl Reader<'_> {
    /// Adds one finding for each part that is not read. Appearance, and settings of contact and solvers, are
    /// only counted.
    pub(crate) fn list_unread(&mut self) {
        let tree = self.tree;
        for (file, line, text) in &tree.loose_text {
            let place = crate::tree::in_file_place(&tree.files[*file], "text");
            let message = format!("stray text {text:?}");
            self.push(*line, place, Disposition::Ignored { physics: false }, message);
        }
        for attribute in &tree.nodes[Tree::ROOT].attributes {
            if attribute.0 != "model" {
                self.note(Tree::ROOT, format!("unknown attribute {}", excerpt(&attribute.0)));
            }
        }
        for (node, why) in &tree.omissions {
            self.note(*node, (*why).to_owned());
        }
        // Elements with the names of their parents.
        let mut pending: Vec<(Id, &str)> = Vec::new();
        let push = |pending: &mut Vec<_>, parent: Id| {
            let children = tree.nodes[parent].children.iter().rev();
            pending.extend(children.map(|&child| (child, tree.nodes[parent].name.as_str())));
        };
        push(&mut pending, Tree::ROOT);
        // The copies of attached models are reported with the main file. Only unknown sections and those of
        // physics that is not in the model remain.
        for model in tree.models.iter().skip(1) {
            let own = |&&id: &&Id| {
                let rule = rule_of(&tree.nodes[id].name, "mujoco");
                rule.is_none_or(|rule| matches!(rule.handling, Handling::Physics(_)))
            };
            let strange = tree.nodes[model.root].children.iter().filter(own);
            pending.extend(strange.map(|&id| (id, "mujoco")));
        }
        while let Some((node, parent)) = pending.pop() {
            let name = tree.nodes[node].name.as_str();
            let Some(rule) = rule_of(name, parent) else {
                self.unknown_element(node, parent);
                continue;
            };
            match rule.handling {
                Handling::Read => {
                    self.list_attributes(node, rule);
                    push(&mut pending, node);
                }
                Handling::Appearance => self.report.counts.not_dynamics += self.count(node),
                Handling::NotDynamics(what) => self.note(node, what.to_owned()),
                Handling::Physics(what) => {
                    let (line, place) = (tree.nodes[node].line, self.place(node));
                    self.push(line, place, Disposition::Ignored { physics: true }, what.to_owned());
                }
            }
        }
    }

    /// The number of elements in a subtree.
    fn count(&self, node: Id) -> usize {
        let (mut count, mut pending) = (0, vec![node]);
        while let Some(node) = pending.pop() {
            count += 1;
            pending.extend(&self.tree.nodes[node].children);
        }
        count
    }

    fn note(&mut self, node: Id, message: String) {
        let (line, place) = (self.tree.nodes[node].line, self.place(node));
        self.push(line, place, Disposition::Ignored { physics: false }, message);
    }

    fn unknown_element(&mut self, node: Id, parent: &str) {
        let (line, place) = (self.tree.nodes[node].line, self.place(node));
        let message = format!("unknown element in <{parent}>: not read, perhaps physics");
        self.push(line, place, Disposition::Ignored { physics: true }, message);
    }

    fn list_attributes(&mut self, node: Id, rule: &Rule) {
        let tree = self.tree;
        for (name, value) in &tree.nodes[node].attributes {
            let name = name.as_str();
            if rule.read.contains(&name) {
                continue;
            }
            if rule.ignored.contains(&name) {
                self.report.counts.not_dynamics += 1;
                continue;
            }
            let shown = format!("{}={:?}", excerpt(name), excerpt(value));
            let message = match rule.physics.iter().find(|(physics, _)| *physics == name) {
                Some((_, neutral)) if does_nothing(value, neutral) => {
                    self.note(node, format!("{shown} has no effect"));
                    continue;
                }
                Some(_) => format!("{shown} is not in the model"),
                None => format!("unknown attribute {shown}: not read, perhaps physics"),
            };
            let (line, place) = (tree.nodes[node].line, self.place(node));
            self.push(line, place, Disposition::Ignored { physics: true }, message);
        }
    }
}

/// Whether the value is the neutral word, or consists of neutral numbers.
fn does_nothing(value: &str, neutral: &str) -> bool {
    let number = neutral.parse::<f64>().ok();
    value.trim() == neutral
        || number.is_some_and(|number| {
            value.split_ascii_whitespace().all(|word| word.parse::<f64>().is_ok_and(|found| found == number))
        })
}

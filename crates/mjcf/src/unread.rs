//! What a file holds beyond what is read: listed, and judged whether it is physics.

use multibody::Treatment;
use robot_xml::excerpt;

use crate::grammar::{Rule, Sort, rule_of};
use crate::reader::Reader;
use crate::tree::{Id, Tree};

impl Reader<'_> {
    /// One finding for everything that is not read; looks, and settings of contact and solvers, are counted.
    pub(crate) fn list_unread(&mut self) {
        let tree = self.tree;
        for (file, line, text) in &tree.loose {
            let place = crate::source::in_file_place(&tree.files[*file], "text");
            let message = format!("loose text {text:?}");
            self.push(*line, place, Treatment::Ignored { physics: false }, message);
        }
        for attribute in &tree.nodes[Tree::ROOT].attributes {
            if attribute.0 != "model" {
                self.note(Tree::ROOT, format!("unknown attribute {}", excerpt(&attribute.0)));
            }
        }
        for (node, why) in &tree.left {
            self.note(*node, (*why).to_owned());
        }
        // Each with the name of the element that it is in.
        let mut pending: Vec<(Id, &str)> = Vec::new();
        let push = |pending: &mut Vec<_>, parent: Id| {
            let children = tree.nodes[parent].children.iter().rev();
            pending.extend(children.map(|&child| (child, tree.nodes[parent].name.as_str())));
        };
        push(&mut pending, Tree::ROOT);
        // Of models that are attached, what their copies have is told once, with those.
        for model in tree.models.iter().skip(1) {
            let own = |&&id: &&Id| {
                let rule = rule_of(&tree.nodes[id].name, "mujoco");
                rule.is_none_or(|rule| matches!(rule.sort, Sort::Physics(_)))
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
            match rule.sort {
                Sort::Read => {
                    self.list_attributes(node, rule);
                    push(&mut pending, node);
                }
                Sort::Looks => self.report.counts.not_dynamics += self.count(node),
                Sort::Aside(what) => self.note(node, what.to_owned()),
                Sort::Physics(what) => {
                    let (line, place) = (tree.nodes[node].line, self.place(node));
                    self.push(line, place, Treatment::Ignored { physics: true }, what.to_owned());
                }
            }
        }
    }

    /// An element and all in it.
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
        self.push(line, place, Treatment::Ignored { physics: false }, message);
    }

    fn unknown_element(&mut self, node: Id, parent: &str) {
        let (line, place) = (self.tree.nodes[node].line, self.place(node));
        let message =
            format!("an element that <{parent}> of the format does not have: not read, perhaps physics");
        self.push(line, place, Treatment::Ignored { physics: true }, message);
    }

    fn list_attributes(&mut self, node: Id, rule: &Rule) {
        let tree = self.tree;
        for (name, value) in &tree.nodes[node].attributes {
            let name = name.as_str();
            if rule.read.contains(&name) {
                continue;
            }
            if rule.aside.contains(&name) {
                self.report.counts.not_dynamics += 1;
                continue;
            }
            let shown = format!("{}={:?}", excerpt(name), excerpt(value));
            let message = match rule.physics.iter().find(|(physics, _)| *physics == name) {
                Some((_, neutral)) if does_nothing(value, neutral) => {
                    self.note(node, format!("{shown} does nothing"));
                    continue;
                }
                Some(_) => format!("{shown} is not in the model"),
                None => format!(
                    "{shown}: an attribute that the format does not have here: not read, perhaps physics"
                ),
            };
            let (line, place) = (tree.nodes[node].line, self.place(node));
            self.push(line, place, Treatment::Ignored { physics: true }, message);
        }
    }
}

/// Whether the value is the neutral word, or numbers that are all the neutral one.
fn does_nothing(value: &str, neutral: &str) -> bool {
    let number = neutral.parse::<f64>().ok();
    value.trim() == neutral
        || number.is_some_and(|number| {
            value.split_ascii_whitespace().all(|word| word.parse::<f64>().is_ok_and(|found| found == number))
        })
}

//! `<attach>`: copies parts of other files, or of the same file, under new names. This module also copies the
//! elements outside bodies that refer to replicated bodies.
//!
//! As in MuJoCo the attachments are made in the order of the file. Every name in a copied part gets a prefix.
//! The equalities, actuators and sensors of the attached file are copied if all names in them exist by then.
//! Tendons and contact pairs are copied if at least one of their names exists.

mod copies;
mod part;

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use robot_dynamics_xml::{Resource, excerpt};

use crate::MjcfError;
use crate::renaming::{OUTER_SECTIONS, ObjectKind, Renaming, asset_name, names_in, of_element};
use crate::source::Source;
use crate::tree::in_file_place;
use crate::tree::{Id, Node, Origin, Tree};

/// Bodies and frames by name, with the `childclass` that applies to each.
type Parts = HashMap<(ObjectKind, String), (Id, Option<Rc<str>>)>;

/// The size of a name beside its characters, in the number of characters.
const NAME_SIZE: usize = 32;

/// The expansion of all attachments in one model.
struct Expansion<'s> {
    source: &'s mut Source,
    root: Id,
    /// The roots of the models in `<asset>`, by name.
    assets: HashMap<String, Id>,
    /// The names that exist so far.
    names: HashSet<(ObjectKind, String)>,
    /// The bodies and frames that exist so far.
    parts: Parts,
    /// The bodies, frames and replicates around the current element.
    ancestors: HashSet<Id>,
    /// For each replicate around the current element the names in it.
    replicate_names: Vec<Vec<(ObjectKind, String)>>,
    /// The bodies and frames of each attached model.
    parts_of: HashMap<Id, Parts>,
    /// The new names of the classes of each attached model, by prefix.
    classes: HashMap<(Id, String), HashMap<String, String>>,
    class_names: HashSet<String>,
    /// The meshes and other assets that exist, by kind and name.
    asset_names: HashSet<(String, String)>,
}

/// The part that an `<attach>` copies.
struct AttachedPart {
    /// The root of its model.
    model: Id,
    prefix: String,
    /// The elements to copy.
    elements: Vec<Id>,
    /// The `childclass` at their original place.
    childclass: Option<Rc<str>>,
}

enum Step {
    Enter(Id, Option<Rc<str>>),
    Leave(Id),
}

impl Source {
    /// Expands all attachments in the model with this root, after those in the models that it names.
    pub(crate) fn attach(&mut self, root: Id) {
        let mut expansion = Expansion {
            source: self,
            root,
            assets: HashMap::new(),
            names: HashSet::from([("body", "world".to_owned())]),
            parts: HashMap::new(),
            ancestors: HashSet::new(),
            replicate_names: Vec::new(),
            parts_of: HashMap::new(),
            classes: HashMap::new(),
            class_names: HashSet::new(),
            asset_names: HashSet::new(),
        };
        expansion.read_models();
        expansion.list_outer_names();
        expansion.walk();
    }
}

impl Expansion<'_> {
    fn tree(&self) -> &Tree {
        &self.source.tree
    }

    fn place(&self, id: Id) -> (usize, String) {
        let node = &self.tree().nodes[id];
        (node.line, in_file_place(&self.tree().files[node.file], &node.name))
    }

    fn refuse(&mut self, id: Id, reason: impl Into<String>) {
        let (line, place) = self.place(id);
        self.source.errors.push(MjcfError::Misplaced { line, place, reason: reason.into() });
    }

    fn refuse_unknown_name(&mut self, id: Id, what: &'static str, name: &str) {
        let (line, place) = self.place(id);
        self.source.errors.push(MjcfError::UnknownName { line, place, what, name: excerpt(name) });
    }

    /// Reads the models of `<asset>/<model>` and expands their attachments.
    fn read_models(&mut self) {
        for id in self.tree().in_sections_of(self.root, "asset") {
            if self.tree().nodes[id].name != "model" {
                continue;
            }
            let Some(child) = self.source.read_model(id) else { continue };
            let own = |id: Id, name| self.tree().nodes[id].attribute(name).filter(|name| !name.is_empty());
            let name = own(id, "name").or(own(child, "model")).unwrap_or("MuJoCo Model").to_owned();
            self.assets.entry(name).or_insert(child);
        }
    }

    /// Collects the names outside bodies, which MuJoCo reads before the bodies.
    fn list_outer_names(&mut self) {
        let tree = &self.source.tree;
        for section in OUTER_SECTIONS {
            for id in tree.in_sections_of(self.root, section) {
                self.names.extend(of_element(&tree.nodes[id], section));
            }
        }
        for id in tree.in_sections_of(self.root, "asset") {
            let node = &tree.nodes[id];
            self.asset_names.insert((node.name.clone(), asset_name(node)));
        }
        let mut pending: Vec<Id> = tree.children(self.root, "default").collect();
        while let Some(id) = pending.pop() {
            self.class_names.extend(tree.nodes[id].attribute("class").map(str::to_owned));
            pending.extend(tree.children(id, "default"));
        }
        self.class_names.insert("main".into());
    }

    /// Visits all bodies in the order of the file.
    fn walk(&mut self) {
        let sections: Vec<Id> = self.tree().children(self.root, "worldbody").collect();
        let mut pending: Vec<Step> = Vec::new();
        for &section in sections.iter().rev() {
            pending.extend(self.tree().nodes[section].children.iter().rev().map(|&id| Step::Enter(id, None)));
        }
        while let Some(step) = pending.pop() {
            if self.source.budget.is_exceeded() {
                return;
            }
            match step {
                Step::Enter(id, class) => {
                    let node = &self.source.tree.nodes[id];
                    let (name, children) = (node.name.clone(), node.children.clone());
                    let inner = node.attribute("childclass").map(Rc::from).or_else(|| class.clone());
                    if name == "attach" {
                        self.attach(id);
                        continue;
                    }
                    if let Some((kind, own)) = of_element(node, "worldbody") {
                        self.enter(id, (kind, own.clone()));
                        if matches!(kind, "body" | "frame") {
                            self.parts.insert((kind, own), (id, class.clone()));
                        }
                    }
                    if matches!(name.as_str(), "body" | "frame" | "replicate") {
                        self.ancestors.insert(id);
                        if name == "replicate" {
                            self.replicate_names.push(Vec::new());
                        }
                        pending.push(Step::Leave(id));
                        pending.extend(children.into_iter().rev().map(|id| Step::Enter(id, inner.clone())));
                    }
                }
                Step::Leave(id) => {
                    self.ancestors.remove(&id);
                    if self.tree().nodes[id].name == "replicate" {
                        self.replicate(id);
                    }
                }
            }
        }
    }

    /// Adds a name, on behalf of this element.
    fn enter(&mut self, id: Id, name: (ObjectKind, String)) {
        if !self.source.charge(id, Resource::Characters, name.1.len() + NAME_SIZE) {
            return;
        }
        if let Some(inside) = self.replicate_names.last_mut() {
            inside.push(name.clone());
        }
        self.names.insert(name);
    }

    /// Replaces an `<attach>` by a frame that contains the copied part.
    fn attach(&mut self, id: Id) {
        let Some(AttachedPart { model, prefix, elements, childclass }) = self.read_part(id) else {
            return;
        };
        self.source.tree.has_copies = true;
        let is_external = model != self.root;
        let is_first = is_external && !self.classes.contains_key(&(model, prefix.clone()));
        if is_first {
            self.attach_classes_and_assets(id, model, &prefix);
        }
        let classes = self.classes.get(&(model, prefix.clone())).cloned();
        let renaming = Renaming { prefix: &prefix, classes: classes.as_ref(), ..Renaming::default() };
        let mut copies = HashMap::new();
        let children: Vec<Id> =
            elements.into_iter().filter_map(|from| self.copy(from, &renaming, &mut copies)).collect();
        if !self.enter_copies(id, &children) {
            return;
        }
        let childclass = renaming.class(childclass.as_deref().unwrap_or("main"));
        let node = &mut self.source.tree.nodes[id];
        node.name = "frame".into();
        node.attributes = vec![("childclass".into(), childclass)];
        node.children = children;
        let actuators = self.attach_outer_sections(model, &renaming);
        if is_first {
            self.attach_poses(id, model, &renaming, (copies, actuators));
        }
    }

    /// Adds the names in the copies; returns false if they exceed the budget.
    fn enter_copies(&mut self, id: Id, copies: &[Id]) -> bool {
        for &copy in copies {
            let was_exceeded = self.source.budget.is_exceeded();
            match names_in(&mut self.source.budget, &self.source.tree, copy) {
                Ok(names) => names.into_iter().for_each(|name| self.enter(id, name)),
                Err(exceeded) => {
                    if !was_exceeded {
                        self.source.refuse_excess(id, exceeded);
                    }
                    return false;
                }
            }
        }
        true
    }

    /// Copies the elements outside bodies of a model. Returns the copy of each actuator, if it has one.
    fn attach_outer_sections(&mut self, model: Id, renaming: &Renaming<'_>) -> Vec<Option<Id>> {
        let mut actuators = Vec::new();
        for section in OUTER_SECTIONS {
            let elements = self.tree().in_sections_of(model, section);
            let copies = self.copy_outer(section, &elements, renaming);
            if section == "actuator" {
                actuators = elements.iter().map(|element| copies.get(element).copied()).collect();
            }
        }
        actuators
    }

    /// Copies the keyframes of a model, but not those of models that it attaches. `copies` maps the elements
    /// of the model to those in the frame.
    fn attach_poses(
        &mut self,
        frame: Id,
        child: Id,
        renaming: &Renaming<'_>,
        (mut copies, actuators): (HashMap<Id, Id>, Vec<Option<Id>>),
    ) {
        let mut keys = self.tree().in_sections_of(child, "keyframe");
        let is_own = |key: &Id| self.source.tree.nodes[*key].scope.is_none();
        let others: Vec<Id> = keys.iter().copied().filter(|key| !is_own(key)).collect();
        keys.retain(is_own);
        let why = "a keyframe of a model that an attached model attaches: not read";
        self.source.tree.omissions.extend(others.into_iter().map(|key| (key, why)));
        if keys.is_empty() {
            return;
        }
        let world = self.tree().in_sections_of(child, "worldbody");
        let (mut whole, mut attached) = (frame, HashMap::new());
        if world.iter().any(|own| !copies.contains_key(own)) {
            let mut all = HashMap::new();
            let children = world.iter().filter_map(|&from| self.copy(from, renaming, &mut all)).collect();
            let class = ("childclass".to_owned(), renaming.class("main"));
            let node = Node { attributes: vec![class], children, ..self.tree().nodes[frame].empty_copy() };
            whole = self.source.tree.push(node);
            attached = all.into_iter().filter_map(|(own, copy)| Some((copy, copies.remove(&own)?))).collect();
        }
        let origin = Origin { whole, attached, actuators };
        self.source.tree.origins.insert(frame, origin);
        for (_, copy) in self.copy_outer("keyframe", &keys, renaming) {
            self.source.tree.nodes[copy].scope = Some(frame);
        }
    }

    /// Copies the defaults and assets of a model, with the prefix.
    fn attach_classes_and_assets(&mut self, id: Id, child: Id, prefix: &str) {
        // A class whose name is in use gets a name that no file has.
        let tree = &self.source.tree;
        let mut pending: Vec<Id> = tree.children(child, "default").collect();
        let mut own = vec!["main".to_owned()];
        while let Some(id) = pending.pop() {
            own.extend(tree.nodes[id].attribute("class").map(str::to_owned));
            pending.extend(tree.children(id, "default"));
        }
        let mut classes = HashMap::new();
        for name in own {
            let mut here = format!("{prefix}{name}");
            while !classes.contains_key(&name) && !self.class_names.insert(here.clone()) {
                if !self.source.charge(id, Resource::Characters, here.len() + NAME_SIZE) {
                    return;
                }
                here.push('\u{1f}');
            }
            classes.entry(name).or_insert(here);
        }
        let renaming = Renaming { prefix, classes: Some(&classes), ..Renaming::default() };
        let mut sections: Vec<Id> = self.tree().children(child, "default").collect();
        // The outermost class exists even if the model has no <default>.
        let main = ("class".to_owned(), renaming.class("main"));
        let empty = Node { name: "default".into(), ..self.tree().nodes[child].empty_copy() };
        let model = empty.model;
        sections.insert(0, self.source.tree.push(empty));
        for section in sections {
            if let Some(copy) = self.copy(section, &renaming, &mut HashMap::new()) {
                let node = &mut self.source.tree.nodes[copy];
                // The sections of models that it attaches have class names of their own.
                if node.model == model {
                    node.attributes.retain(|(name, _)| name != "class");
                    node.attributes.push(main.clone());
                }
                self.source.tree.nodes[self.root].children.push(copy);
            }
        }
        let assets = self.tree().in_sections_of(child, "asset");
        let section = Node { name: "asset".into(), ..self.tree().nodes[child].empty_copy() };
        let section = self.source.tree.push(section);
        for asset in
            assets.into_iter().filter(|&asset| self.tree().nodes[asset].name != "model").collect::<Vec<_>>()
        {
            let Some(copy) = self.copy_whole(asset, &renaming) else { break };
            let node = &self.source.tree.nodes[copy];
            let key = (node.name.clone(), asset_name(node));
            if matches!(key.0.as_str(), "mesh" | "hfield" | "material")
                && !self.asset_names.insert(key.clone())
            {
                let reason =
                    format!("the {} {:?} already exists; use another prefix", key.0, excerpt(&key.1));
                self.refuse(id, reason);
            }
            self.source.tree.nodes[section].children.push(copy);
        }
        self.source.tree.nodes[self.root].children.push(section);
        self.classes.insert((child, prefix.to_owned()), classes);
    }
}

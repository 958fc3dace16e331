//! The tree of all elements of a file and of the files that it includes or attaches.

use std::collections::HashMap;
use std::path::PathBuf;

/// The index of a node in a [`Tree`].
pub(crate) type Id = usize;

/// One element.
#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) children: Vec<Id>,
    /// The index of its file in [`Tree::files`].
    pub(crate) file: usize,
    /// The line, from 1.
    pub(crate) line: usize,
    /// The index of its model in [`Tree::models`].
    pub(crate) model: usize,
    /// For a keyframe of an attached model the frame that contains the attached part.
    pub(crate) scope: Option<Id>,
}

impl Node {
    /// The text of an attribute of this element, without defaults.
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// An element with the same name and place, without attributes and children.
    pub(crate) fn empty_copy(&self) -> Self {
        let (attributes, children) = (Vec::new(), Vec::new());
        Self { name: self.name.clone(), attributes, children, ..*self }
    }
}

/// Elements by index, the outermost first.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    /// The names of the files; that of the main file is empty.
    pub(crate) files: Vec<String>,
    /// Text between elements, which MJCF does not have: file, line, text.
    pub(crate) loose_text: Vec<(usize, usize, String)>,
    /// The main file and the attached models.
    pub(crate) models: Vec<ModelFile>,
    /// The origin of each attached part, by the frame that contains it.
    pub(crate) origins: HashMap<Id, Origin>,
    /// Elements of attached models that were not copied, with the reason.
    pub(crate) omissions: Vec<(Id, &'static str)>,
    /// Whether a part was attached, or an element outside bodies was replicated.
    pub(crate) has_copies: bool,
}

/// The model of an attached part.
#[derive(Debug)]
pub(crate) struct Origin {
    /// A frame with everything in the world of the model. If only a part was attached, the frame is not in
    /// the tree.
    pub(crate) whole: Id,
    /// Maps elements of `whole` to their copies in the tree.
    pub(crate) attached: HashMap<Id, Id>,
    /// The copies of its actuators in the tree.
    pub(crate) actuators: Vec<Option<Id>>,
}

/// A file with the files that it includes.
#[derive(Debug)]
pub(crate) struct ModelFile {
    pub(crate) root: Id,
    /// Its folder, relative to that of the main file.
    pub(crate) folder: PathBuf,
}

impl Tree {
    /// The outermost element, `<mujoco>`.
    pub(crate) const ROOT: Id = 0;

    /// The children of this name.
    pub(crate) fn children<'t>(&'t self, parent: Id, name: &'t str) -> impl Iterator<Item = Id> + 't {
        self.nodes[parent].children.iter().copied().filter(move |&child| self.nodes[child].name == name)
    }

    /// Adds a node without a parent.
    pub(crate) fn push(&mut self, node: Node) -> Id {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// The children of all sections of this name, in the model with this root.
    pub(crate) fn in_sections_of(&self, root: Id, section: &str) -> Vec<Id> {
        self.children(root, section)
            .flat_map(|section| self.nodes[section].children.iter().copied())
            .collect()
    }

    /// The children of all sections of this name, in the main model.
    pub(crate) fn in_sections<'t>(&'t self, section: &'t str) -> impl Iterator<Item = Id> + 't {
        self.children(Self::ROOT, section).flat_map(|section| self.nodes[section].children.iter().copied())
    }
}

/// A place in an included file, or, with an empty file name, in the main file.
pub(crate) fn in_file_place(file: &str, place: &str) -> String {
    if file.is_empty() { place.to_owned() } else { format!("{file}: {place}") }
}

//! All elements of a file and of the files that it includes, in one tree.

use std::collections::HashMap;
use std::path::PathBuf;

/// Which node of a [`Tree`].
pub(crate) type Id = usize;

/// One element.
#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) children: Vec<Id>,
    /// Which of [`Tree::files`] it is in.
    pub(crate) file: usize,
    /// From 1.
    pub(crate) line: usize,
    /// Which of [`Tree::models`] it is of.
    pub(crate) model: usize,
    /// Of a pose that came with an attachment: the frame that holds what was attached.
    pub(crate) scope: Option<Id>,
}

impl Node {
    /// The attribute's text, of this element alone.
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// An element of this name and place, with nothing in it.
    pub(crate) fn bare(&self) -> Self {
        let (attributes, children) = (Vec::new(), Vec::new());
        Self { name: self.name.clone(), attributes, children, ..*self }
    }
}

/// Elements by number, the outermost first.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    /// The included files as they are named, behind an empty name for the main file.
    pub(crate) files: Vec<String>,
    /// Text between elements, which MJCF has none of: file, line, text.
    pub(crate) loose: Vec<(usize, usize, String)>,
    /// The main file, and the models that it attaches parts of.
    pub(crate) models: Vec<ModelFile>,
    /// By the frame that holds what was attached, what it is of.
    pub(crate) origins: HashMap<Id, Origin>,
    /// Elements of attached models that did not come with them, and why.
    pub(crate) left: Vec<(Id, &'static str)>,
    /// Whether something was attached, or an element outside bodies replicated.
    pub(crate) grown: bool,
}

/// The model that a part was attached of.
#[derive(Debug)]
pub(crate) struct Origin {
    /// A frame with all that is in its world; where only a part was attached, one that is nowhere in the tree.
    pub(crate) whole: Id,
    /// Where each element of the whole is in the tree, if it is.
    pub(crate) attached: HashMap<Id, Id>,
    /// Its actuators, as they are in the tree.
    pub(crate) actuators: Vec<Option<Id>>,
}

/// A file with those that it includes.
#[derive(Debug)]
pub(crate) struct ModelFile {
    pub(crate) root: Id,
    /// Its folder, in that of the main file.
    pub(crate) folder: PathBuf,
}

impl Tree {
    /// The outermost element, `<mujoco>`.
    pub(crate) const ROOT: Id = 0;

    /// The children of this name.
    pub(crate) fn children<'t>(&'t self, parent: Id, name: &'t str) -> impl Iterator<Item = Id> + 't {
        self.nodes[parent].children.iter().copied().filter(move |&child| self.nodes[child].name == name)
    }

    /// Adds a node that is in no other yet.
    pub(crate) fn push(&mut self, node: Node) -> Id {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// The children of all sections of this name of the model with this root.
    pub(crate) fn in_sections_of(&self, root: Id, section: &str) -> Vec<Id> {
        self.children(root, section)
            .flat_map(|section| self.nodes[section].children.iter().copied())
            .collect()
    }

    /// The children of all sections of this name.
    pub(crate) fn in_sections<'t>(&'t self, section: &'t str) -> impl Iterator<Item = Id> + 't {
        self.children(Self::ROOT, section).flat_map(|section| self.nodes[section].children.iter().copied())
    }
}

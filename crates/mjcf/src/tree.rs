//! All elements of a file and of the files that it includes, in one tree.

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
}

impl Node {
    /// The attribute's text, of this element alone.
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
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
}

impl Tree {
    /// The outermost element, `<mujoco>`.
    pub(crate) const ROOT: Id = 0;

    /// The children of this name.
    pub(crate) fn children<'t>(&'t self, parent: Id, name: &'t str) -> impl Iterator<Item = Id> + 't {
        self.nodes[parent].children.iter().copied().filter(move |&child| self.nodes[child].name == name)
    }

    /// The children of all sections of this name.
    pub(crate) fn in_sections<'t>(&'t self, section: &'t str) -> impl Iterator<Item = Id> + 't {
        self.children(Self::ROOT, section).flat_map(|section| self.nodes[section].children.iter().copied())
    }
}

//! From a file, with the files that it includes, to one tree of elements.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use robot_xml::roxmltree::{Document, Node as XmlNode};
use robot_xml::{Lines, excerpt};

use crate::MjcfError;
use crate::folder::{FileSet, Folder};
use crate::renaming::OUTER;
use crate::tree::{Id, ModelFile, Node, Tree};

/// Deepest nesting in one file, as in MuJoCo's own parser.
const DEPTH_LIMIT: usize = 500;
/// Deepest chain of files that include one another.
const INCLUDE_LIMIT: usize = 50;

/// What reading the files gave.
#[derive(Default)]
pub(crate) struct Source {
    pub(crate) tree: Tree,
    /// What was mended: file, line, message.
    pub(crate) faults: Vec<(usize, usize, String)>,
    pub(crate) errors: Vec<MjcfError>,
    /// The main file's folder, which relative names start from; `None` for a text.
    pub(crate) folder: Option<Folder>,
    included: HashSet<PathBuf>,
    bytes: usize,
    /// Elements that attachments and replicates have made.
    pub(crate) copied: usize,
    /// The models that are being read, each named by the one before it.
    open: Vec<PathBuf>,
    /// Which model is being read.
    model: usize,
}

impl Source {
    /// The main file, its folder known or not.
    pub(crate) fn read(text: &str, path: Option<&Path>, given: Option<&FileSet>) -> Result<Self, MjcfError> {
        let folder = path.map(|path| Folder::of(path, given));
        let mut source = Self { folder, bytes: text.len(), ..Self::default() };
        if let Some(name) = path.and_then(Path::file_name) {
            source.included.insert(name.into());
            source.open.push(name.into());
        }
        source.tree.files.push(String::new());
        source.tree.models.push(ModelFile { root: Tree::ROOT, folder: PathBuf::new() });
        robot_xml::parse(text, DEPTH_LIMIT, |document, faults| {
            let root = document.root_element();
            let found = root.tag_name().name();
            if found != "mujoco" {
                let line = Lines::of(document.input_text()).line(root.range().start);
                let advice = match found {
                    "robot" => "this is URDF; read it with `urdf::load`",
                    "mujocoinclude" => {
                        "this is a part of a model, which another file includes; load that file"
                    }
                    "sdf" | "world" | "model" => "SDF files are not read; export URDF or MJCF",
                    _ => "an MJCF file holds one <mujoco> element",
                };
                return Err(MjcfError::NotMjcf { line, found: excerpt(found), advice });
            }
            source.take(document, faults, 0, None, &[]);
            Ok(())
        })
        .map_err(|source| MjcfError::Xml { file: String::new(), source })??;
        let has = |names: &[&str]| source.tree.nodes.iter().any(|node| names.contains(&node.name.as_str()));
        if has(&["attach", "model"]) || (has(&["replicate"]) && has(&OUTER)) {
            source.attach(Tree::ROOT);
        }
        Ok(source)
    }

    /// Adds a document's elements: the root itself, or, for an included file, its children to `parent`. `folders` are
    /// those of the files on the way here, in the main file's folder.
    fn take(
        &mut self,
        document: &Document<'_>,
        faults: &[(usize, String)],
        file: usize,
        parent: Option<Id>,
        folders: &[PathBuf],
    ) {
        self.faults.extend(faults.iter().map(|(line, message)| (file, *line, message.clone())));
        let lines = Lines::of(document.input_text());
        let line_of = |node: XmlNode<'_, '_>| lines.line(node.range().start);
        let root = document.root_element();
        // Children in reverse on a stack come out in order; an include is followed where it stands.
        let mut pending: Vec<(XmlNode<'_, '_>, Option<Id>)> = Vec::new();
        match parent {
            None => pending.push((root, None)),
            Some(_) => pending.extend(root.children().rev().map(|child| (child, parent))),
        }
        while let Some((node, parent)) = pending.pop() {
            if !node.is_element() {
                let text = node.text().filter(|_| node.is_text()).unwrap_or_default().trim();
                if !text.is_empty() {
                    self.tree.loose.push((file, line_of(node), excerpt(text)));
                }
                continue;
            }
            if node.tag_name().name() == "include" {
                let parent = parent.unwrap_or(Tree::ROOT);
                self.include(node.attribute("file"), file, line_of(node), parent, folders);
                continue;
            }
            let id = self.tree.nodes.len();
            self.tree.nodes.push(Node {
                name: node.tag_name().name().to_owned(),
                attributes: node
                    .attributes()
                    .map(|attribute| (attribute.name().to_owned(), attribute.value().to_owned()))
                    .collect(),
                children: Vec::new(),
                file,
                line: line_of(node),
                model: self.model,
                scope: None,
            });
            if let Some(parent) = parent {
                self.tree.nodes[parent].children.push(id);
            }
            pending.extend(node.children().rev().map(|child| (child, Some(id))));
        }
    }

    /// `<include file>`: the children of the named file's outermost element take its place.
    fn include(&mut self, name: Option<&str>, file: usize, line: usize, parent: Id, folders: &[PathBuf]) {
        let in_file = self.tree.files[file].clone();
        let refuse = |reason: String| MjcfError::Include {
            line,
            place: in_file_place(&in_file, "include"),
            file: excerpt(name.unwrap_or_default()),
            reason,
        };
        match self.included_text(name, folders) {
            Err(reason) => self.errors.push(refuse(reason)),
            Ok((path, text)) => {
                let shown = path.display().to_string();
                let index = self.tree.files.len();
                self.tree.files.push(shown.clone());
                let mut folders = folders.to_vec();
                folders.push(path.parent().unwrap_or(Path::new("")).to_owned());
                let taken = robot_xml::parse(&text, DEPTH_LIMIT, |document, faults| {
                    self.take(document, faults, index, Some(parent), &folders);
                });
                if let Err(source) = taken {
                    self.errors.push(MjcfError::Xml { file: shown, source });
                }
            }
        }
    }

    /// The path in the main file's folder, and the text, of an included file; or why there is none.
    fn included_text(
        &mut self,
        name: Option<&str>,
        folders: &[PathBuf],
    ) -> Result<(PathBuf, String), String> {
        let name = name.filter(|name| !name.trim().is_empty()).ok_or("no file=\"NAME\"")?;
        let folder = self.folder.as_ref().ok_or("a text has no folder; load the file instead")?;
        if folders.len() >= INCLUDE_LIMIT {
            return Err(format!("files include one another more than {INCLUDE_LIMIT} deep"));
        }
        // As in MuJoCo: from the model's folder, else from that of the including file.
        let beside = folders.last().map(|folder| folder.join(name));
        let own = self.tree.models[self.model].folder.join(name);
        let candidates = core::iter::once(own).chain(beside);
        let mut paths = Vec::new();
        for candidate in candidates {
            paths.push(inside(&candidate).ok_or(
                "it leaves the folder of the main file; move it into that folder, or load a file above both",
            )?);
        }
        let found = paths.iter().find(|path| folder.has(&folder.join(path))).unwrap_or(&paths[0]);
        if !self.included.insert(found.clone()) {
            return Err("it is included already, by itself or another; a file is included once".into());
        }
        let text = folder.text(&folder.join(found))?;
        self.bytes += text.len();
        if self.bytes > robot_xml::SIZE_LIMIT {
            return Err(format!("all files together hold more than {} bytes", robot_xml::SIZE_LIMIT));
        }
        Ok((found.clone(), text))
    }
}

impl Source {
    /// `<asset>/<model file>`: the root of the file's elements, what it attaches itself in place; `None`, with an error, where
    /// there is none.
    pub(crate) fn read_model(&mut self, id: Id) -> Option<Id> {
        let node = &self.tree.nodes[id];
        let (name, line) = (node.attribute("file").unwrap_or_default().to_owned(), node.line);
        let place = in_file_place(&self.tree.files[node.file], "model");
        let refuse = |reason: String| MjcfError::Attach { line, place, file: excerpt(&name), reason };
        match self.model_text(&name) {
            Err(reason) => {
                self.errors.push(refuse(reason));
                None
            }
            Ok((path, text)) => {
                let shown = path.display().to_string();
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                let (file, model, root) =
                    (self.tree.files.len(), self.tree.models.len(), self.tree.nodes.len());
                self.tree.files.push(shown.clone());
                self.tree.models.push(ModelFile { root, folder });
                let outer = core::mem::replace(&mut self.model, model);
                let included = core::mem::replace(&mut self.included, HashSet::from([path.clone()]));
                self.open.push(path);
                let taken = robot_xml::parse(&text, DEPTH_LIMIT, |document, faults| {
                    let found = document.root_element().tag_name().name();
                    if found != "mujoco" {
                        let found = excerpt(found);
                        return Err(format!("its outermost element is <{found}>, not <mujoco>"));
                    }
                    self.take(document, faults, file, None, &[]);
                    Ok(())
                });
                let found = match taken {
                    Err(source) => Err(MjcfError::Xml { file: shown, source }),
                    Ok(Err(reason)) => Err(refuse(reason)),
                    Ok(Ok(())) => Ok(root),
                };
                if found.is_ok() {
                    self.attach(root);
                }
                self.open.pop();
                (self.model, self.included) = (outer, included);
                if found.is_err() {
                    self.tree.models.truncate(model);
                }
                found.map_err(|error| self.errors.push(error)).ok()
            }
        }
    }

    /// The path in the main file's folder, and the text, of a model's file; or why there is none.
    fn model_text(&mut self, name: &str) -> Result<(PathBuf, String), String> {
        if name.trim().is_empty() {
            return Err("no file=\"NAME\"".into());
        }
        let folder = self.folder.as_ref().ok_or("a text has no folder; load the file instead")?;
        if self.open.len() >= INCLUDE_LIMIT {
            return Err(format!("models attach one another more than {INCLUDE_LIMIT} deep"));
        }
        let path = inside(&self.tree.models[self.model].folder.join(name)).ok_or(
            "it leaves the folder of the main file; move it into that folder, or load a file above both",
        )?;
        if self.open.contains(&path) {
            return Err(
                "it names itself, or a model that names it: parts of it would be attached without end".into(),
            );
        }
        let text = folder.text(&folder.join(&path))?;
        self.bytes += text.len();
        if self.bytes > robot_xml::SIZE_LIMIT {
            return Err(format!("all files together hold more than {} bytes", robot_xml::SIZE_LIMIT));
        }
        Ok((path, text))
    }
}

/// A relative path without `.` and `..`; `None` for one that is absolute or leaves its start.
pub(crate) fn inside(path: &Path) -> Option<PathBuf> {
    let mut clean = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => clean.push(name),
            Component::CurDir => {}
            Component::ParentDir => {
                if !clean.pop() {
                    return None;
                }
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(clean)
}

/// The place of something in an included file, or, with an empty name, in the main one.
pub(crate) fn in_file_place(file: &str, place: &str) -> String {
    if file.is_empty() { place.to_owned() } else { format!("{file}: {place}") }
}

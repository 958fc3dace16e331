//! Reads a file and the files that it includes or attaches into one tree of elements.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use robot_dynamics_xml::roxmltree::{Document, Node as XmlNode};
use robot_dynamics_xml::{Budget, ExceededLimit, Lines, Resource, excerpt, spellings};

use crate::MjcfError;
use crate::folder::{FileSet, Folder};
use crate::renaming::OUTER_SECTIONS;
use crate::tree::{Id, ModelFile, Node, Tree, in_file_place};

/// The deepest nesting in one file, as in MuJoCo's parser.
const DEPTH_LIMIT: usize = 500;
/// The longest chain of files that include one another.
const INCLUDE_LIMIT: usize = 50;

/// The elements of all files, and the errors of reading them.
#[derive(Default)]
pub(crate) struct Source {
    pub(crate) tree: Tree,
    /// The repaired XML faults: file, line, message.
    pub(crate) faults: Vec<(usize, usize, String)>,
    pub(crate) errors: Vec<MjcfError>,
    /// The folder of the main file; `None` for a text.
    pub(crate) folder: Option<Folder>,
    included: HashSet<PathBuf>,
    bytes: usize,
    /// The limits that all steps of reading share.
    pub(crate) budget: Budget,
    /// The models that are being read; each is named by the one before it.
    model_stack: Vec<PathBuf>,
    /// The index of the model that is being read.
    model: usize,
}

impl Source {
    /// Reads the main file; `path` is `None` for a text.
    pub(crate) fn read(
        text: &str,
        path: Option<&Path>,
        given: Option<&FileSet>,
        confined: bool,
    ) -> Result<Self, MjcfError> {
        let folder = path.map(|path| Folder::of(path, given, confined));
        let mut source = Self { folder, bytes: text.len(), ..Self::default() };
        if let (Some(folder), Some(name)) = (&source.folder, path.and_then(Path::file_name)) {
            let file = folder.identity(&folder.join(Path::new(name)));
            source.included.insert(file.clone());
            source.model_stack.push(file);
        }
        source.tree.files.push(String::new());
        source.tree.models.push(ModelFile { root: Tree::ROOT, folder: PathBuf::new() });
        robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, faults| {
            let root = document.root_element();
            let found = root.tag_name().name();
            if found != "mujoco" {
                let line = Lines::of(document.input_text()).line(root.range().start);
                let advice = match found {
                    "robot" => "this is URDF; read it with `urdf::load`",
                    "mujocoinclude" => "another file includes this one; load that file",
                    "sdf" => "this is SDF; read it with `urdf::load`",
                    _ => "an MJCF file has one <mujoco> element",
                };
                return Err(MjcfError::NotMjcf { line, found: excerpt(found), advice });
            }
            source.add_document(document, faults, 0, None, &[]);
            Ok(())
        })
        .map_err(|source| MjcfError::Xml { file: String::new(), source })??;
        let has = |names: &[&str]| source.tree.nodes.iter().any(|node| names.contains(&node.name.as_str()));
        if has(&["attach", "model"]) || (has(&["replicate"]) && has(&OUTER_SECTIONS)) {
            source.attach(Tree::ROOT);
        }
        Ok(source)
    }

    /// Adds the elements of a document: its root, or, for an included file, the children of its root to
    /// `parent`. `folders` are the folders of the including files, relative to that of the main file.
    fn add_document(
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
        // A stack of reversed children gives the order of the file. An include is expanded in its place.
        let mut pending: Vec<(XmlNode<'_, '_>, Option<Id>)> = Vec::new();
        match parent {
            None => pending.push((root, None)),
            Some(_) => pending.extend(root.children().rev().map(|child| (child, parent))),
        }
        while let Some((node, parent)) = pending.pop() {
            if !node.is_element() {
                let text = node.text().filter(|_| node.is_text()).unwrap_or_default().trim();
                if !text.is_empty() {
                    self.tree.loose_text.push((file, line_of(node), excerpt(text)));
                }
                continue;
            }
            if node.tag_name().name() == "include" {
                let parent = parent.unwrap_or(Tree::ROOT);
                self.include(node.attribute("file"), file, line_of(node), parent, folders);
                continue;
            }
            let place = || in_file_place(&self.tree.files[file], &excerpt(node.tag_name().name()));
            let charged = self.budget.charge(Resource::Elements, 1);
            if let Err(ExceededLimit { what, limit }) = charged {
                let (line, place) = (line_of(node), place());
                self.errors.push(MjcfError::TooMany { line, place, what, limit });
                return;
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

    /// The identity of the file at this path, relative to the folder.
    fn identity(&self, path: &Path) -> PathBuf {
        let known = self.folder.as_ref().map(|folder| folder.identity(&folder.join(path)));
        known.unwrap_or_else(|| path.to_owned())
    }

    /// Adds a file to the number of bytes and of characters, or gives the reason for which it is too much.
    fn charge_file(&mut self, text: &str) -> Result<(), String> {
        self.bytes += text.len();
        if self.bytes > robot_dynamics_xml::SIZE_LIMIT {
            let limit = robot_dynamics_xml::SIZE_LIMIT;
            return Err(format!("all files together have more than {limit} bytes"));
        }
        let charged = self.budget.charge(Resource::Characters, text.len());
        charged.map_err(|ExceededLimit { what, limit }| format!("there are more than {limit} {what}"))
    }

    /// Charges the budget for a copy of this element; `false`, with an error, above the limit.
    pub(crate) fn charge(&mut self, id: Id, resource: Resource, count: usize) -> bool {
        let is_first = !self.budget.is_exceeded();
        let Err(exceeded) = self.budget.charge(resource, count) else { return true };
        if is_first {
            self.refuse_excess(id, exceeded);
        }
        false
    }

    /// Lists a limit that was exceeded at this element.
    pub(crate) fn refuse_excess(&mut self, id: Id, ExceededLimit { what, limit }: ExceededLimit) {
        let node = &self.tree.nodes[id];
        let (line, place) = (node.line, in_file_place(&self.tree.files[node.file], &excerpt(&node.name)));
        self.errors.push(MjcfError::TooMany { line, place, what, limit });
    }

    /// Replaces `<include file>` by the children of the outermost element of the file.
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
                let outcome = robot_dynamics_xml::parse(&text, DEPTH_LIMIT, |document, faults| {
                    self.add_document(document, faults, index, Some(parent), &folders);
                });
                if let Err(source) = outcome {
                    self.errors.push(MjcfError::Xml { file: shown, source });
                }
            }
        }
    }

    /// The path of an included file, relative to the folder of the main file, and its text; or the reason of
    /// the failure.
    fn included_text(
        &mut self,
        name: Option<&str>,
        folders: &[PathBuf],
    ) -> Result<(PathBuf, String), String> {
        let name = name.filter(|name| !name.trim().is_empty()).ok_or("the attribute `file` is missing")?;
        let folder = self.folder.as_ref().ok_or("a text has no folder; load the file instead")?;
        if folders.len() >= INCLUDE_LIMIT {
            return Err(format!("includes are nested more than {INCLUDE_LIMIT} deep"));
        }
        // As in MuJoCo: in the folder of the model, or in that of the including file.
        let around = core::iter::once(&self.tree.models[self.model].folder).chain(folders.last());
        let found = folder.locate(around.flat_map(|folder| spellings(name).map(|name| folder.join(name))));
        let path = folder.join(&found);
        if !self.included.insert(folder.identity(&path)) {
            return Err("it is included a second time, or by itself; a file can be included once".into());
        }
        let text = folder.text(&path)?;
        self.charge_file(&text)?;
        Ok((found, text))
    }
}

impl Source {
    /// Reads the file of `<asset>/<model>`, expands its attachments and returns its root; `None`, with an
    /// error, if it fails.
    pub(crate) fn read_model(&mut self, id: Id) -> Option<Id> {
        let node = &self.tree.nodes[id];
        let (name, line, named_in) =
            (node.attribute("file").unwrap_or_default().to_owned(), node.line, node.file);
        let place = in_file_place(&self.tree.files[node.file], "model");
        let refuse = |reason: String| MjcfError::Attach { line, place, file: excerpt(&name), reason };
        match self.model_text(&name, named_in) {
            Err(reason) => {
                self.errors.push(refuse(reason));
                None
            }
            Ok((path, text)) => {
                let shown = path.display().to_string();
                let file_id = self.identity(&path);
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                let (file, model, root) =
                    (self.tree.files.len(), self.tree.models.len(), self.tree.nodes.len());
                self.tree.files.push(shown.clone());
                self.tree.models.push(ModelFile { root, folder });
                let outer = core::mem::replace(&mut self.model, model);
                let included = core::mem::replace(&mut self.included, HashSet::from([file_id.clone()]));
                self.model_stack.push(file_id);
                let outcome = robot_dynamics_xml::parse(&text, DEPTH_LIMIT, |document, faults| {
                    let found = document.root_element().tag_name().name();
                    if found != "mujoco" {
                        let found = excerpt(found);
                        return Err(format!("its outermost element is <{found}>, not <mujoco>"));
                    }
                    self.add_document(document, faults, file, None, &[]);
                    Ok(())
                });
                let found = match outcome {
                    Err(source) => Err(MjcfError::Xml { file: shown, source }),
                    Ok(Err(reason)) => Err(refuse(reason)),
                    Ok(Ok(())) => Ok(root),
                };
                if found.is_ok() {
                    self.attach(root);
                }
                self.model_stack.pop();
                (self.model, self.included) = (outer, included);
                if found.is_err() {
                    self.tree.models.truncate(model);
                }
                found.map_err(|error| self.errors.push(error)).ok()
            }
        }
    }

    /// The path of a model's file, relative to the folder of the main file, and its text; or the reason of
    /// the failure.
    fn model_text(&mut self, name: &str, file: usize) -> Result<(PathBuf, String), String> {
        if name.trim().is_empty() {
            return Err("the attribute `file` is missing".into());
        }
        let folder = self.folder.as_ref().ok_or("a text has no folder; load the file instead")?;
        if self.model_stack.len() >= INCLUDE_LIMIT {
            return Err(format!("attached models are nested more than {INCLUDE_LIMIT} deep"));
        }
        // In the folder of the model, or in that of the file that names it.
        let beside = Path::new(&self.tree.files[file]).parent();
        let around = core::iter::once(self.tree.models[self.model].folder.as_path()).chain(beside);
        let found = folder.locate(around.flat_map(|folder| spellings(name).map(|name| folder.join(name))));
        let path = folder.join(&found);
        if self.model_stack.contains(&folder.identity(&path)) {
            return Err("it attaches itself, directly or through other models".into());
        }
        let text = folder.text(&path)?;
        self.charge_file(&text)?;
        Ok((found, text))
    }
}

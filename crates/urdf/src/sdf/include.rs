//! Reads `<include>`: the model of another file.

use std::path::{Path, PathBuf};

use robot_dynamics_description::Finding;
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Resource, excerpt};

use super::model::Overrides;
use super::parts::{Parts, Scope, Target};
use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The deepest nesting of elements in one file.
pub(super) const DEPTH_LIMIT: usize = 200;

/// The largest number of included models.
const INCLUDE_LIMIT: usize = 10_000;

/// The versions of SDF whose meaning is known.
pub(super) const VERSIONS: [(u32, u32); 2] = [(1, 4), (1, 12)];

impl Parts<'_> {
    /// Reads an `<include>` of a model or a world.
    pub(super) fn include<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        scope: &Scope,
        is_top: bool,
    ) {
        let known = ["uri", "name", "pose", "static", "placement_frame", "plugin"];
        reader.list_unread(element, &["merge"], &known, UnknownPart::Harmless);
        let uri = reader.required_child_text(element, "uri", "write <uri>model://NAME</uri> or a path");
        let name = reader.child_text(element, "name").map(|(_, name)| name.to_owned());
        let placed = element.node.children().any(|child| reader.is(child, "pose"));
        let written = reader.pose(element);
        let target = written.relative_to.map_or(Target::Id(scope.model), |name| scope.target(name));
        let placement = reader.child_text(element, "placement_frame").map(|(_, name)| name.to_owned());
        let overrides = Overrides {
            name: name.filter(|name| !name.is_empty()),
            pose: placed.then_some((target, written.pose)),
            is_static: reader.child_flag(element, "static"),
            placement_frame: placement.filter(|name| !name.is_empty()),
            merges: element.text("merge").and_then(|text| reader.flag(element, text)) == Some(true),
        };
        if uri.is_empty() {
            return;
        }
        self.includes += 1;
        if self.includes > INCLUDE_LIMIT {
            let (line, what) = (element.line, "included models");
            return reader.refuse(UrdfError::TooMany { line, what, limit: INCLUDE_LIMIT });
        }
        let (path, text) = match self.open(uri) {
            Ok(found) => found,
            Err(reason) => {
                let reason = format!("the model {:?} is not included: {reason}", excerpt(uri));
                return reader.refuse_sdf(element, reason);
            }
        };
        if !self.charge(reader, element, Resource::Characters, text.len()) {
            return;
        }
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let file = format!("{}: ", excerpt(&name));
        let outer =
            (core::mem::replace(&mut self.file, file.clone()), self.version, self.memory_path.clone());
        let beside = self.search.beside(&path);
        let search = core::mem::replace(&mut self.search, beside);
        if self.in_memory.is_some() {
            self.memory_path.clone_from(&path);
        } else {
            self.files.push(path);
        }
        let options = reader.options.clone();
        let read = robot_dynamics_xml::parse(&text, DEPTH_LIMIT, |document, faults| {
            let root = document.root_element();
            let mut inner = Reader::new(document.input_text(), root, options);
            for (line, message) in faults {
                inner.push(
                    *line,
                    "sdf".into(),
                    robot_dynamics_description::Disposition::AsWritten,
                    message.clone(),
                );
            }
            self.included(&mut inner, root, scope, is_top, &overrides);
            (inner.report.findings, inner.errors, inner.refused_warnings)
        });
        (self.file, self.version, self.memory_path) = outer;
        self.search = search;
        let in_file = |error: UrdfError| UrdfError::InFile { file: file.clone(), source: Box::new(error) };
        match read {
            Ok((findings, errors, warnings)) => {
                for finding in findings {
                    let place = format!("{file}{}", finding.place());
                    let moved = Finding::new(finding.line(), place, finding.disposition(), finding.message());
                    reader.report.add(moved);
                }
                reader.errors.extend(errors.into_iter().map(in_file));
                reader.refused_warnings.extend(warnings.into_iter().map(in_file));
            }
            Err(error) => reader.refuse(in_file(error.into())),
        }
    }

    fn included<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        root: Node<'a, 'a>,
        scope: &Scope,
        is_top: bool,
        overrides: &Overrides,
    ) {
        let element = Element { node: root, line: reader.line(root), place: "sdf".into() };
        let found = root.tag_name().name();
        if found != "sdf" {
            let advice = "an <include> names an SDF file; convert the file to SDF";
            return reader.refuse(UrdfError::NotARobot { line: element.line, found: excerpt(found), advice });
        }
        let count = root.descendants().filter(Node::is_element).count();
        if !self.charge(reader, &element, Resource::Elements, count) {
            return;
        }
        self.read_version(reader, &element);
        let Some(model) = reader.required_child(&element, "model", "an included file has one <model>") else {
            return;
        };
        let model = reader.named_element(model.node, "model");
        self.model(reader, &model, scope, is_top, overrides);
    }

    /// The version of the current file.
    pub(super) fn read_version<'a>(&mut self, reader: &mut Reader<'a>, root: &Element<'a>) {
        let [oldest, newest] = VERSIONS;
        let text = root.text("version").unwrap_or_default();
        let parsed = text
            .trim()
            .split_once('.')
            .and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
        self.version = match parsed {
            Some(version) if version >= oldest && version <= newest => version,
            Some(version) if version < oldest => {
                reader.warn(root, format!("version {text}: read as 1.4, the oldest that is known"));
                oldest
            }
            Some(_) => {
                reader.warn(root, format!("version {text}: read as 1.12, the newest that is known"));
                newest
            }
            None => {
                reader.warn(root, "no version: read as 1.12; write <sdf version=\"1.12\">");
                newest
            }
        };
    }

    /// The path and the text of an included file.
    fn open(&self, uri: &str) -> Result<(PathBuf, String), String> {
        if let Some(files) = self.in_memory {
            let candidates = memory_candidates(&self.memory_path, uri);
            let read =
                |path: &Path| files(path).and_then(|content| robot_dynamics_xml::text_of(&content).ok());
            for path in candidates {
                if let Some(text) = read(&path).filter(|_| path.extension().is_some()) {
                    return Ok((path, text));
                }
                let config = read(&path.join("model.config")).and_then(|text| main_file(&text));
                let names = config.into_iter().chain([String::from("model.sdf")]);
                let found =
                    names.map(|name| path.join(name)).find_map(|path| Some((path.clone(), read(&path)?)));
                if let Some(found) = found {
                    return Ok(found);
                }
            }
            return Err("it is not among the given files".to_owned());
        }
        if !self.locates {
            return Err("a text has no folder; load the file, or give a package path".to_owned());
        }
        let Some(found) = self.search.find_entry(uri) else {
            return Err(format!(
                "it was not found beside the file, in the folders above it, in the package path (--package-path), \
                 or in SDF_PATH, GZ_SIM_RESOURCE_PATH and GAZEBO_MODEL_PATH{}",
                self.search.confinement()
            ));
        };
        let path = if found.is_dir() {
            let config = found.join("model.config");
            let text =
                config.is_file().then(|| robot_dynamics_xml::read_regular_file(&config).ok()).flatten();
            let name = text.and_then(|text| main_file(&text)).unwrap_or_else(|| "model.sdf".into());
            let path = found.join(name);
            if !self.search.allows(&path) {
                return Err(format!("{} is missing or outside{}", path.display(), self.search.confinement()));
            }
            path
        } else {
            found
        };
        let text = robot_dynamics_xml::read_regular_file(&path).map_err(|error| error.to_string())?;
        Ok((path, text))
    }
}

/// The file with the newest known version in a `model.config`.
fn main_file(text: &str) -> Option<String> {
    let read = robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, _| {
        let files = document.root_element().children().filter(|child| child.has_tag_name("sdf"));
        let versions = files.filter_map(|file| {
            let version = file.attribute("version").unwrap_or("1.4");
            let (major, minor) = version.trim().split_once('.')?;
            let version: (u32, u32) = (major.parse().ok()?, minor.parse().ok()?);
            let name = file.text()?.trim().to_owned();
            (version <= VERSIONS[1] && !name.is_empty()).then_some((version, name))
        });
        versions.max().map(|(_, name)| name)
    });
    read.ok().flatten()
}

/// The paths in memory that a reference may mean, from the file at `from`.
fn memory_candidates(from: &Path, uri: &str) -> Vec<PathBuf> {
    let folder = from.parent().unwrap_or(Path::new(""));
    if let Some(name) = uri.strip_prefix("model://").or_else(|| uri.strip_prefix("package://")) {
        folder.ancestors().map(|above| above.join(name)).collect()
    } else {
        let name = uri.strip_prefix("file://").unwrap_or(uri);
        robot_dynamics_xml::spellings(name).map(|name| folder.join(name)).collect()
    }
}

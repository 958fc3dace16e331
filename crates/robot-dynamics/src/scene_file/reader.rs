//! Reads the elements of one scene.

use robot_dynamics_description::{LoadReport, RefusedFile};
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Budget, Lines, LoadOptions, Resource, XmlError};

use super::attributes::Attributes;
use super::fault::SceneFault;
use super::source::Source;
use crate::description::{Base, Disposition, EARTH_GRAVITY, Finding, RobotDescription, Scene};
use crate::load::Content;
use crate::plausibility::WrittenAngles;

/// Scenes in scenes are read down to this level.
const LEVELS: usize = 8;
/// The depth of elements.
const DEPTH: usize = 16;

/// A scene or robot that was read.
pub(crate) struct ReadFile {
    pub(crate) description: RobotDescription,
    pub(crate) report: LoadReport,
    pub(crate) angles: Vec<WrittenAngles>,
}

/// Reads a robot, not a scene, from its content and its file. The error lists all messages.
pub(crate) type ReadRobot = fn(&Content, &Source<'_>, &LoadOptions) -> Result<ReadFile, Vec<String>>;

/// The part of the reading that all nested scenes share.
pub(crate) struct Shared<'s> {
    pub(super) options: &'s LoadOptions,
    pub(super) read_robot: ReadRobot,
    pub(super) budget: Budget,
    level: usize,
}

impl<'s> Shared<'s> {
    pub(crate) fn new(options: &'s LoadOptions, read_robot: ReadRobot) -> Self {
        Self { options, read_robot, budget: Budget::default(), level: 0 }
    }
}

/// Whether a text is that of a scene.
pub(crate) fn is_scene(text: &str) -> bool {
    robot_dynamics_xml::outermost(text) == Some("scene")
}

/// Reads a scene.
pub(crate) fn read(
    text: &str,
    source: &Source<'_>,
    shared: &mut Shared<'_>,
) -> Result<ReadFile, RefusedFile<SceneFault>> {
    let refused = |error: XmlError| SceneFault::of_file(error.line(), &error).refused();
    if shared.level == LEVELS {
        let reason = format!("scenes are nested deeper than {LEVELS} levels");
        return Err(SceneFault::of_file(None, &reason).refused());
    }
    if shared.options.floating_base {
        let reason = "a scene has no floating base; write floating_base=\"true\" for one of its robots";
        return Err(SceneFault::of_file(None, &reason).refused());
    }
    shared.level += 1;
    let read = robot_dynamics_xml::parse(text, DEPTH, |document, faults| {
        let mut reader = Reader::new(document.input_text(), source, shared);
        for (line, message) in faults {
            reader.warn(*line, "scene", message.clone());
        }
        reader.read_scene(document.root_element());
        reader.finish()
    });
    shared.level -= 1;
    read.map_err(refused)?
}

/// Reads the elements of one scene, and collects all errors.
pub(super) struct Reader<'r, 's> {
    pub(super) source: &'r Source<'r>,
    pub(super) shared: &'r mut Shared<'s>,
    pub(super) lines: Lines,
    pub(super) scene: Scene,
    pub(super) report: LoadReport,
    pub(super) angles: Vec<WrittenAngles>,
    pub(super) faults: Vec<SceneFault>,
}

impl<'r, 's> Reader<'r, 's> {
    fn new(text: &str, source: &'r Source<'r>, shared: &'r mut Shared<'s>) -> Self {
        let (scene, report) = (Scene::new("scene"), LoadReport::default());
        let lines = Lines::of(text);
        Self { source, shared, lines, scene, report, angles: Vec::new(), faults: Vec::new() }
    }

    pub(super) fn warn(&mut self, line: usize, place: &str, message: String) {
        if self.shared.options.strict {
            self.faults.push(SceneFault::new(line, place, message));
        } else {
            self.report.add(Finding::new(line, place, Disposition::AsWritten, message));
        }
    }

    fn read_scene(&mut self, root: Node<'_, '_>) {
        let mut attributes = Attributes::of(root, &self.lines);
        let default = self.source.name().unwrap_or_else(|| "scene".to_owned());
        let name = attributes.text("name").map_or(default, str::to_owned);
        let gravity = attributes.numbers("gravity").unwrap_or(EARTH_GRAVITY);
        self.scene = Scene::new(name).with_gravity(gravity);
        self.faults.extend(attributes.finish());
        for node in root.children().filter(Node::is_element) {
            self.read_part(node);
            if self.faults.len() > RefusedFile::<SceneFault>::LISTED || self.shared.budget.is_exceeded() {
                break;
            }
        }
    }

    /// Adds the use of a resource; lists an error beyond its limit.
    pub(super) fn charge(&mut self, line: usize, place: &str, resource: Resource, count: usize) -> bool {
        match self.shared.budget.charge(resource, count) {
            Ok(()) => true,
            Err(limit) => {
                let message = format!("the scene has more than {} {}", limit.limit, limit.what);
                self.faults.push(SceneFault::of_limit(line, place, message));
                false
            }
        }
    }

    fn finish(mut self) -> Result<ReadFile, RefusedFile<SceneFault>> {
        let description = self.scene.into_description();
        description.name.clone_into(&mut self.report.robot);
        let counts = &mut self.report.counts;
        (counts.links, counts.joints) = (description.links.len(), description.joints.len());
        let free = description.joints.iter().filter(|joint| joint.mimic.is_none());
        let base = if description.base == Base::Floating { 6 } else { 0 };
        counts.degrees_of_freedom = free.map(|joint| joint.kind.nv()).sum::<usize>() + base;
        if let Source::Disk { path, .. } = self.source {
            self.report.add_files([path.as_path()]);
        }
        self.report.sort();
        if self.faults.is_empty() {
            return Ok(ReadFile { description, report: self.report, angles: self.angles });
        }
        Err(RefusedFile::new(self.faults, SceneFault::sorted_at, self.report))
    }
}

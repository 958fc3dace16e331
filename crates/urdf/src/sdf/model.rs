//! Reads `<model>` and `<frame>`.

use robot_dynamics_description::Pose;
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{ExceededLimit, Resource, excerpt};

use super::parts::{Attachment, Frame, FrameId, FrameKind, NamedFrame, Parts, Place, Scope, Target, WORLD};
use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

/// The largest number of models around a model, in all files.
const MODEL_DEPTH: usize = 40;

/// Statements of an `<include>` about its model.
#[derive(Clone, Default)]
pub(super) struct Overrides {
    pub(super) name: Option<String>,
    pub(super) pose: Option<(Target, Pose)>,
    pub(super) is_static: Option<bool>,
    pub(super) placement_frame: Option<String>,
    pub(super) merges: bool,
}

/// Elements of a model that do not affect the motion.
const MODEL_NOTES: [&str; 5] = ["plugin", "gripper", "allow_auto_disable", "enable_wind", "model_state"];

impl Parts<'_> {
    /// The place of an element, with the name of an included file.
    pub(super) fn place(&self, element: &Element<'_>) -> Place {
        Place { line: element.line, place: format!("{}{}", self.file, element.place) }
    }

    /// Charges the budget; `false`, with an error, above the limit.
    pub(super) fn charge<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        resource: Resource,
        count: usize,
    ) -> bool {
        let is_first = !self.budget.is_exceeded();
        let Err(ExceededLimit { what, limit }) = self.budget.charge(resource, count) else { return true };
        if is_first {
            reader.refuse(UrdfError::TooMany { line: element.line, what, limit });
        }
        false
    }

    /// Adds a frame. A name that is used twice by elements of one kind is an error.
    pub(super) fn add_frame<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        kind: FrameKind,
        name: &str,
        frame: Frame,
    ) -> FrameId {
        let id = self.frames.len();
        self.charge(reader, element, Resource::Characters, name.len());
        self.frames.push(frame);
        if name.is_empty() || name.ends_with("::") {
            return id;
        }
        let slots = self.names.entry(name.to_owned()).or_default();
        if let Some(first) = slots[kind as usize] {
            let what = match kind {
                FrameKind::Link => "link",
                FrameKind::Model => "model",
                FrameKind::Frame => "frame",
                FrameKind::Joint => "joint",
            };
            let (line, name, first) = (element.line, excerpt(name), self.frames[first].at.line);
            reader.refuse(UrdfError::DuplicateName { line, what, name, first });
            return id;
        }
        if slots.iter().any(Option::is_some) {
            let message =
                "another element of this model has the name, too: a reference means the link, model or frame";
            reader.warn(element, message);
        }
        slots[kind as usize] = Some(id);
        id
    }

    /// Reads a model inside `around`.
    pub(super) fn model<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        around: &Scope,
        is_top: bool,
        overrides: &Overrides,
    ) {
        if around.depth > MODEL_DEPTH {
            let reason = format!("models are nested deeper than {MODEL_DEPTH}; does a file include itself?");
            return reader.refuse_sdf(element, reason);
        }
        let attributes = ["name", "namespace", "canonical_link", "placement_frame", "merge"];
        let children =
            ["static", "self_collide", "frame", "pose", "link", "joint", "include", "model", "name", "uri"];
        reader.list_unread(
            element,
            &attributes,
            &[&children[..], &MODEL_NOTES].concat(),
            UnknownPart::Harmless,
        );
        let id = self.frames.len();
        let scope = self.add_model(reader, element, around, is_top, overrides);
        let Some((first_link, first_model)) = self.model_parts(reader, element, &scope) else { return };
        if element.text("canonical_link").is_none_or(str::is_empty) && !scope.is_static {
            self.frames[id].attached_to = match (first_link, first_model) {
                (Some(link), _) => Attachment::Link(link),
                (None, Some(model)) if model < self.frames.len() => Attachment::Frame(Target::Id(model)),
                _ => Attachment::World,
            };
        }
    }

    /// Adds the frame of a model. Returns the scope of its elements.
    fn add_model<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        around: &Scope,
        is_top: bool,
        overrides: &Overrides,
    ) -> Scope {
        let own = reader.own_name(element);
        let name = overrides.name.as_deref().unwrap_or(own);
        let merge = element.text("merge").and_then(|text| reader.flag(element, text)) == Some(true);
        let merges = overrides.merges || merge;
        let is_static = overrides.is_static.or(reader.child_flag(element, "static")).unwrap_or(false);
        let self_collides = reader.child_flag(element, "self_collide").unwrap_or(false);
        let written = reader.pose(element);
        let (relative_to, pose) = if let Some((target, pose)) = &overrides.pose {
            (target.clone(), *pose)
        } else {
            let target = written.relative_to.map_or(Target::Id(around.model), |name| around.target(name));
            (target, written.pose)
        };
        let prefix = match (is_top, merges) {
            (true, _) | (_, true) => around.prefix.clone(),
            _ => format!("{}{name}::", around.prefix),
        };
        let id = self.frames.len();
        let scope = Scope {
            prefix,
            model: id,
            is_static: around.is_static || is_static,
            self_collides,
            depth: around.depth + 1,
        };
        let placement = overrides.placement_frame.as_deref().or(element.text("placement_frame"));
        let placement = placement.filter(|name| !name.is_empty()).map(|name| scope.target(name));
        let canonical = element.text("canonical_link").filter(|name| !name.is_empty());
        let attached_to = match canonical {
            _ if scope.is_static => Attachment::World,
            Some(name) => Attachment::Frame(scope.target(name)),
            // Set when the first link or model is known.
            None => Attachment::World,
        };
        let at = self.place(element);
        let frame = Frame { at, relative_to, pose, placement, attached_to };
        let full = if is_top || merges { String::new() } else { format!("{}{name}", around.prefix) };
        self.add_frame(reader, element, FrameKind::Model, &full, frame);
        scope
    }

    /// Reads the parts of a model. Returns its first link and the frame of its first model; `None` above a
    /// limit.
    fn model_parts<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        element: &Element<'a>,
        scope: &Scope,
    ) -> Option<(Option<usize>, Option<FrameId>)> {
        let (mut first_link, mut first_model) = (None, None);
        for node in element.node.children().filter(Node::is_element) {
            if !reader.is_own(node) {
                continue;
            }
            // An element has at most eight names with the prefix.
            if !self.charge(reader, element, Resource::Characters, 8 * scope.prefix.len()) {
                return None;
            }
            let tag = node.tag_name().name();
            match tag {
                "link" => {
                    let link = reader.named_element(node, "link");
                    let index = self.link(reader, &link, scope);
                    first_link = first_link.or(Some(index));
                }
                "joint" => {
                    let joint = reader.named_element(node, "joint");
                    self.joint(reader, &joint, scope);
                }
                "frame" => {
                    let frame = reader.named_element(node, "frame");
                    self.frame(reader, &frame, scope);
                }
                "model" => {
                    let model = reader.named_element(node, "model");
                    first_model = first_model.or(Some(self.frames.len()));
                    self.model(reader, &model, scope, false, &Overrides::default());
                }
                "include" => {
                    let include = Element {
                        node,
                        line: reader.line(node),
                        place: format!("{}/include", element.place),
                    };
                    let next = self.frames.len();
                    self.include(reader, &include, scope, false);
                    first_model = first_model.or((self.frames.len() > next).then_some(next));
                }
                _ => {
                    let place = format!("{}/{tag}", element.place);
                    if MODEL_NOTES.contains(&tag) {
                        let line = reader.line(node);
                        reader.report_ignored(line, place, "a part for the Gazebo simulator");
                    }
                }
            }
        }
        Some((first_link, first_model))
    }

    fn frame<'a>(&mut self, reader: &mut Reader<'a>, element: &Element<'a>, scope: &Scope) {
        reader.list_unread(element, &["name", "attached_to"], &["pose"], UnknownPart::Harmless);
        let name = reader.own_name(element);
        let attached = element.text("attached_to").filter(|name| !name.trim().is_empty());
        let attached = attached.map_or(Target::Id(scope.model), |name| scope.target(name.trim()));
        let written = reader.pose(element);
        let relative_to = written.relative_to.map_or_else(|| attached.clone(), |name| scope.target(name));
        let full = format!("{}{name}", scope.prefix);
        let at = self.place(element);
        let attached_to = match attached {
            Target::Id(WORLD) => Attachment::World,
            other => Attachment::Frame(other),
        };
        let frame = Frame { at, relative_to, pose: written.pose, placement: None, attached_to };
        let frame = self.add_frame(reader, element, FrameKind::Frame, &full, frame);
        self.named_frames.push(NamedFrame { name: full, frame });
    }
}

//! Resolves frames: their poses in the world, and the links that they are attached to.

use robot_dynamics_description::{Pose, similar};
use robot_dynamics_xml::excerpt;

use super::parts::{Attachment, Frame, FrameId, Parts, Place, Target, WORLD};
use crate::UrdfError;

/// The number of errors that suggest a name, which takes time in proportion to the robot.
const SUGGESTIONS: usize = 20;

/// The largest number of steps from placement frames to their models.
const STEP_LIMIT: usize = 20_000_000;

/// The poses of all frames in the world, and their links.
pub(super) struct Resolved {
    pub(super) world_from_frame: Vec<Pose>,
    /// The link that carries each frame; `None` for the world.
    pub(super) links: Vec<Option<usize>>,
}

impl Parts<'_> {
    /// The frame that a reference means; `None`, with an error, if no frame has the name.
    pub(super) fn find(&self, target: &Target, at: &Place, errors: &mut Vec<UrdfError>) -> Option<FrameId> {
        let name = match target {
            Target::Id(id) => return Some(*id),
            Target::Name(name) => name,
        };
        let found = self.names.get(name).and_then(|slots| slots.iter().flatten().next());
        // An empty name has its own error.
        if found.is_none() && !name.is_empty() && !name.ends_with("::") {
            let names = self.names.keys().map(String::as_str);
            let near = if errors.len() < SUGGESTIONS { similar(name, names) } else { None };
            let near = near.map_or_else(
                || "correct the name".to_owned(),
                |near| format!("did you mean `{}`?", excerpt(&near)),
            );
            let (line, place, name) = (at.line, at.place.clone(), excerpt(name));
            errors.push(UrdfError::UnknownName {
                line,
                place,
                owner: "the model",
                what: "frame",
                name,
                near,
            });
        }
        found.copied()
    }

    /// The poses of all frames, or the errors.
    pub(super) fn resolve(&self) -> Result<Resolved, Vec<UrdfError>> {
        let mut errors = Vec::new();
        let relative_to: Vec<FrameId> = self
            .frames
            .iter()
            .map(|frame| self.find(&frame.relative_to, &frame.at, &mut errors).unwrap_or(WORLD))
            .collect();
        let attached: Vec<Result<Option<usize>, FrameId>> = self
            .frames
            .iter()
            .map(|frame| match &frame.attached_to {
                Attachment::World => Ok(None),
                Attachment::Link(link) => Ok(Some(*link)),
                Attachment::Frame(target) => {
                    // An unknown name that is also in `relative_to` has its error already.
                    let is_known =
                        matches!((target, &frame.relative_to), (Target::Name(a), Target::Name(b)) if a == b);
                    let found = if is_known {
                        self.find(target, &frame.at, &mut Vec::new())
                    } else {
                        self.find(target, &frame.at, &mut errors)
                    };
                    match found {
                        Some(WORLD) | None => Ok(None),
                        Some(id) => Err(id),
                    }
                }
            })
            .collect();
        let mut steps = STEP_LIMIT;
        let mut poses: Vec<Pose> = self.frames.iter().map(|frame| frame.pose).collect();
        // Inner models come after outer ones, and are resolved first.
        for id in (0..self.frames.len()).rev() {
            if let Some(placement) = &self.frames[id].placement
                && let Some(placed) = self.find(placement, &self.frames[id].at, &mut errors)
            {
                match model_from((id, placed), &relative_to, &poses, &mut steps) {
                    Some(model_from_placed) => poses[id] = poses[id].compose(&model_from_placed.inverse()),
                    None => errors.push(bad(
                        &self.frames[id],
                        "the placement frame is not placed relative to its model; name one that is",
                    )),
                }
            }
        }
        let world_from_frame = self.in_world(&relative_to, &poses, &mut errors);
        let links = self.follow(&attached, &mut errors);
        if errors.is_empty() { Ok(Resolved { world_from_frame, links }) } else { Err(errors) }
    }

    /// The poses in the world, along `relative_to`.
    fn in_world(&self, relative_to: &[FrameId], poses: &[Pose], errors: &mut Vec<UrdfError>) -> Vec<Pose> {
        let mut world: Vec<Option<Pose>> = vec![None; poses.len()];
        world[WORLD] = Some(Pose::IDENTITY);
        let mut is_pending = vec![false; poses.len()];
        for start in 0..poses.len() {
            let (mut pending, mut at) = (Vec::new(), start);
            while world[at].is_none() && !is_pending[at] {
                is_pending[at] = true;
                pending.push(at);
                at = relative_to[at];
            }
            if world[at].is_none() {
                errors.push(bad(
                    &self.frames[at],
                    "its pose is relative to itself, over other frames; correct `relative_to`",
                ));
                world[at] = Some(Pose::IDENTITY);
            }
            for id in pending.into_iter().rev() {
                if world[id].is_none() {
                    let other = world[relative_to[id]].unwrap_or(Pose::IDENTITY);
                    world[id] = Some(other.compose(&poses[id]));
                }
            }
        }
        world.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// The links at the ends of attachments.
    fn follow(
        &self,
        attached: &[Result<Option<usize>, FrameId>],
        errors: &mut Vec<UrdfError>,
    ) -> Vec<Option<usize>> {
        let mut links: Vec<Option<Option<usize>>> =
            attached.iter().map(|link| link.as_ref().ok().copied()).collect();
        let mut is_pending = vec![false; attached.len()];
        for start in 0..attached.len() {
            let (mut pending, mut at) = (Vec::new(), start);
            while links[at].is_none() && !is_pending[at] {
                is_pending[at] = true;
                pending.push(at);
                at = attached[at].err().unwrap_or(WORLD);
            }
            if links[at].is_none() {
                errors.push(bad(
                    &self.frames[at],
                    "it is attached to itself, over other frames; correct `attached_to`",
                ));
                links[at] = Some(None);
            }
            let link = links[at].flatten();
            for id in pending {
                links[id] = links[id].or(Some(link));
            }
        }
        links.into_iter().map(Option::flatten).collect()
    }
}

/// A frame in the frame of a model that it is placed in; `None` if it is not placed relative to that.
fn model_from(
    (model, frame): (FrameId, FrameId),
    relative_to: &[FrameId],
    poses: &[Pose],
    steps: &mut usize,
) -> Option<Pose> {
    let (mut at, mut model_from_frame) = (frame, Pose::IDENTITY);
    for _ in 0..poses.len() {
        *steps = steps.checked_sub(1)?;
        if at == model {
            return Some(model_from_frame);
        }
        if at == WORLD {
            return None;
        }
        model_from_frame = poses[at].compose(&model_from_frame);
        at = relative_to[at];
    }
    None
}

fn bad(frame: &Frame, reason: &str) -> UrdfError {
    UrdfError::BadSemantics { line: frame.at.line, place: frame.at.place.clone(), reason: reason.to_owned() }
}

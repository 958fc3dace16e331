//! Frames of a compiled robot, by name and by number.

use crate::spatial::algebra::{Padded, PaddedColumns, padded, padded_columns};
use crate::{Model, Pose};

/// A named frame: every link of the description, and every frame declared there.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Its name.
    pub name: String,
    /// The index of the description's link that carries it.
    pub(crate) link: usize,
    /// The body that carries it; `None` when it is fixed to the world.
    pub(crate) body: Option<usize>,
    /// The frame in the (turned) body frame, or in the world.
    pub(crate) body_from_frame: Pose,
    /// The same, padded.
    pub(crate) rotation: PaddedColumns,
    pub(crate) translation: Padded,
}

impl Frame {
    pub(crate) fn new(name: String, link: usize, body: Option<usize>, body_from_frame: Pose) -> Self {
        let (rotation, translation) =
            (padded_columns(body_from_frame.rotation), padded(body_from_frame.translation));
        Self { name, link, body, body_from_frame, rotation, translation }
    }
}

/// Names a frame of one robot; look it up once with [`Model::frame`]. Models of other robots refuse it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameId {
    pub(crate) index: usize,
    /// The robot's [`Identity`](crate::model::identity::Identity).
    pub(crate) robot: u64,
}

#[cold]
#[inline(never)]
#[track_caller]
pub(crate) fn refuse_frame(model: &Model) -> ! {
    panic!("the frame is another robot's, not one of `{}`: look it up by name in this model", model.name());
}

//! Frames of a compiled robot, by name and by id.

use robot_dynamics_description::Pose;
use robot_dynamics_number::algebra::{Padded, PaddedColumns, padded, padded_columns};

use crate::Model;

/// A named frame: a link of the description, or a frame declared there.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Its name.
    pub name: String,
    /// The index of its link in the description.
    pub link: usize,
    /// Its body; `None` if it is fixed to the world.
    pub body: Option<usize>,
    /// The frame in the (rotated) body frame, or in the world.
    pub body_from_frame: Pose,
    /// The same, padded.
    pub rotation: PaddedColumns,
    pub translation: Padded,
}

impl Frame {
    pub fn new(name: String, link: usize, body: Option<usize>, body_from_frame: Pose) -> Self {
        let (rotation, translation) =
            (padded_columns(body_from_frame.rotation), padded(body_from_frame.translation));
        Self { name, link, body, body_from_frame, rotation, translation }
    }
}

/// The id of a frame of one robot. Look it up once with [`Model::frame`]; using it with another robot panics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameId {
    pub index: usize,
    /// The robot's [`Identity`](crate::model::identity::Identity).
    pub robot: u64,
}

#[cold]
#[inline(never)]
#[track_caller]
pub(crate) fn refuse_frame(model: &Model) -> ! {
    panic!("the frame is another robot's, not one of `{}`: look it up by name in this model", model.name());
}

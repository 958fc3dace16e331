//! Frames of a compiled robot, by name and by id.

use std::collections::HashMap;

use robot_dynamics_description::{Pose, RobotDescription};
use robot_dynamics_number::algebra::{Padded, PaddedColumns, padded, padded_columns};

use crate::model::placed_link::PlacedLink;

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

/// The id of a frame of one robot. Look it up once with [`Model::frame`](crate::Model::frame). Using it with
/// another robot panics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameId {
    pub index: usize,
    /// The robot's [`Identity`](crate::model::identity::Identity).
    pub robot: u64,
}

#[cold]
#[inline(never)]
#[track_caller]
pub(crate) fn refuse_frame(robot: &str) -> ! {
    panic!("the frame is another robot's, not one of `{robot}`: look it up by name in this model");
}

/// The frames of a robot: its links, then those that the description declares and those of its equalities.
pub(super) fn frames(
    description: &RobotDescription,
    link_index: &HashMap<&str, usize>,
    links: &[PlacedLink],
) -> Vec<Frame> {
    let of_links = description.links.iter().zip(links).enumerate();
    let of_links = of_links.map(|(index, (link, placed))| {
        Frame::new(link.name.clone(), index, placed.body, placed.body_from_link)
    });
    let of_equalities = description.equality_frames();
    let declared = description.frames.iter().chain(&of_equalities).map(|frame| {
        let link = link_index[frame.link.as_str()];
        let body_from_frame = links[link].body_from_link.compose(&frame.link_from_frame);
        Frame::new(frame.name.clone(), link, links[link].body, body_from_frame)
    });
    of_links.chain(declared).collect()
}

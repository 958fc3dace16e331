//! Components of a frame's velocity, along its own axes, that vanish: J_k v = 0 for rows k of the Jacobian in
//! the frame.
//!
//! The rows do not follow from a position, so there is no φ to correct: a drift along them stays. A row costs
//! O(depth).

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;

use super::SpatialAxis;
use crate::equality::direction::ConstrainedDirection;
use crate::equality::relation::Relation;
use crate::equality::site::Site;

/// Components of a frame's velocity, along the frame's own axes, that vanish.
///
/// The chapter's knife-edge is the row y of a frame that heads along x: no side-slip. Rows x and y allow a
/// frame only to turn on the spot. These rows do not follow from a position: there is no φ.
#[derive(Clone, Debug, PartialEq)]
pub struct NoSlip {
    /// The frame.
    pub frame: FrameId,
    /// The components; `rx` is ω_x.
    pub rows: Vec<SpatialAxis>,
}

impl NoSlip {
    /// The frame's origin does not move along the frame's y axis: a blade, or wheels, that head along x.
    pub fn sideways(frame: FrameId) -> Self {
        Self { frame, rows: vec![SpatialAxis::Y] }
    }

    /// The rows of the frame in the world.
    pub(super) fn relation(&self, model: &Model) -> Relation {
        let directions = self.rows.iter().map(|row| ConstrainedDirection::Slip(*row as usize));
        Relation::Sites(
            [Site::in_world(&Pose::IDENTITY), Site::of_frame(model, self.frame)],
            directions.collect(),
        )
    }
}

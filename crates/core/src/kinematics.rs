//! Stages that several algorithms share: placements, motions in one frame, shifts between points, wrenches.

pub mod carried;
pub mod place;
pub mod screws;
pub mod shifts;
pub mod wrench;

//! What several algorithms begin with: placements, motions in one frame, shifts between points, wrenches.

pub(crate) mod carried;
pub(crate) mod place;
pub(crate) mod screws;
pub(crate) mod shifts;
pub(crate) mod wrench;

//! Links on their bodies.

use robot_dynamics_description::Pose;

/// The body (or the world) of a link, and the link's constant placement on it.
#[derive(Clone, Copy)]
pub struct PlacedLink {
    pub body: Option<usize>,
    pub body_from_link: Pose,
}

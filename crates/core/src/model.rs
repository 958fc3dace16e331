//! The compiled robot: from a description to the arrays of the recursions.

pub mod actuated_dofs;
mod ancestors;
pub mod body;
pub mod compile;
pub mod frame;
pub mod identity;
pub mod joint;
pub mod link;
pub mod mass;
pub mod massless_joints;
pub mod native;
mod placed_link;
pub mod random_state;
pub mod reference_frame;
pub(crate) mod reference_point;
pub(crate) mod regrouping;
pub(crate) mod right_angles;
pub mod robot;
pub mod rotor;
pub mod segment;

pub use body::{Body, Dof, WORLD};
pub use frame::{Frame, FrameId};
pub use joint::Joint;
pub use link::Link;
pub use reference_frame::ReferenceFrame;
pub use robot::Model;

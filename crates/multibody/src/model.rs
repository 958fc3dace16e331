//! The robot: described, checked, compiled, changed, and known again.

pub(crate) mod actuated;
pub(crate) mod actuator;
pub(crate) mod compile;
pub(crate) mod contact_pair;
pub(crate) mod couplings;
pub(crate) mod description;
pub(crate) mod equality;
pub(crate) mod error;
pub(crate) mod higher_terms;
pub(crate) mod identity;
pub(crate) mod joint_description;
pub(crate) mod length;
pub(crate) mod mass;
pub(crate) mod named_pose;
pub(crate) mod pendulum;
pub(crate) mod placement_spring;
pub(crate) mod random_robot;
pub(crate) mod reference_point;
pub(crate) mod refused_file;
pub(crate) mod regroup;
pub(crate) mod report;
pub(crate) mod right_angles;
pub(crate) mod robot;
pub(crate) mod rotor;
pub(crate) mod shape;
pub(crate) mod softness;
pub(crate) mod surgery;
pub(crate) mod tendon;
pub(crate) mod validate;
pub(crate) mod validate_beside;
pub(crate) mod written_file;

pub(crate) use robot::{Body, Dof, WORLD};
pub use robot::{Frame, FrameId, Joint, Model};

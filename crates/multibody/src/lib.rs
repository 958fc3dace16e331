//! Dynamics of any robot.
#![allow(dead_code)]
mod algebra;
mod cholesky;
mod compile;
mod description;
mod dissipation;
mod energy;
mod error;
mod fixed_size;
mod forward_dynamics;
mod inverse_dynamics;
pub mod lagrange;
mod mass_matrix;
mod model;
mod place;
mod pose;
mod random_robot;
mod validate;
mod workspace;
mod wrench;

pub use description::{
    Base, EARTH_GRAVITY, FLOATING_BASE, FrameDescription, JointDescription, JointKind, Limits,
    LinkDescription, Mimic, PassiveForces, RobotDescription,
};
pub use dissipation::dissipation;
pub use energy::{kinetic_energy, potential_energy};
pub use error::ModelError;
pub use fixed_size::{FixedSize, FixedSizeError};
pub use forward_dynamics::{forward_dynamics, forward_dynamics_by_cholesky, forward_dynamics_with_wrenches};
pub use inverse_dynamics::{
    bias, gravity, inverse_dynamics, inverse_dynamics_with_wrenches, velocity_product,
};
pub use mass_matrix::mass_matrix;
pub use model::{Frame, FrameId, Joint, Model};
pub use pose::Pose;
pub use random_robot::{JointKinds, RandomRobotOptions, RandomState, random_robot, random_state};
pub use workspace::Workspace;
pub use wrench::FrameWrench;

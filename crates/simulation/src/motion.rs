//! Motion in time: steps and runs with their energy account, and functions that check their input.

pub mod drive;
pub mod implicit;
pub mod integrate;
pub mod linearize_step;
pub(crate) mod mujoco_euler;
pub mod pullback;
pub mod simulate;

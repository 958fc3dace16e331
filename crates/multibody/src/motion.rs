//! Motion in time, steps and runs with their books of energy; calls that check their input.

pub(crate) mod allocating;
pub(crate) mod drive;
pub(crate) mod fixed_size;
pub(crate) mod implicit;
pub(crate) mod integrate;
pub(crate) mod linearize_step;
pub(crate) mod mujoco_euler;
pub(crate) mod operational_space_error;
pub(crate) mod pullback;
pub(crate) mod simulate;

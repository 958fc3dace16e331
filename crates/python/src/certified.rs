//! Proven bounds, by interval arithmetic.

mod bounds;
mod definite;
mod digits;
pub(crate) mod reach;
pub(crate) mod torques;

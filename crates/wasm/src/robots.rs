//! Robots from files.

mod drawn_body;
mod parity;
mod robot;

pub use parity::robot_parity_values;
pub use robot::Robot;

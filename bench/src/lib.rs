//! What the benchmarks run on: the robots, their random states, and each algorithm as one closure.

mod chain;
mod robots;
mod states;
mod task;

pub use chain::chain;
pub use robots::{RobotError, all_robots, described_robot, robot_by_name};
pub use states::{StateTable, StateTableError};
pub use task::{Algorithm, Task};

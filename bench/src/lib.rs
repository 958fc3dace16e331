//! The inputs of the benchmarks: robots, their random states, and each algorithm as one closure.

mod batch_task;
mod chain;
mod operation_counts;
mod robots;
mod states;
mod task;

pub use batch_task::{BatchName, BatchTask};
pub use chain::chain;
pub use operation_counts::{Counted, Counts, Tally, tally};
pub use robots::{RobotError, all_robots, described_robot, robot_by_name, robot_of_file};
pub use states::{StateTable, StateTableError};
pub use task::{MEASURED, Task, key, named};

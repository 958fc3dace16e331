//! Changes of a description before it is compiled: parts added and removed, another root, other masses,
//! joints locked, motors with gears, elastic joints, a fluid around the robot.

mod drive;
mod immerse;
mod lock;
mod mass;
mod motion;
mod names;
mod note;
mod parts;
mod remove;
mod reverse;
mod root;

pub use self::drive::{JointElasticity, MotorDrive};
pub use self::motion::moved_by;
pub use self::note::EditNote;

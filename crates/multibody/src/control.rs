//! Where joints should be for a hand to be in place; control in operational space: what a hand feels like, and tasks
//! that it follows.

pub(crate) mod inverse_kinematics;
pub(crate) mod operational_space;

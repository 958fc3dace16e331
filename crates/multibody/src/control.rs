//! Control in operational space: what a hand feels like, and tasks that it follows.

pub(crate) mod operational_space;

//! Generated code, compiled and run, gives the library's values.

mod c;
mod casadi;
mod cuda;
mod folder;
mod lanes;
mod loops;
mod machine_code;
mod messages;
mod microcontroller;
mod names;
mod robots;
mod rust;
#[path = "../../src/testing.rs"]
#[allow(dead_code)] // one robot is for tests in the crate
mod testing;
mod wgsl;

//! Generated code, compiled and run, gives the library's values.

mod c;
mod casadi;
mod cuda;
mod folder;
mod lanes;
mod microcontroller;
mod robots;
mod rust;
mod wgsl;

//! Mesh files of robots as triangles, and their convex hulls.
//!
//! | file | how it is known |
//! | --- | --- |
//! | STL, binary or text | `.stl`, or `model/stl` |
//! | OBJ, without materials | `.obj`, or `model/obj` |
//! | MSH, MuJoCo's own | `.msh`, or `model/vnd.mujoco.msh` |
//!
//! Corners are numbers of single precision, as such files have them.

mod file;
mod hull;
mod polygon;

pub use file::{Triangles, check, parse, read};
pub use hull::{corners, hull};

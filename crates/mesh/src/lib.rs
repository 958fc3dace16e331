//! Reads the mesh files of robots as triangles, and computes convex hulls.
//!
//! | format | extension or content type |
//! | --- | --- |
//! | STL, binary or text | `.stl`, or `model/stl` |
//! | OBJ, without materials | `.obj`, or `model/obj` |
//! | MSH, MuJoCo's own | `.msh`, or `model/vnd.mujoco.msh` |
//!
//! Coordinates have single precision, as in these formats.

mod file;
mod hull;
mod obj;
mod polygon;
mod stl;
mod surface;
mod triangles;

pub use file::{parse, read};
pub use hull::{corners, hull};
pub use surface::open_edges;
pub use triangles::{Triangles, check};

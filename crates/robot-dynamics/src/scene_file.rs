//! Scene files: robots and objects in one world, in XML with the outermost element `<scene>`.
//!
//! Every command and function that takes a robot's file takes a scene's file. The guide's page "Build a
//! scene" lists its elements and attributes.

mod attributes;
mod fault;
mod part;
mod reader;
mod source;

pub use self::fault::SceneFault;
pub(crate) use self::reader::{ReadFile, Shared, is_scene, read};
pub(crate) use self::source::Source;

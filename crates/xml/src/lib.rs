//! Reads and writes XML for robot files.
//!
//! [`read_file`] and [`parse`] refuse hostile text and repair common faults. [`Lines`] maps bytes to lines,
//! [`LoadOptions`] are the options of all readers, and [`Writer`] writes XML.

mod budget;
mod encoding;
mod error;
mod format;
mod lines;
mod markup;
mod options;
mod repair;
mod scan;
mod text;
mod writer;

pub use roxmltree;

pub use budget::{Budget, CHARACTER_LIMIT, ELEMENT_LIMIT, ExceededLimit, NUMBER_LIMIT, Resource};
pub use error::{XmlError, excerpt};
pub use lines::Lines;
pub use options::{LoadOptions, Srdf};
pub use repair::outermost;
pub use text::{
    SIZE_LIMIT, parse, read_bytes, read_file, read_regular_bytes, read_regular_file, spellings, text_of,
};
pub use writer::{Writer, is_name, way_from};

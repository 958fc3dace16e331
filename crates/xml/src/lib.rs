//! What the readers of robot files in XML share: text from a file, refused when it is hostile, mended where it is not quite
//! well-formed, with the line of every byte; and the choices that a file leaves to its reader.

mod error;
mod lines;
mod options;
mod scan;
mod text;
mod unclean_xml;

pub use error::{XmlError, excerpt};
pub use lines::Lines;
pub use options::Options;
pub use roxmltree;
pub use text::{SIZE_LIMIT, parse, read_file};
pub use unclean_xml::outermost;

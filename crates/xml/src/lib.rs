//! What the readers of robot files in XML share: text from a file, refused when it is hostile, mended where it is not quite
//! well-formed, with the line of every byte; the choices that a file leaves to its reader; and what writes such files.

mod error;
mod lines;
mod options;
mod scan;
mod text;
mod unclean_xml;
mod writer;

pub use error::{XmlError, excerpt};
pub use lines::Lines;
pub use options::Options;
pub use roxmltree;
pub use text::{SIZE_LIMIT, parse, read_file, text_of};
pub use unclean_xml::outermost;
pub use writer::{Writer, is_name, way_from};

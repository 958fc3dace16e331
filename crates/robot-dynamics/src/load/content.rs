//! The content of a robot's file: text, or USD.

use std::path::Path;

use robot_dynamics_xml::XmlError;

/// The content of a robot's file.
pub(crate) enum Content {
    Text(String),
    /// A file in text or binary form, or an archive.
    #[cfg(feature = "usd")]
    Usd(Vec<u8>),
}

impl Content {
    pub(crate) fn of(bytes: &[u8]) -> Result<Self, XmlError> {
        #[cfg(feature = "usd")]
        if robot_dynamics_usd::is_usd(bytes) {
            return Ok(Self::Usd(bytes.to_vec()));
        }
        robot_dynamics_xml::text_of(bytes).map(Self::Text)
    }

    /// Reads a file once, because it may be a pipe.
    pub(crate) fn read(path: &Path) -> Result<Self, XmlError> {
        Self::of(&robot_dynamics_xml::read_bytes(path)?)
    }

    /// The text, unless it is USD.
    #[cfg_attr(not(feature = "usd"), allow(clippy::unnecessary_wraps))]
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            #[cfg(feature = "usd")]
            Self::Usd(_) => None,
        }
    }

    /// The number of bytes.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Text(text) => text.len(),
            #[cfg(feature = "usd")]
            Self::Usd(bytes) => bytes.len(),
        }
    }
}

//! TODO: path

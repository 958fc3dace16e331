//! TODO: linearize

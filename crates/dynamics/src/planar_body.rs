//! TODO: planar_body

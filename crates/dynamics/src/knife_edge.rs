//! TODO: knife_edge

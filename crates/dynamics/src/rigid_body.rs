//! TODO: rigid_body

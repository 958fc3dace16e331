//! TODO: actuation

//! TODO: integrate

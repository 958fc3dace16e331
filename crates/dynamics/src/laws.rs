//! TODO: laws

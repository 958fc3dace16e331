//! TODO: constraint

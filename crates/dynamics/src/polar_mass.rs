//! TODO: polar_mass

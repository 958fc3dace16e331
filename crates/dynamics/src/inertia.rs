//! TODO: inertia

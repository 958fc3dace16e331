//! TODO: inertia_ellipse

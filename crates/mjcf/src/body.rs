//! A body as the file has it, before it becomes a link with joints.

use nalgebra::Isometry3;

use crate::geom::Geom;
use crate::inertial::Inertial;
use crate::joint::Joint;
use crate::reader::Element;

/// A `<body>`; the first of all is the world.
pub(crate) struct Body {
    /// With the suffixes of the replicates around it; empty for one without a name.
    pub(crate) name: String,
    pub(crate) element: Element,
    /// Index of the body it is in; of the world its own.
    pub(crate) parent: usize,
    pub(crate) parent_from_body: Isometry3<f64>,
    pub(crate) inertial: Option<Box<Inertial>>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) geoms: Vec<Geom>,
    pub(crate) sites: Vec<Site>,
    /// How much of its weight is carried for it.
    pub(crate) gravity_compensation: f64,
    /// Whether a user moves it.
    pub(crate) mocap: bool,
}

impl Body {
    /// A body of which nothing is known yet but its place.
    pub(crate) fn new(
        name: String,
        element: Element,
        parent: usize,
        parent_from_body: Isometry3<f64>,
    ) -> Self {
        Self {
            name,
            element,
            parent,
            parent_from_body,
            inertial: None,
            joints: Vec::new(),
            geoms: Vec::new(),
            sites: Vec::new(),
            gravity_compensation: 0.0,
            mocap: false,
        }
    }
}

/// A `<site>` with a name: a frame on its body.
pub(crate) struct Site {
    pub(crate) name: String,
    pub(crate) element: Element,
    pub(crate) body_from_site: Isometry3<f64>,
}

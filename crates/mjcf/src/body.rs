//! A body of the file, before it becomes a link with joints.

use nalgebra::Isometry3;

use crate::element::Element;
use crate::geom::Geom;
use crate::inertial::Inertial;
use crate::joint::Joint;

/// A `<body>`; the first body is the world.
pub(crate) struct Body {
    /// The name with the suffixes of the replicates around it; empty for a body without a name.
    pub(crate) name: String,
    pub(crate) element: Element,
    /// The index of its parent; the world is its own parent.
    pub(crate) parent: usize,
    pub(crate) parent_from_body: Isometry3<f64>,
    pub(crate) inertial: Option<Box<Inertial>>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) geoms: Vec<Geom>,
    pub(crate) sites: Vec<Site>,
    /// The fraction of its weight that is compensated.
    pub(crate) gravity_compensation: f64,
    /// Whether it is a mocap body.
    pub(crate) mocap: bool,
}

impl Body {
    /// A body at a placement, without joints, geoms and sites.
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

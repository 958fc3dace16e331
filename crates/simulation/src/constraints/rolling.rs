//! A disc that rolls on a plane: the point at the contact has V = ṗ − r ω × u = 0. **(PRM ch. 12; MLS ch.
//! 7)**
//!
//! The rows are V·h along the heading, V·(n × h) across it, and V·n. Only the normal row has φ. A row costs
//! O(depth). An axle along the plane's normal has no heading, and the rows are not finite there.

use nalgebra::{Unit, Vector3};
use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::equality::direction::{ConstrainedDirection, Rolling};
use crate::equality::relation::Relation;
use crate::equality::site::Site;

/// The plane n·x = offset in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub(super) normal: Unit<Vector3<f64>>,
    pub(super) offset: f64,
}

impl Plane {
    /// The plane through a point with a normal, which need not have unit length.
    ///
    /// # Panics
    /// If the normal is zero or not finite.
    #[track_caller]
    pub fn new(normal: [f64; 3], point: [f64; 3]) -> Self {
        let normal = Vector3::from(normal);
        let length = normal.norm();
        assert!(length > 0.0 && length.is_finite(), "a plane's normal must have a direction, got {normal:?}");
        let normal = Unit::new_normalize(normal);
        Self { normal, offset: normal.dot(&Vector3::from(point)) }
    }

    /// n·x of its points \[m\].
    pub(super) fn offset(&self) -> f64 {
        self.offset
    }

    /// z = height.
    pub fn level(height: f64) -> Self {
        Self { normal: Vector3::z_axis(), offset: height }
    }
}

/// The directions in which the disc's contact point must not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum RollingRow {
    /// Along the heading: the disc rolls.
    Forward,
    /// In the plane across the heading.
    Side,
    /// Along the plane's normal; this row has φ, the height of the lowest point.
    Normal,
}

impl RollingRow {
    /// `forward`, `side` or `normal`.
    pub fn name(self) -> &'static str {
        ["forward", "side", "normal"][self as usize]
    }
}

/// A thin disc about the origin of a frame, in contact with a plane, that does not slip.
///
/// Let s be the unit axle, n the plane's normal, w = n − (n·s) s, and u = w/|w|. The contact is at p − r u,
/// and the disc heads along h = s × n/|s × n|. The disc's point there has the velocity V = ṗ − r ω × u. The
/// rows are V·h, V·(n × h) and V·n. An upright wheel and a tilted coin are the same constraint. An axle along
/// n has no heading, and the rows are then not finite. **(PRM ch. 12; MLS ch. 7)**
#[derive(Clone, Debug, PartialEq)]
pub struct RollingDisc {
    /// The frame at the disc's centre.
    pub frame: FrameId,
    /// The axle in the frame; need not have unit length.
    pub axle: [f64; 3],
    /// r \[m\].
    pub radius: f64,
    /// The plane.
    pub plane: Plane,
    /// The rows; on a planar base the normal row is zero and better left out.
    pub rows: Vec<RollingRow>,
}

impl RollingDisc {
    /// All three rows on the plane z = 0.
    pub fn on_floor(frame: FrameId, axle: [f64; 3], radius: f64) -> Self {
        let rows = vec![RollingRow::Forward, RollingRow::Side, RollingRow::Normal];
        Self { frame, axle, radius, plane: Plane::level(0.0), rows }
    }

    /// The rows of the disc in the world.
    pub(super) fn relation(&self, model: &Model) -> Relation {
        let direction = |row: &RollingRow| {
            ConstrainedDirection::Roll(Box::new(Rolling {
                axle: Vector3::from(self.axle).normalize(),
                radius: self.radius,
                normal: self.plane.normal.into_inner(),
                offset: self.plane.offset,
                direction: *row as usize,
            }))
        };
        Relation::Sites(
            [Site::in_world(&Pose::IDENTITY), Site::of_frame(model, self.frame)],
            self.rows.iter().map(direction).collect(),
        )
    }
}

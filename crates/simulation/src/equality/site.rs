//! A frame on a body, or in the world: its place and its motion.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;

use crate::placement::{BodyMotion, Placement, VectorNumber};

/// A frame on a body, or in the world.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub(crate) body: usize,
    /// `body_from_site`.
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

/// The axes of a site, as columns, and its origin in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SitePlace<S = f64> {
    pub(crate) axes: Matrix3<S>,
    pub(crate) origin: Vector3<S>,
}

impl Site {
    #[track_caller]
    pub(crate) fn of_frame(model: &Model, frame: FrameId) -> Self {
        let frame = model.frame_of(frame);
        Self::new(frame.body.unwrap_or(WORLD), &frame.body_from_frame)
    }

    pub(crate) fn in_world(pose: &Pose) -> Self {
        Self::new(WORLD, pose)
    }

    fn new(body: usize, pose: &Pose) -> Self {
        let rotation = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
        Self { body, rotation, translation: pose.translation.into() }
    }

    pub(crate) fn place(&self, placement: &Placement) -> SitePlace {
        let (rotation, origin) = placement.body(self.body);
        SitePlace { axes: rotation * self.rotation, origin: origin + rotation * self.translation }
    }

    /// The motion of the site's origin, given the motions of all bodies.
    pub(crate) fn motion(&self, placement: &Placement, motions: &[BodyMotion]) -> BodyMotion {
        if self.body == WORLD {
            return BodyMotion::default();
        }
        motions[self.body].at(&(placement.body(self.body).0 * self.translation))
    }
}

impl<S: VectorNumber> SitePlace<S> {
    /// Axis k.
    pub(crate) fn axis(&self, k: usize) -> Vector3<S> {
        self.axes.column(k).into()
    }
}

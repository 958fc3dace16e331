//! External wrenches on frames.

use robot_dynamics_number::algebra::{M3, V3};
use robot_dynamics_number::{Scalar, View};

use crate::spatial::force::ForceVector;
use crate::{FrameId, Model};

/// A force and a moment that act on a frame's body, along the frame's axes. The force acts at the frame's
/// origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameWrench<S = f64> {
    /// The frame at whose origin, and along whose axes, the wrench is given.
    pub frame: FrameId,
    /// Force \[N\].
    pub force_in_frame: [S; 3],
    /// Moment about the frame's origin \[N·m\].
    pub moment_in_frame: [S; 3],
}

/// Subtracts external wrenches from the forces that the joints must supply. Wrenches on frames fixed to the
/// world have no effect.
#[inline(always)]
pub(crate) fn subtract_wrenches<S: Scalar, N: View<S>>(
    model: &Model,
    force: &mut [ForceVector<N>],
    wrenches: &[FrameWrench<S>],
) {
    for wrench in wrenches {
        let Some((body, wrench)) = on_body(model, wrench) else { continue };
        force[body].linear -= wrench.linear;
        force[body].angular -= wrench.angular;
    }
}

/// The body of a wrench, and the wrench about that body's origin in that body's frame. `None` for a frame
/// fixed to the world.
#[inline(always)]
pub(crate) fn on_body<S: Scalar, N: View<S>>(
    model: &Model,
    wrench: &FrameWrench<S>,
) -> Option<(usize, ForceVector<N>)> {
    let frame = model.frame_of(wrench.frame);
    let turn = M3::from_f64(frame.body_from_frame.rotation);
    let linear = turn * V3::new(wrench.force_in_frame.map(N::of));
    let arm = V3::from_f64(frame.body_from_frame.translation);
    let angular = turn * V3::new(wrench.moment_in_frame.map(N::of)) + arm.cross(linear);
    Some((frame.body?, ForceVector { linear, angular }))
}

//! Frame Jacobians: 6×nv matrices J with twist = J v, and the accelerations J̇ v.
//!
//! Rows are linear x y z, then angular x y z; row-major. The three forms are those of
//! [`kinematics`](crate::Twist): world aligned, in the frame, in the world. **(MR §5.1)**

use dynamics::Scalar;

use crate::kinematics::{Moving, Twist};
use crate::model::WORLD;
use crate::place::check_length;
use crate::screws::{place_screws, shifted};
use crate::workspace::Screw;
use crate::{FrameId, Model, Workspace};

/// J of [`frame_velocity_world_aligned`](crate::frame_velocity_world_aligned): the velocity of the frame's
/// origin and ω along the world's axes, 6×nv.
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
pub fn frame_jacobian_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    let origin = place_screws(model, workspace, q);
    let point = Moving::new(model, workspace, frame, origin).place.translation;
    write_columns(model, workspace, frame, jacobian, |s| shifted(s, point));
}

/// J of [`frame_velocity_in_frame`](crate::frame_velocity_in_frame): the velocity of the frame's origin and ω
/// along the frame's own axes, 6×nv. The body Jacobian. **(MR §5.1.2)**
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[doc(alias = "body Jacobian")]
#[inline]
pub fn frame_jacobian_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    let origin = place_screws(model, workspace, q);
    let place = Moving::new(model, workspace, frame, origin).place;
    write_columns(model, workspace, frame, jacobian, |s| {
        let Screw { linear, angular } = shifted(s, place.translation);
        Screw { linear: place.rotation.transpose_mul(linear), angular: place.rotation.transpose_mul(angular) }
    });
}

/// J of [`frame_velocity_in_world`](crate::frame_velocity_in_world): ω and the velocity of the point that
/// passes the world's origin, along the world's axes, 6×nv. The space Jacobian. **(MR §5.1.1)**
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[doc(alias = "space Jacobian")]
#[inline]
pub fn frame_jacobian_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    let origin = place_screws(model, workspace, q);
    write_columns(model, workspace, frame, jacobian, |s| shifted(s, -origin));
}

/// One column for each freedom that carries the frame, followers added to their leaders; the rest is zero.
#[inline(always)]
fn write_columns<S: Scalar>(
    model: &Model,
    workspace: &Workspace<S>,
    frame: FrameId,
    jacobian: &mut [S],
    seen: impl Fn(&Screw<S>) -> Screw<S>,
) {
    let nv = model.nv;
    check_length("the Jacobian", jacobian.len(), 6 * nv);
    jacobian.fill(S::zero());
    let mut at = model.frames[frame.0].body.unwrap_or(WORLD);
    while at != WORLD {
        let body = &model.bodies[at];
        for index in body.dof..body.dof + body.motion.nv() {
            add_column(model, jacobian, index, &seen(&workspace.column[index]));
        }
        at = body.parent;
    }
}

/// Adds a tree freedom's column to a 6×nv matrix J G.
#[inline(always)]
pub(crate) fn add_column<S: Scalar>(model: &Model, matrix: &mut [S], index: usize, column: &Screw<S>) {
    let dof = &model.dofs[index];
    let entries = column.linear.array().into_iter().chain(column.angular.array());
    for (row, entry) in matrix.chunks_exact_mut(model.nv).zip(entries) {
        row[dof.coordinate] += entry.scale(dof.ratio);
    }
}

/// J̇ v of [`frame_jacobian_world_aligned`]: the classical acceleration p̈ of the frame's origin, and ω̇, at
/// a = 0, along the world's axes.
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
pub fn frame_bias_acceleration_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    Moving::accelerated(model, workspace, q, v, None, frame).classical_world_aligned()
}

/// J̇ v of [`frame_jacobian_in_frame`]: the spatial acceleration at the frame's origin at a = 0, along the
/// frame's own axes.
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
pub fn frame_bias_acceleration_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    Moving::accelerated(model, workspace, q, v, None, frame).spatial_in_frame()
}

/// J̇ v of [`frame_jacobian_in_world`]: the spatial acceleration at the world's origin at a = 0, along the
/// world's axes.
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
pub fn frame_bias_acceleration_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    Moving::accelerated(model, workspace, q, v, None, frame).spatial_in_world()
}

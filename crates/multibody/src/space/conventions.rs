//! To and from MuJoCo's convention for states and forces.
//!
//! | | this library (and Pinocchio) | MuJoCo |
//! | --- | --- | --- |
//! | quaternion in q | x y z w | w x y z |
//! | free joint, linear velocity | of the frame's origin, in body axes | of the frame's origin, in world axes |
//! | free joint, angular velocity | in body axes | in body axes |
//! | ball joint, angular velocity | in body axes | in body axes |
//! | free joint, force | dual to the velocity: body axes | dual to its own: force in world axes, moment in body axes |
//!
//! "World" is the frame the floating joint hangs in. Joints must come in the same order on both sides; a
//! universal joint is two hinges there, a planar one two slides and a hinge, with the same numbers.

use crate::Model;
use crate::Quaternion;
use crate::joint::Chart;
use crate::model::length::check_length;
use crate::space::configuration::{Stretch, quaternion_at, stretches, vector_at};

/// q → `qpos`: quaternions from x y z w to w x y z.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn configuration_to_mujoco(model: &Model, q: &[f64], qpos: &mut [f64]) {
    reorder(model, q, qpos, |[x, y, z, w]| [w, x, y, z]);
}

/// `qpos` → q: quaternions from w x y z to x y z w.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn configuration_from_mujoco(model: &Model, qpos: &[f64], q: &mut [f64]) {
    reorder(model, qpos, q, |[w, x, y, z]| [x, y, z, w]);
}

/// v → `qvel`: the linear velocity of a floating joint is turned to world axes, ẋ = R u.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn velocity_to_mujoco(model: &Model, q: &[f64], v: &[f64], qvel: &mut [f64]) {
    turn_linear(model, q, v, qvel, Quaternion::rotate);
}

/// `qvel` → v: u = Rᵀ ẋ. q is this library's.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn velocity_from_mujoco(model: &Model, q: &[f64], qvel: &[f64], v: &mut [f64]) {
    turn_linear(model, q, qvel, v, Quaternion::rotate_back);
}

/// τ → `qfrc`: the power τ·v = qfrc·qvel stays, so the force of a floating joint turns as its velocity does.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn force_to_mujoco(model: &Model, q: &[f64], tau: &[f64], qfrc: &mut [f64]) {
    turn_linear(model, q, tau, qfrc, Quaternion::rotate);
}

/// `qfrc` → τ. q is this library's.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn force_from_mujoco(model: &Model, q: &[f64], qfrc: &[f64], tau: &mut [f64]) {
    turn_linear(model, q, qfrc, tau, Quaternion::rotate_back);
}

/// v̇ → `qacc`: ẍ = R(u̇ + ω × u), since body axes turn and world axes do not.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn acceleration_to_mujoco(model: &Model, q: &[f64], v: &[f64], a: &[f64], qacc: &mut [f64]) {
    check_length("v", v.len(), model.nv);
    check_length("the accelerations", a.len(), model.nv);
    check_length("the result", qacc.len(), model.nv);
    qacc.copy_from_slice(a);
    add_transport(model, v, 1.0, qacc);
    turn_linear_in_place(model, q, qacc, Quaternion::rotate);
}

/// `qacc` → v̇: u̇ = Rᵀẍ − ω × u. q and v are this library's.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn acceleration_from_mujoco(model: &Model, q: &[f64], v: &[f64], qacc: &[f64], a: &mut [f64]) {
    check_length("v", v.len(), model.nv);
    turn_linear(model, q, qacc, a, Quaternion::rotate_back);
    add_transport(model, v, -1.0, a);
}

/// Adds `sign` ω × u to the linear acceleration of each floating joint.
fn add_transport(model: &Model, v: &[f64], sign: f64, a: &mut [f64]) {
    for Stretch { v: k, .. } in stretches(model).filter(|stretch| stretch.chart == Chart::Placement) {
        let sum = vector_at(a, k) + vector_at(v, k + 3).cross(vector_at(v, k)) * sign;
        a[k..k + 3].copy_from_slice(&sum.array());
    }
}

fn reorder(model: &Model, from: &[f64], to: &mut [f64], order: impl Fn([f64; 4]) -> [f64; 4]) {
    check_length("the configuration", from.len(), model.nq);
    check_length("the result", to.len(), model.nq);
    to.copy_from_slice(from);
    for Stretch { chart, q: i, .. } in stretches(model) {
        let i = match chart {
            Chart::Line => continue,
            Chart::Rotation => i,
            Chart::Placement => i + 3,
        };
        to[i..i + 4].copy_from_slice(&order([from[i], from[i + 1], from[i + 2], from[i + 3]]));
    }
}

fn turn_linear(
    model: &Model,
    q: &[f64],
    from: &[f64],
    to: &mut [f64],
    turn: impl Fn(Quaternion, [f64; 3]) -> [f64; 3],
) {
    check_length("the vector", from.len(), model.nv);
    check_length("the result", to.len(), model.nv);
    to.copy_from_slice(from);
    turn_linear_in_place(model, q, to, turn);
}

fn turn_linear_in_place(
    model: &Model,
    q: &[f64],
    x: &mut [f64],
    turn: impl Fn(Quaternion, [f64; 3]) -> [f64; 3],
) {
    check_length("q", q.len(), model.nq);
    for Stretch { q: i, v: k, .. } in stretches(model).filter(|stretch| stretch.chart == Chart::Placement) {
        let turned = turn(quaternion_at(q, i + 3), vector_at(x, k).array());
        x[k..k + 3].copy_from_slice(&turned);
    }
}

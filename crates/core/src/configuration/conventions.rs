//! Conversion of states and forces to and from the conventions of MuJoCo and of Pinocchio
//! ([`PinocchioLayout`]).
//!
//! | | this library | MuJoCo |
//! | --- | --- | --- |
//! | quaternion in q | x y z w | w x y z |
//! | free joint, linear velocity | of the frame's origin, in body axes | of the frame's origin, in world axes |
//! | free joint, angular velocity | in body axes | in body axes |
//! | ball joint, angular velocity | in body axes | in body axes |
//! | free joint, force | dual to the velocity: body axes | dual to its own: force in world axes, moment in body axes |
//!
//! "World" is the parent frame of the floating joint. The order of joints is the same on both sides: depth
//! first, siblings in the file's order. In MuJoCo a universal joint is two hinges, and a planar joint two
//! slides and a hinge, with the same numbers. A mimic joint has no entry here; MuJoCo has one for it.

mod pinocchio;

pub use pinocchio::PinocchioLayout;

use robot_dynamics_description::{Quaternion, check_length};

use crate::Model;
use crate::configuration::manifold::{CoordinateRange, coordinate_ranges, quaternion_at, vector_at};
use crate::joint::Chart;

/// q → `qpos`: quaternions from x y z w to w x y z.
///
/// ```
/// use robot_dynamics::conventions::configuration_to_mujoco;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// let mut qpos = [0.0; 7];
/// configuration_to_mujoco(&model, &[1.0, 2.0, 3.0, 0.1, 0.3, 0.3, 0.9], &mut qpos);
/// assert_eq!(qpos, [1.0, 2.0, 3.0, 0.9, 0.1, 0.3, 0.3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn configuration_to_mujoco(model: &Model, q: &[f64], qpos: &mut [f64]) {
    reorder(model, q, qpos, |[x, y, z, w]| [w, x, y, z]);
}

/// `qpos` → q: quaternions from w x y z to x y z w.
///
/// ```
/// use robot_dynamics::conventions::{configuration_from_mujoco, configuration_to_mujoco};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (mut qpos, mut back) = (vec![0.0; model.nq()], vec![0.0; model.nq()]);
/// configuration_to_mujoco(&model, &q, &mut qpos);
/// configuration_from_mujoco(&model, &qpos, &mut back);
/// assert_eq!(back, q);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn configuration_from_mujoco(model: &Model, qpos: &[f64], q: &mut [f64]) {
    reorder(model, qpos, q, |[w, x, y, z]| [x, y, z, w]);
}

/// v → `qvel`: rotates the linear velocity of a floating joint to world axes, ẋ = R u.
///
/// ```
/// use robot_dynamics::conventions::velocity_to_mujoco;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// // A body turned left by a quarter: its forward direction is the world's y; ω stays in body axes.
/// let half = std::f64::consts::FRAC_1_SQRT_2;
/// let (q, v, mut qvel) = ([0.0, 0.0, 0.0, 0.0, 0.0, half, half], [2.0, 0.0, 0.0, 5.0, 0.0, 0.0], [0.0; 6]);
/// velocity_to_mujoco(&model, &q, &v, &mut qvel);
/// assert!(qvel.iter().zip([0.0, 2.0, 0.0, 5.0, 0.0, 0.0]).all(|(x, expected)| (x - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn velocity_to_mujoco(model: &Model, q: &[f64], v: &[f64], qvel: &mut [f64]) {
    turn_linear(model, q, v, qvel, Quaternion::rotate);
}

/// `qvel` → v: u = Rᵀ ẋ. q is in this library's convention.
///
/// ```
/// use robot_dynamics::conventions::{velocity_from_mujoco, velocity_to_mujoco};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (mut qvel, mut back) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// velocity_to_mujoco(&model, &q, &v, &mut qvel);
/// velocity_from_mujoco(&model, &q, &qvel, &mut back);
/// assert!(back.iter().zip(&v).all(|(back, v)| (back - v).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn velocity_from_mujoco(model: &Model, q: &[f64], qvel: &[f64], v: &mut [f64]) {
    turn_linear(model, q, qvel, v, Quaternion::rotate_back);
}

/// τ → `qfrc`: the power is preserved, τ·v = qfrc·qvel, so the force of a floating joint rotates as its
/// velocity does.
///
/// ```
/// use robot_dynamics::conventions::{force_to_mujoco, velocity_to_mujoco};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (mut qfrc, mut qvel) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// force_to_mujoco(&model, &q, &tau, &mut qfrc);
/// velocity_to_mujoco(&model, &q, &v, &mut qvel);
/// let power = |force: &[f64], velocity: &[f64]| force.iter().zip(velocity).map(|(f, v)| f * v).sum::<f64>();
/// assert!((power(&qfrc, &qvel) - power(&tau, &v)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn force_to_mujoco(model: &Model, q: &[f64], tau: &[f64], qfrc: &mut [f64]) {
    turn_linear(model, q, tau, qfrc, Quaternion::rotate);
}

/// `qfrc` → τ. q is in this library's convention.
///
/// ```
/// use robot_dynamics::conventions::{force_from_mujoco, force_to_mujoco};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (mut qfrc, mut back) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// force_to_mujoco(&model, &q, &tau, &mut qfrc);
/// force_from_mujoco(&model, &q, &qfrc, &mut back);
/// assert!(back.iter().zip(&tau).all(|(back, tau)| (back - tau).abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn force_from_mujoco(model: &Model, q: &[f64], qfrc: &[f64], tau: &mut [f64]) {
    turn_linear(model, q, qfrc, tau, Quaternion::rotate_back);
}

/// v̇ → `qacc`: ẍ = R(u̇ + ω × u), because body axes rotate and world axes do not.
///
/// ```
/// use robot_dynamics::conventions::acceleration_to_mujoco;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// // On a circle at constant speed the velocity in body axes is constant. In world axes ẍ = ω u to the left.
/// let (q, v) = ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [2.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
/// let mut qacc = [0.0; 6];
/// acceleration_to_mujoco(&model, &q, &v, &[0.0; 6], &mut qacc);
/// assert_eq!(qacc, [0.0, 3.0 * 2.0, 0.0, 0.0, 0.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

/// `qacc` → v̇: u̇ = Rᵀẍ − ω × u. q and v are in this library's convention.
///
/// ```
/// use robot_dynamics::conventions::{acceleration_from_mujoco, acceleration_to_mujoco};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (mut qacc, mut back) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// acceleration_to_mujoco(&model, &q, &v, &a, &mut qacc);
/// acceleration_from_mujoco(&model, &q, &v, &qacc, &mut back);
/// assert!(back.iter().zip(&a).all(|(back, a)| (back - a).abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
pub fn add_transport(model: &Model, v: &[f64], sign: f64, a: &mut [f64]) {
    for CoordinateRange { v: k, .. } in
        coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Placement)
    {
        let sum = vector_at(a, k) + vector_at(v, k + 3).cross(vector_at(v, k)) * sign;
        a[k..k + 3].copy_from_slice(&sum.array());
    }
}

fn reorder(model: &Model, from: &[f64], to: &mut [f64], order: impl Fn([f64; 4]) -> [f64; 4]) {
    check_length("the configuration", from.len(), model.nq);
    check_length("the result", to.len(), model.nq);
    to.copy_from_slice(from);
    for CoordinateRange { chart, q: i, .. } in coordinate_ranges(model) {
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
    for CoordinateRange { q: i, v: k, .. } in
        coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Placement)
    {
        let turned = turn(quaternion_at(q, i + 3), vector_at(x, k).array());
        x[k..k + 3].copy_from_slice(&turned);
    }
}

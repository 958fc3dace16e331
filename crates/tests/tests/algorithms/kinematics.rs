//! Poses, velocities, Jacobians and accelerations of frames, against derivatives of the kinematics of the
//! Lagrange recipe, which share no code with the recursions.
//!
//! Tolerance: positions are sums over at most about 60 links; 1e-12 of the largest term allows 4500
//! roundings.

use robot_dynamics::algorithms::{
    ReferenceFrame, SpatialAcceleration, Twist, frame_acceleration, frame_bias_acceleration, frame_jacobian,
    frame_pose, frame_poses, frame_velocity,
};
use robot_dynamics::model::{FrameId, Model, Workspace};
use robot_dynamics::number::{Dual, Scalar};
use robot_dynamics::verification::lagrange;
use robot_dynamics::verification::lagrange::LinkKinematics;

use crate::common::{Robot, families, max_difference, times};
use robot_dynamics::description::Pose;

const ROUNDING: f64 = 1e-12;

/// A number with a first derivative by time.
type Rate = Dual<f64, 1>;
/// A number with two derivatives by time: a dual number of dual numbers.
pub(crate) type SecondRate = Dual<Rate, 1>;

/// q(t) = q + t q̇ and its second derivative, as numbers that carry two derivatives by time: q̇ = N(q) v with
/// v(t) = v + t a.
pub(crate) fn moving(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<SecondRate> {
    let constant = |x: &[f64]| x.iter().map(|&x| Rate::constant(x)).collect::<Vec<_>>();
    let first: Vec<f64> = lagrange::position_rate(model, q, v);
    let q_rate: Vec<Rate> = q.iter().zip(&first).map(|(&q, &r)| Dual { value: q, gradient: [r] }).collect();
    let v_rate: Vec<Rate> = v.iter().zip(a).map(|(&v, &a)| Dual { value: v, gradient: [a] }).collect();
    // d/dt N(q(t)) v(t) = q̈.
    let rate = lagrange::position_rate(model, &q_rate, &v_rate);
    constant(q)
        .iter()
        .zip(&rate)
        .map(|(q, rate)| Dual { value: Dual { value: q.value, gradient: [rate.value] }, gradient: [*rate] })
        .collect()
}

/// (linear, angular) of a frame in each of the three reference frames, from its moving pose: ṗ, vee(Ṙ Rᵀ).
struct Velocities<S> {
    world_aligned: [S; 6],
    in_frame: [S; 6],
    in_world: [S; 6],
}

fn velocities<S: Scalar>(pose: &Pose<Dual<S, 1>>) -> Velocities<S> {
    let value = |x: &Dual<S, 1>| x.value;
    let rate = |x: &Dual<S, 1>| x.gradient[0];
    let r = &pose.rotation;
    // Ω = Ṙ Rᵀ.
    let omega = |i: usize, j: usize| (0..3).fold(S::zero(), |sum, k| sum + rate(&r[i][k]) * value(&r[j][k]));
    let w = [omega(2, 1), omega(0, 2), omega(1, 0)];
    let u: [S; 3] = std::array::from_fn(|i| rate(&pose.translation[i]));
    let p: [S; 3] = std::array::from_fn(|i| value(&pose.translation[i]));
    let turned = |x: &[S; 3]| -> [S; 3] {
        std::array::from_fn(|j| (0..3).fold(S::zero(), |sum, i| sum + value(&r[i][j]) * x[i]))
    };
    // The point at the world's origin: u − ω × p.
    let shifted = [
        u[0] - (w[1] * p[2] - w[2] * p[1]),
        u[1] - (w[2] * p[0] - w[0] * p[2]),
        u[2] - (w[0] * p[1] - w[1] * p[0]),
    ];
    let join = |a: [S; 3], b: [S; 3]| [a[0], a[1], a[2], b[0], b[1], b[2]];
    Velocities {
        world_aligned: join(u, w),
        in_frame: join(turned(&u), turned(&w)),
        in_world: join(shifted, w),
    }
}

/// The pose of a frame from the kinematics of the Lagrange recipe, through its link.
fn reference_pose<S: Scalar>(model: &Model, links: &[LinkKinematics<S>], frame: usize) -> Pose<S> {
    let description = model.description();
    let of_link = |link: usize| Pose { rotation: links[link].rotation(), translation: links[link].origin() };
    if frame < description.links.len() {
        return of_link(frame);
    }
    let frame = &description.frames[frame - description.links.len()];
    let link =
        description.links.iter().position(|link| link.name == frame.link).expect("a link of the robot");
    let of_link = of_link(link);
    let own = frame.link_from_frame;
    let rotation = of_link.rotation.map(|row| {
        std::array::from_fn(|j| (0..3).fold(S::zero(), |sum, k| sum + row[k].scale(own.rotation[k][j])))
    });
    Pose { rotation, translation: links[link].point(own.translation.map(S::from_f64)) }
}

fn numbers(linear: [f64; 3], angular: [f64; 3]) -> Vec<f64> {
    [linear, angular].concat()
}

fn velocity_numbers(twist: &Twist) -> Vec<f64> {
    numbers(twist.linear, twist.angular)
}

fn acceleration_numbers(acceleration: &SpatialAcceleration) -> Vec<f64> {
    numbers(acceleration.linear, acceleration.angular)
}

fn entries(pose: &Pose) -> Vec<f64> {
    pose.rotation.iter().flatten().chain(&pose.translation).copied().collect()
}

/// The frames to check: all, or five of many.
fn frames(model: &Model) -> Vec<(usize, FrameId)> {
    let all: Vec<(usize, FrameId)> = model
        .frames()
        .iter()
        .map(|frame| model.frame(&frame.name).expect("its own name"))
        .enumerate()
        .collect();
    let stride = (all.len() / 5).max(1);
    all.into_iter().rev().step_by(stride).collect()
}

fn robots() -> Vec<Robot> {
    families().iter().flat_map(|family| family.robots().take(25).collect::<Vec<_>>()).collect()
}

/// The largest distance: the number of links that a position sums, each of order a metre (a few for sliding
/// joints).
fn reach(model: &Model) -> f64 {
    2.0 * (model.joints().len() + 1) as f64
}

#[test]
fn poses_match_the_lagrange_kinematics() {
    for robot in robots() {
        let (model, q) = (&robot.model, &robot.state.q[..]);
        let workspace = &mut Workspace::new(model);
        let zero = Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        let mut all = vec![zero; model.frames().len()];
        frame_poses(model, workspace, q, &mut all);
        let links = lagrange::link_kinematics(model, q);
        for (index, frame) in frames(model) {
            let pose = frame_pose(model, workspace, q, frame);
            assert_eq!(pose, all[index]);
            let defect = max_difference(&entries(&pose), &entries(&reference_pose(model, &links, index)));
            robot.require("frame pose", defect, ROUNDING * reach(model));
        }
    }
}

#[test]
fn velocities_and_accelerations_are_derivatives_of_poses() {
    for robot in robots() {
        let model = &robot.model;
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let w = &mut Workspace::new(model);
        let speed = v.iter().map(|v| v.abs()).sum::<f64>() + 1.0;
        let surge = a.iter().map(|a| a.abs()).sum::<f64>() + speed * speed;
        let links = lagrange::link_kinematics(model, &moving(model, q, v, a));
        for (index, frame) in frames(model) {
            let oracle = velocities(&reference_pose(model, &links, index));
            let value = |x: [Rate; 6]| x.map(|x| x.value);
            let rate = |x: [Rate; 6]| x.map(|x| x.gradient[0]);
            let first = [
                (
                    "ṗ, ω world aligned",
                    frame_velocity(model, w, q, v, frame, ReferenceFrame::LocalWorldAligned),
                    oracle.world_aligned,
                ),
                (
                    "ṗ, ω in the frame",
                    frame_velocity(model, w, q, v, frame, ReferenceFrame::Local),
                    oracle.in_frame,
                ),
                (
                    "u, ω in the world",
                    frame_velocity(model, w, q, v, frame, ReferenceFrame::World),
                    oracle.in_world,
                ),
            ];
            for (law, twist, oracle) in first {
                let defect = max_difference(&velocity_numbers(&twist), &value(oracle));
                robot.require(law, defect, ROUNDING * reach(model) * speed);
            }
            let second = [
                (
                    "classical acceleration",
                    frame_acceleration(model, w, q, v, a, frame, ReferenceFrame::LocalWorldAligned),
                    oracle.world_aligned,
                ),
                (
                    "spatial acceleration in the frame",
                    frame_acceleration(model, w, q, v, a, frame, ReferenceFrame::Local),
                    oracle.in_frame,
                ),
                (
                    "spatial acceleration in the world",
                    frame_acceleration(model, w, q, v, a, frame, ReferenceFrame::World),
                    oracle.in_world,
                ),
            ];
            for (law, acceleration, oracle) in second {
                let defect = max_difference(&acceleration_numbers(&acceleration), &rate(oracle));
                robot.require(law, defect, ROUNDING * reach(model) * surge);
            }
        }
    }
}

/// J v is the velocity, each column that of a unit velocity; J a + J̇ v is the acceleration.
#[test]
fn jacobians_map_velocities_and_accelerations() {
    for robot in robots() {
        let model = &robot.model;
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let (w, nv) = (&mut Workspace::new(model), model.nv());
        let speed = v.iter().map(|v| v.abs()).sum::<f64>() + 1.0;
        let surge = a.iter().map(|a| a.abs()).sum::<f64>() + speed * speed;
        let mut jacobian = vec![0.0; 6 * nv];
        let zero = vec![0.0; nv];
        let moved = |k: usize| {
            let mut unit = zero.clone();
            unit[k] = 1.0;
            lagrange::link_kinematics(model, &moving(model, q, &unit, &zero))
        };
        let moved: Vec<_> = (0..nv.min(30)).map(moved).collect();
        for (index, frame) in frames(model) {
            let check = |law: &str,
                         j: &[f64],
                         acceleration: &SpatialAcceleration,
                         bias: &SpatialAcceleration,
                         form: usize| {
                for (k, links) in moved.iter().enumerate() {
                    let oracle = velocities(&reference_pose(model, links, index));
                    let oracle = [oracle.world_aligned, oracle.in_frame, oracle.in_world][form];
                    let column: Vec<f64> = j.iter().skip(k).step_by(nv).copied().collect();
                    let defect = max_difference(&column, &oracle.map(|x| x.value));
                    robot.require(law, defect, ROUNDING * reach(model));
                }
                let sum: Vec<f64> =
                    times(j, a).iter().zip(acceleration_numbers(bias)).map(|(x, y)| x + y).collect();
                let defect = max_difference(&sum, &acceleration_numbers(acceleration));
                robot.require("J a + J̇ v", defect, ROUNDING * reach(model) * surge);
            };
            for (law, seen, form) in [
                ("J world aligned", ReferenceFrame::LocalWorldAligned, 0),
                ("J in the frame", ReferenceFrame::Local, 1),
                ("J in the world", ReferenceFrame::World, 2),
            ] {
                frame_jacobian(model, w, q, frame, seen, &mut jacobian);
                let acceleration = frame_acceleration(model, w, q, v, a, frame, seen);
                let bias = frame_bias_acceleration(model, w, q, v, frame, seen);
                check(law, &jacobian, &acceleration, &bias, form);
            }
        }
    }
}

//! The program for the crate dynibo: states, timing and output as in `side.hpp`.
//!
//! Its base velocities are [angular, linear] in world axes, its accelerations classical; run.py converts.
//! Joints are named j0, j1, ... in the order of the states.

use std::hint::black_box;
use std::time::Instant;

use dynibo::{BaseState, FloatingRobot, Frame, LinkId, Robot, Twist};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

enum AnyRobot {
    Fixed(Robot),
    Floating(FloatingRobot),
}

#[derive(Clone, Copy)]
enum Algorithm {
    InverseDynamics,
    ForwardDynamics,
    MassMatrix,
    FramePoses,
    Jacobian,
}

/// Calls between two clock readings.
const BLOCK: usize = 128;

/// One state in dynibo's order of joints.
struct State {
    base: BaseState,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, robot, states, algorithm, mode, value] = arguments.as_slice() else {
        panic!("usage: dynibo_side ROBOT STATES ALGORITHM (time MS | calls N | write FILE)");
    };
    let bytes = std::fs::read(states).expect("the file of states is readable");
    let word = |i: usize| u64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap());
    let [count, nq, nv, tip] = [0, 1, 2, 3].map(|i| word(i) as usize);
    let numbers: Vec<f64> = (4..bytes.len() / 8).map(|i| f64::from_bits(word(i))).collect();
    assert_eq!(numbers.len(), count * (nq + 3 * nv));
    let floating = nq != nv;
    let base_nv = if floating { 6 } else { 0 };

    let mut robot = if floating {
        AnyRobot::Floating(FloatingRobot::from_urdf(robot).expect("a robot"))
    } else {
        AnyRobot::Fixed(Robot::from_urdf(robot).expect("a robot"))
    };
    let place_of = |name: &str| name[1..].parse::<usize>().expect("j and a number");
    let link = |name: &str| match &robot {
        AnyRobot::Fixed(robot) => robot.link_id(name).expect("a link"),
        AnyRobot::Floating(robot) => robot.link_id(name).expect("a link"),
    };
    // places[i]: the index of dynibo's joint i among the joints of the states.
    let places: Vec<usize> = (0..nv - base_nv)
        .map(|i| match &robot {
            AnyRobot::Fixed(robot) => place_of(robot.joint_name(i).unwrap()),
            AnyRobot::Floating(robot) => place_of(robot.joint_name(i).unwrap()),
        })
        .collect();
    let tip = link(&format!("l{tip}"));
    // Its own order of links: the index of link k in the states.
    let root = if floating { vec!["root".to_owned()] } else { vec![] };
    let links: Vec<LinkId> =
        root.into_iter().chain((0..nv - base_nv).map(|k| format!("l{k}"))).map(|name| link(&name)).collect();
    let link_count = match &robot {
        AnyRobot::Fixed(robot) => robot.link_count(),
        AnyRobot::Floating(robot) => robot.link_count(),
    };

    let states: Vec<State> = numbers
        .chunks_exact(nq + 3 * nv)
        .map(|numbers| {
            let (q, rest) = numbers.split_at(nq);
            let [v, a, tau] = [0, 1, 2].map(|k| &rest[k * nv..(k + 1) * nv]);
            let joints = |x: &[f64], skip: usize| places.iter().map(|&k| x[skip + k]).collect::<Vec<_>>();
            let all = |x: &[f64]| x[..base_nv].iter().copied().chain(joints(x, base_nv)).collect();
            State {
                base: if floating {
                    base_state(q, v, a)
                } else {
                    BaseState::stationary(Frame::identity()).unwrap()
                },
                q: joints(q, nq - places.len()),
                v: joints(v, base_nv),
                a: joints(a, base_nv),
                tau: all(tau),
            }
        })
        .collect();

    let mut vector = vec![0.0; nv];
    let mut matrix = vec![0.0; nv * nv];
    let mut jacobian = vec![0.0; 6 * nv];
    let mut frames = vec![Frame::identity(); link_count];
    let algorithm = match algorithm.as_str() {
        "inverse_dynamics" => Algorithm::InverseDynamics,
        "forward_dynamics" => Algorithm::ForwardDynamics,
        "mass_matrix" => Algorithm::MassMatrix,
        "frame_poses" => Algorithm::FramePoses,
        "jacobian" => Algorithm::Jacobian,
        _ => panic!("no algorithm {algorithm}"),
    };
    let mut call = |i: usize| -> Vec<f64> {
        let state = black_box(&states[i]);
        let State { base, q, v, a, tau } = state;
        match (&mut robot, algorithm) {
            (AnyRobot::Fixed(r), Algorithm::InverseDynamics) => r.inverse_dynamics(q, v, a, &[], &mut vector),
            (AnyRobot::Floating(r), Algorithm::InverseDynamics) => {
                r.inverse_dynamics(base, q, v, a, &[], &mut vector)
            }
            (AnyRobot::Fixed(r), Algorithm::ForwardDynamics) => {
                r.forward_dynamics(q, v, tau, &[], &mut vector)
            }
            (AnyRobot::Floating(r), Algorithm::ForwardDynamics) => {
                r.forward_dynamics(base, q, v, tau, &[], &mut vector)
            }
            (AnyRobot::Fixed(r), Algorithm::MassMatrix) => r.mass_matrix(q, &mut matrix),
            (AnyRobot::Floating(r), Algorithm::MassMatrix) => r.mass_matrix(base, q, &mut matrix),
            (AnyRobot::Fixed(r), Algorithm::FramePoses) => r.forward_kinematics_all(q, &mut frames),
            (AnyRobot::Floating(r), Algorithm::FramePoses) => r.forward_kinematics_all(base, q, &mut frames),
            (AnyRobot::Fixed(r), Algorithm::Jacobian) => r.jacobian(q, tip, &mut jacobian),
            (AnyRobot::Floating(r), Algorithm::Jacobian) => r.jacobian(base, q, tip, &mut jacobian),
        }
        .expect("finite numbers");
        black_box((&vector, &matrix, &jacobian, &frames));
        if mode != "write" {
            return Vec::new();
        }
        // Back to the order of the states, with matrices in row-major order.
        let mut place: Vec<usize> = (0..base_nv).collect();
        place.extend(places.iter().map(|&k| base_nv + k));
        let mut out = Vec::new();
        match algorithm {
            Algorithm::MassMatrix => {
                out.resize(nv * nv, 0.0);
                for (j, column) in matrix.chunks_exact(nv).enumerate() {
                    for (i, x) in column.iter().enumerate() {
                        out[place[i] * nv + place[j]] = *x;
                    }
                }
            }
            Algorithm::Jacobian => {
                out.resize(6 * nv, 0.0);
                for (j, column) in jacobian.chunks_exact(6).enumerate() {
                    for (i, x) in column.iter().enumerate() {
                        out[(i + 3) % 6 * nv + place[j]] = *x; // angular first there, linear first here
                    }
                }
            }
            Algorithm::FramePoses => {
                for id in &links {
                    let at = (0..link_count).find(|&k| match &robot {
                        AnyRobot::Fixed(r) => r.link_id_at(k).unwrap() == *id,
                        AnyRobot::Floating(r) => r.link_id_at(k).unwrap() == *id,
                    });
                    let frame = &frames[at.expect("a link")];
                    let rotation = frame.rotation.to_rotation_matrix();
                    out.extend(rotation.matrix().transpose().iter());
                    out.extend(frame.translation.vector.iter());
                }
            }
            _ => {
                out.resize(nv, 0.0);
                for (i, x) in vector.iter().enumerate() {
                    out[place[i]] = *x;
                }
            }
        }
        out
    };

    match mode.as_str() {
        "time" => {
            let milliseconds: f64 = value.parse().expect("milliseconds");
            (0..count).for_each(|i| drop(call(i)));
            let (start, mut blocks) = (Instant::now(), Vec::new());
            while blocks.is_empty() || start.elapsed().as_secs_f64() * 1e3 < milliseconds {
                for first in (0..=count - BLOCK).step_by(BLOCK) {
                    let before = Instant::now();
                    (first..first + BLOCK).for_each(|i| drop(call(i)));
                    blocks.push(before.elapsed().as_secs_f64() * 1e9 / BLOCK as f64);
                }
            }
            blocks.sort_by(f64::total_cmp);
            let (median, min) = (blocks[blocks.len() / 2], blocks[0]);
            println!(r#"{{"median_ns": {median:.3}, "min_ns": {min:.3}, "blocks": {}}}"#, blocks.len());
        }
        "calls" => (0..value.parse().expect("a number of calls")).for_each(|i: usize| drop(call(i % count))),
        "write" => {
            let out: Vec<u8> = (0..count).flat_map(|i| call(i)).flat_map(f64::to_le_bytes).collect();
            std::fs::write(value, out).expect("the output is writable");
        }
        _ => panic!("time, calls or write, not {mode}"),
    }
}

fn base_state(q: &[f64], v: &[f64], a: &[f64]) -> BaseState {
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(q[6], q[3], q[4], q[5]));
    let frame = Frame::from_parts(Translation3::new(q[0], q[1], q[2]), turn);
    let twist = |x: &[f64]| Twist::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]));
    BaseState::new(frame, twist(v), twist(a)).expect("finite numbers")
}

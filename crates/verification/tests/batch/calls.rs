//! Batches against the functions of single states; equal bit for bit with any threads and any split.

use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian};
use robot_dynamics::batch;
use robot_dynamics::batch::{BadStates, BatchFloat, BatchOptions, BatchWorkspace};
use robot_dynamics::description::{RandomRobotOptions, random_robot};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{Robot, families, size};

/// Random states of one robot, in sequence.
struct States<T> {
    count: usize,
    q: Vec<T>,
    v: Vec<T>,
    a: Vec<T>,
    tau: Vec<T>,
}

impl States<f64> {
    fn random(model: &Model, count: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let [mut q, mut v, mut a, mut tau] = [(); 4].map(|()| Vec::new());
        for _ in 0..count {
            let state = random_state(model, &mut random);
            q.extend(state.q);
            v.extend(state.v);
            a.extend(state.a);
            tau.extend(state.tau);
        }
        Self { count, q, v, a, tau }
    }

    #[allow(clippy::cast_possible_truncation)]
    fn single(&self) -> States<f32> {
        let round = |x: &[f64]| x.iter().map(|&x| x as f32).collect();
        States {
            count: self.count,
            q: round(&self.q),
            v: round(&self.v),
            a: round(&self.a),
            tau: round(&self.tau),
        }
    }
}

fn robots() -> Vec<Robot> {
    families().iter().flat_map(|family| family.robots().take(4).collect::<Vec<_>>()).collect()
}

fn workspace<T: BatchFloat>(model: &Model, threads: usize, no_avx512: bool) -> BatchWorkspace<T> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    options.limit = no_avx512.then_some(InstructionSet::Avx2);
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The names of the batch functions, for [`compute`] and [`compute_singly`].
const ALL: [&str; 6] =
    ["inverse dynamics", "bias", "gravity", "forward dynamics", "mass matrix", "inverse mass matrix"];

/// The result of a batch function for all states.
fn compute<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    states: &States<T>,
    name: &str,
) -> (Vec<T>, Result<(), BadStates>) {
    let nv = model.nv();
    let width = if name.contains("matrix") { nv * nv } else { nv };
    let mut out = vec![T::from_f64(-7.0); states.count * width];
    let (q, v, a, tau) = (&states.q[..], &states.v[..], &states.a[..], &states.tau[..]);
    let result = match name {
        "inverse dynamics" => batch::inverse_dynamics(model, workspace, q, v, a, &mut out),
        "bias" => batch::bias(model, workspace, q, v, &mut out),
        "gravity" => batch::gravity(model, workspace, q, &mut out),
        "forward dynamics" => batch::forward_dynamics(model, workspace, q, v, tau, &mut out),
        "mass matrix" => batch::mass_matrix(model, workspace, q, &mut out),
        "inverse mass matrix" => batch::inverse_mass_matrix(model, workspace, q, &mut out),
        _ => unreachable!(),
    };
    (out, result)
}

/// The same by the function of a single state.
fn compute_singly(model: &Model, states: &States<f64>, name: &str) -> Vec<f64> {
    let (nq, nv) = (model.nq(), model.nv());
    let w = &mut Workspace::new(model);
    let width = if name.contains("matrix") { nv * nv } else { nv };
    let mut out = vec![0.0; states.count * width];
    for (i, out) in out.chunks_mut(width.max(1)).enumerate() {
        let row = |x: &[f64], n: usize| x[i * n..(i + 1) * n].to_vec();
        let (q, v) = (&row(&states.q, nq)[..], &row(&states.v, nv)[..]);
        let (a, tau) = (&row(&states.a, nv)[..], &row(&states.tau, nv)[..]);
        match name {
            "inverse dynamics" => robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, out),
            "bias" => robot_dynamics::algorithms::bias(model, w, q, v, out),
            "gravity" => robot_dynamics::algorithms::gravity(model, w, q, out),
            "forward dynamics" => robot_dynamics::algorithms::forward_dynamics(model, w, q, v, tau, out),
            "mass matrix" => robot_dynamics::algorithms::mass_matrix(model, w, q, out),
            "inverse mass matrix" => robot_dynamics::algorithms::inverse_mass_matrix(model, w, q, out),
            _ => unreachable!(),
        }
    }
    out
}

/// 1e-12 of the largest number of the state, times κ(M) ε where M is inverted.
#[test]
fn batches_match_single_states() {
    for robot in robots() {
        let model = &robot.model;
        let states = States::random(model, 9, robot.seed);
        for no_avx512 in [false, true] {
            let mut workspace = workspace(model, 1, no_avx512);
            for name in ALL {
                let (found, result) = compute(model, &mut workspace, &states, name);
                assert_eq!(result, Ok(()), "{name} of \"{}\", seed {}", robot.family, robot.seed);
                let expected = compute_singly(model, &states, name);
                let width = (expected.len() / states.count).max(1);
                for (i, (found, expected)) in found.chunks(width).zip(expected.chunks(width)).enumerate() {
                    let allowed = if name.starts_with("forward") || name.starts_with("inverse mass") {
                        let mut own = Robot::new(robot.family, robot.seed, &options_of(&robot));
                        own.state.q = states.q[i * model.nq()..(i + 1) * model.nq()].to_vec();
                        (1e2 * f64::EPSILON * own.condition()).max(1e-12)
                    } else {
                        1e-12
                    };
                    let defect = crate::common::max_difference(found, expected);
                    robot.require(&format!("{name} of state {i}"), defect, allowed * size(expected).max(1.0));
                }
            }
        }
    }
}

fn options_of(robot: &Robot) -> RandomRobotOptions {
    families().into_iter().find(|family| family.name == robot.family).unwrap().options
}

fn bits<T: BatchFloat>(x: &[T]) -> Vec<String> {
    x.iter().map(|x| format!("{x:?}")).collect()
}

/// With any number of states and threads, and with narrow lanes, the results equal those of a batch of a
/// thousand, bit for bit.
#[test]
fn results_are_equal_bit_for_bit_for_any_split() {
    let options = RandomRobotOptions {
        base: robot_dynamics::description::Base::Floating,
        joints: 6,
        ..Default::default()
    };
    for (seed, mimic) in [(5, 0.0), (6, 0.5)] {
        let model = Model::new(random_robot(seed, &RandomRobotOptions { mimic, ..options.clone() })).unwrap();
        let all = States::random(&model, 1000, seed);
        for name in ALL {
            let whole = compute(&model, &mut workspace(&model, 1, false), &all, name).0;
            let width = whole.len() / all.count;
            for threads in [1, 2, 3] {
                for no_avx512 in [false, true] {
                    let mut workspace = workspace(&model, threads, no_avx512);
                    for count in [0, 1, 7, 8, 9, 1000] {
                        // The last states, so that each state is in another lane than in the whole batch.
                        let first = all.count - count;
                        let (nq, nv) = (model.nq(), model.nv());
                        let part = States {
                            count,
                            q: all.q[first * nq..].to_vec(),
                            v: all.v[first * nv..].to_vec(),
                            a: all.a[first * nv..].to_vec(),
                            tau: all.tau[first * nv..].to_vec(),
                        };
                        let (found, result) = compute(&model, &mut workspace, &part, name);
                        assert_eq!(result, Ok(()));
                        assert!(
                            bits(&found) == bits(&whole[first * width..]),
                            "{name}, {count} states, {threads} threads, seed {seed}"
                        );
                    }
                }
            }
        }
    }
}

/// f32 differs from f64 by some hundred roundings of 6e-8 of the largest number of the state. The tolerance
/// is 1e-4 of that number, and κ(M) times that where M is inverted. Only well-conditioned robots can be
/// compared.
#[test]
fn f32_is_close_to_f64() {
    let mut judged = 0;
    for robot in robots().iter().filter(|robot| robot.condition() < 1e3) {
        let model = &robot.model;
        let single = States::random(model, 17, robot.seed).single();
        let wide = |x: &[f32]| x.iter().map(|&x| f64::from(x)).collect();
        let states = States {
            count: single.count,
            q: wide(&single.q),
            v: wide(&single.v),
            a: wide(&single.a),
            tau: wide(&single.tau),
        };
        for no_avx512 in [false, true] {
            let mut workspace = workspace::<f32>(model, 1, no_avx512);
            for name in ALL {
                let (found, result) = compute(model, &mut workspace, &single, name);
                assert_eq!(result, Ok(()), "{name} of \"{}\", seed {}", robot.family, robot.seed);
                let expected = compute_singly(model, &states, name);
                let inverts = name.starts_with("forward") || name.starts_with("inverse mass");
                let width = (expected.len() / states.count).max(1);
                for (i, (found, expected)) in found.chunks(width).zip(expected.chunks(width)).enumerate() {
                    let allowed = 1e-4 * if inverts { condition_at(robot, &states.q, i) } else { 1.0 };
                    if allowed > 0.1 {
                        continue;
                    }
                    judged += 1;
                    let found: Vec<f64> = found.iter().map(|&x| f64::from(x)).collect();
                    let defect = crate::common::max_difference(&found, expected);
                    robot.require(&format!("{name} of state {i}"), defect, allowed * size(expected).max(1.0));
                }
            }
        }
    }
    assert!(judged > 500, "only {judged} results were judged");
}

/// κ(M) in state i.
fn condition_at(robot: &Robot, q: &[f64], i: usize) -> f64 {
    let mut own = Robot::new(robot.family, robot.seed, &options_of(robot));
    own.state.q = q[i * robot.model.nq()..(i + 1) * robot.model.nq()].to_vec();
    own.condition()
}

/// With a NaN, an infinity or an angle beyond the range of the polynomial in one state, every other state is
/// equal bit for bit.
#[test]
fn bad_states_are_named_and_others_unchanged() {
    let options = RandomRobotOptions {
        base: robot_dynamics::description::Base::Floating,
        joints: 6,
        ..Default::default()
    };
    for mimic in [0.0, 0.5] {
        let model = Model::new(random_robot(9, &RandomRobotOptions { mimic, ..options.clone() })).unwrap();
        let (nq, nv) = (model.nq(), model.nv());
        let good = States::random(&model, 50, 1);
        let mut spoilt = States::random(&model, 50, 1);
        spoilt.q[3 * nq + nq - 1] = f64::NAN;
        spoilt.q[11 * nq] = f64::INFINITY;
        // A zero quaternion.
        spoilt.q[12 * nq + 3..12 * nq + 7].fill(0.0);
        spoilt.q[49 * nq] = f64::NEG_INFINITY;
        let kinds = |name: &str| match name {
            "inverse dynamics" => vec![3, 11, 12, 20, 21, 49],
            "bias" => vec![3, 11, 12, 20, 49],
            "forward dynamics" => vec![3, 11, 12, 20, 22, 49],
            _ => vec![3, 11, 12, 49],
        };
        spoilt.v[20 * nv + 2] = f64::NAN;
        spoilt.a[21 * nv + 1] = f64::NAN;
        spoilt.tau[22 * nv] = f64::INFINITY;
        for threads in [1, 3] {
            for no_avx512 in [false, true] {
                let mut workspace = workspace(&model, threads, no_avx512);
                for name in ALL {
                    let expected = compute(&model, &mut workspace, &good, name).0;
                    let (found, result) = compute(&model, &mut workspace, &spoilt, name);
                    let error = result.unwrap_err();
                    assert_eq!((error.states, error.batch), (kinds(name), 50), "{name}");
                    let width = found.len() / 50;
                    for i in 0..50 {
                        let (found, expected) =
                            (&found[i * width..][..width], &expected[i * width..][..width]);
                        if kinds(name).contains(&i) {
                            assert!(found.iter().all(|x| x.is_nan()), "{name} of state {i}: {found:?}");
                        } else {
                            assert_eq!(bits(found), bits(expected), "{name} of state {i}");
                        }
                    }
                }
            }
        }
    }
}

/// An angle beyond the range of the polynomial gives a correct result and does not change other states.
#[test]
fn angles_out_of_range_are_correct() {
    let options = RandomRobotOptions {
        kinds: robot_dynamics::description::JointKinds::Turning,
        fixed: 0.0,
        joints: 5,
        ..Default::default()
    };
    let model = Model::new(random_robot(2, &options)).unwrap();
    let near = States::random(&model, 16, 3);
    let mut far = States::random(&model, 16, 3);
    far.q[5 * model.nq()] = 1e7;
    for no_avx512 in [false, true] {
        let mut workspace = workspace(&model, 1, no_avx512);
        let expected = compute(&model, &mut workspace, &near, "gravity").0;
        let (found, result) = compute(&model, &mut workspace, &far, "gravity");
        assert_eq!(result, Ok(()));
        let singly = compute_singly(&model, &far, "gravity");
        for (i, found) in found.chunks(model.nv()).enumerate() {
            let at = i * model.nv()..(i + 1) * model.nv();
            if i == 5 {
                let scale = size(&singly[at.clone()]).max(1.0);
                assert!(crate::common::max_difference(found, &singly[at]) < 1e-12 * scale);
            } else {
                assert_eq!(bits(found), bits(&expected[at]), "state {i}");
            }
        }
    }
}

/// Poses consist of rotations and metres, Jacobians of lever arms: 1e-12 of the largest.
#[test]
fn frames_of_batch_match_single_states() {
    for robot in robots() {
        let model = &robot.model;
        let states = States::random(model, 9, robot.seed);
        let (nq, nv) = (model.nq(), model.nv());
        let frames: Vec<_> = model.frames().iter().filter_map(|frame| model.frame(&frame.name)).collect();
        let mut batch = workspace(model, 1, robot.seed % 2 == 1);
        let mut single = Workspace::new(model);
        let mut poses = vec![0.0; 9 * frames.len() * batch::NUMBERS_PER_POSE];
        batch::frame_poses(model, &mut batch, &states.q, &frames, &mut poses).unwrap();
        let frame = *frames.last().unwrap();
        let mut jacobians = [(); 3].map(|()| vec![0.0; 9 * 6 * nv]);
        for (reference_frame, jacobians) in ReferenceFrame::ALL.into_iter().zip(&mut jacobians) {
            batch::frame_jacobian(model, &mut batch, &states.q, frame, reference_frame, jacobians).unwrap();
        }
        for i in 0..9 {
            let q = &states.q[i * nq..(i + 1) * nq];
            let row = &poses[i * frames.len() * 12..(i + 1) * frames.len() * 12];
            for (&frame, found) in frames.iter().zip(row.chunks(12)) {
                let pose = robot_dynamics::algorithms::frame_pose(model, &mut single, q, frame);
                let expected: Vec<f64> =
                    pose.rotation.into_iter().flatten().chain(pose.translation).collect();
                let defect = crate::common::max_difference(found, &expected);
                robot.require(&format!("{frame:?} of state {i}"), defect, 1e-12 * size(&expected));
            }
            for (reference_frame, found) in ReferenceFrame::ALL.into_iter().zip(&jacobians) {
                let expected = &mut vec![0.0; 6 * nv][..];
                frame_jacobian(model, &mut single, q, frame, reference_frame, expected);
                let defect = crate::common::max_difference(&found[i * 6 * nv..(i + 1) * 6 * nv], expected);
                let law = format!("Jacobian {reference_frame:?} of state {i}");
                robot.require(&law, defect, 1e-12 * size(expected).max(1.0));
            }
        }
    }
}

fn small_model() -> Model {
    Model::new(random_robot(1, &RandomRobotOptions::default())).unwrap()
}

/// The messages are in the snapshots of `crates/tests`.
#[test]
fn wrong_lengths_panic() {
    let model = small_model();
    let (nq, nv) = (model.nq(), model.nv());
    let message = |call: &dyn Fn(&mut BatchWorkspace<f64>)| {
        let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            call(&mut workspace(&model, 1, false));
        }));
        *panic.unwrap_err().downcast::<String>().unwrap()
    };
    let assert_numbers = |message: &str, numbers: [usize; 2]| {
        let mut words = message.split_whitespace().map(|word| word.trim_matches(['(', ')']));
        for number in numbers {
            assert!(words.any(|word| word == number.to_string()), "{message}");
        }
    };
    let (q, v) = (vec![0.0; 3 * nq], vec![0.0; 3 * nv]);
    let found = message(&|w| drop(batch::gravity(&model, w, &q[1..], &mut v.clone())));
    assert_numbers(&found, [3 * nq - 1, nq]);
    let found = message(&|w| drop(batch::bias(&model, w, &q, &v[1..], &mut v.clone())));
    assert_numbers(&found, [3 * nv - 1, 3 * nv]);
    let found = message(&|w| drop(batch::gravity(&model, w, &q, &mut [0.0])));
    assert_numbers(&found, [1, 3 * nv]);
    let other = Model::new(random_robot(2, &RandomRobotOptions { joints: 3, ..Default::default() })).unwrap();
    let found = message(&|w| drop(batch::gravity(&other, w, &vec![0.0; other.nq()], &mut [])));
    for name in [model.name(), other.name()] {
        assert!(found.contains(&format!("`{name}`")), "{found}");
    }
}

//! Derivatives of batches against the single-state functions; the same bits for any threads and any split.
//!
//! Tolerances, relative to the state's largest number: 1e-12 for what is summed, κ(M) times 1e2 ε for what is solved
//! for with M.

use crate::common::{Robot, families, size};
use dynamics::SplitMix64;
use multibody::batch::{self, BadStates, BatchFloat, BatchOptions, BatchWorkspace};
use multibody::{Base, InstructionSet, Model, RandomRobotOptions, Workspace, random_robot, random_state};

/// Which derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Inverse,
    Forward,
}

const BOTH: [Of; 2] = [Of::Inverse, Of::Forward];

/// States of one robot, one after the other.
struct States<T> {
    count: usize,
    q: Vec<T>,
    v: Vec<T>,
    /// a for inverse dynamics, τ for forward dynamics.
    third: Vec<T>,
}

impl States<f64> {
    fn random(model: &Model, count: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let [mut q, mut v, mut third] = [(); 3].map(|()| Vec::new());
        for _ in 0..count {
            let state = random_state(model, &mut random);
            q.extend(state.q);
            v.extend(state.v);
            third.extend(state.a);
        }
        Self { count, q, v, third }
    }

    #[allow(clippy::cast_possible_truncation)]
    fn single(&self) -> States<f32> {
        let round = |x: &[f64]| x.iter().map(|&x| x as f32).collect();
        States { count: self.count, q: round(&self.q), v: round(&self.v), third: round(&self.third) }
    }
}

impl States<f32> {
    fn wide(&self) -> States<f64> {
        let wide = |x: &[f32]| x.iter().map(|&x| f64::from(x)).collect();
        States { count: self.count, q: wide(&self.q), v: wide(&self.v), third: wide(&self.third) }
    }
}

impl<T: Copy> States<T> {
    /// The last `count` states.
    fn last(&self, model: &Model, count: usize) -> Self {
        let (nq, nv, first) = (model.nq(), model.nv(), self.count - count);
        Self {
            count,
            q: self.q[first * nq..].to_vec(),
            v: self.v[first * nv..].to_vec(),
            third: self.third[first * nv..].to_vec(),
        }
    }
}

fn robots() -> Vec<Robot> {
    families().iter().flat_map(|family| family.robots().take(3).collect::<Vec<_>>()).collect()
}

fn workspace<T: BatchFloat>(model: &Model, threads: usize, no_avx512: bool) -> BatchWorkspace<T> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    options.limit = no_avx512.then_some(InstructionSet::Avx2);
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The results of a batch: two or three tables.
fn compute<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    states: &States<T>,
    of: Of,
) -> (Vec<Vec<T>>, Result<(), BadStates>) {
    let width = model.nv() * model.nv();
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![T::from_f64(-7.0); states.count * width]);
    let (q, v, third) = (&states.q[..], &states.v[..], &states.third[..]);
    match of {
        Of::Inverse => {
            let result = batch::inverse_dynamics_derivatives(model, workspace, q, v, third, &mut x, &mut y);
            (vec![x, y], result)
        }
        Of::Forward => {
            let result =
                batch::forward_dynamics_derivatives(model, workspace, q, v, third, &mut x, &mut y, &mut z);
            (vec![x, y, z], result)
        }
    }
}

/// The same of one state by the single-state function.
fn compute_singly(model: &Model, states: &States<f64>, i: usize, of: Of) -> Vec<Vec<f64>> {
    let (nq, nv) = (model.nq(), model.nv());
    let w = &mut Workspace::new(model);
    let row = |x: &[f64], n: usize| x[i * n..(i + 1) * n].to_vec();
    let (q, v, third) = (row(&states.q, nq), row(&states.v, nv), row(&states.third, nv));
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; nv * nv]);
    match of {
        Of::Inverse => {
            multibody::inverse_dynamics_derivatives(model, w, &q, &v, &third, &mut x, &mut y);
            vec![x, y]
        }
        Of::Forward => {
            multibody::forward_dynamics_derivatives(model, w, &q, &v, &third, &mut x, &mut y, &mut z);
            vec![x, y, z]
        }
    }
}

/// κ(M) in state i.
fn condition_at(robot: &Robot, q: &[f64], i: usize) -> f64 {
    let options = families().into_iter().find(|family| family.name == robot.family).unwrap().options;
    let mut own = Robot::new(robot.family, robot.seed, &options);
    own.state.q = q[i * robot.model.nq()..(i + 1) * robot.model.nq()].to_vec();
    own.condition()
}

#[test]
fn a_batch_is_its_states() {
    for robot in robots() {
        let (model, width) = (&robot.model, robot.model.nv() * robot.model.nv());
        let states = States::random(model, 9, robot.seed);
        for no_avx512 in [false, true] {
            let mut workspace = workspace(model, 1, no_avx512);
            for of in BOTH {
                let (found, result) = compute(model, &mut workspace, &states, of);
                assert_eq!(result, Ok(()), "{of:?} of \"{}\", seed {}", robot.family, robot.seed);
                for i in 0..states.count {
                    let relative = match of {
                        Of::Inverse => 1e-12,
                        Of::Forward => (1e2 * f64::EPSILON * condition_at(&robot, &states.q, i)).max(1e-12),
                    };
                    let expected = compute_singly(model, &states, i, of);
                    // ∂a/∂v is small where the velocity is: the largest number of all is the measure.
                    let scale = expected.iter().map(|x| size(x)).fold(1.0, f64::max);
                    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        let defect =
                            crate::common::max_difference(&found[i * width..(i + 1) * width], expected);
                        robot.require(&format!("{of:?}, result {k} of state {i}"), defect, relative * scale);
                    }
                }
            }
        }
    }
}

fn bits<T: BatchFloat>(x: &[T]) -> Vec<String> {
    x.iter().map(|x| format!("{x:?}")).collect()
}

/// Any number of states and threads, and the narrow lanes: the same bits as in one batch.
#[test]
fn results_are_the_same_bits_for_any_split() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 4, ..Default::default() };
    for (seed, mimic) in [(5, 0.0), (6, 0.5)] {
        let model = Model::new(random_robot(seed, &RandomRobotOptions { mimic, ..options.clone() })).unwrap();
        let all = States::random(&model, 300, seed);
        for of in BOTH {
            let whole = compute(&model, &mut workspace(&model, 1, false), &all, of).0;
            for (threads, no_avx512) in [(1, false), (1, true), (2, false), (3, true)] {
                let mut workspace = workspace(&model, threads, no_avx512);
                for count in [0, 1, 7, 8, 9, 65, 300] {
                    // Taken from the end, so that a state stands in another lane than in the whole.
                    let (found, result) = compute(&model, &mut workspace, &all.last(&model, count), of);
                    assert_eq!(result, Ok(()));
                    for (found, whole) in found.iter().zip(&whole) {
                        assert!(
                            bits(found) == bits(&whole[whole.len() - found.len()..]),
                            "{of:?}, {count} states, {threads} threads, seed {seed}"
                        );
                    }
                }
            }
        }
    }
}

/// Singles differ from doubles by some hundred roundings of 6e-8: 1e-4 of the state's largest number; times κ(M)
/// where M is inverted, so that only well-conditioned robots can be told from wrong ones.
#[test]
fn singles_are_near_the_doubles() {
    let mut judged = 0;
    for robot in robots().iter().filter(|robot| robot.condition() < 1e3) {
        let (model, width) = (&robot.model, robot.model.nv() * robot.model.nv());
        let single = States::random(model, 17, robot.seed).single();
        let states = single.wide();
        for no_avx512 in [false, true] {
            let mut workspace = workspace::<f32>(model, 1, no_avx512);
            for of in BOTH {
                let (found, result) = compute(model, &mut workspace, &single, of);
                assert_eq!(result, Ok(()), "{of:?} of \"{}\", seed {}", robot.family, robot.seed);
                for i in 0..states.count {
                    let allowed = 1e-4
                        * match of {
                            Of::Inverse => 1.0,
                            Of::Forward => condition_at(robot, &states.q, i),
                        };
                    if allowed > 0.1 {
                        continue;
                    }
                    judged += 1;
                    let expected = compute_singly(model, &states, i, of);
                    let scale = expected.iter().map(|x| size(x)).fold(1.0, f64::max);
                    for (found, expected) in found.iter().zip(&expected) {
                        let found: Vec<f64> =
                            found[i * width..(i + 1) * width].iter().map(|&x| f64::from(x)).collect();
                        let defect = crate::common::max_difference(&found, expected);
                        robot.require(&format!("{of:?} of state {i}"), defect, allowed * scale);
                    }
                }
            }
        }
    }
    assert!(judged > 200, "only {judged} results were judged");
}

/// A NaN here, an infinity there, a zero quaternion: every other state keeps its bits.
#[test]
fn bad_states_spoil_no_neighbour_and_are_named() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 4, ..Default::default() };
    for mimic in [0.0, 0.5] {
        let model = Model::new(random_robot(9, &RandomRobotOptions { mimic, ..options.clone() })).unwrap();
        let (nq, nv) = (model.nq(), model.nv());
        let good = States::random(&model, 50, 1);
        let mut spoilt = States::random(&model, 50, 1);
        spoilt.q[3 * nq + nq - 1] = f64::NAN;
        spoilt.q[11 * nq] = f64::INFINITY;
        spoilt.q[12 * nq + 3..12 * nq + 7].fill(0.0);
        spoilt.v[20 * nv + 2] = f64::NAN;
        spoilt.third[21 * nv + 1] = f64::NEG_INFINITY;
        spoilt.q[49 * nq] = f64::NEG_INFINITY;
        let bad = [3, 11, 12, 20, 21, 49];
        for (threads, no_avx512) in [(1, false), (1, true), (3, false)] {
            let mut workspace = workspace(&model, threads, no_avx512);
            for of in BOTH {
                let expected = compute(&model, &mut workspace, &good, of).0;
                let (found, result) = compute(&model, &mut workspace, &spoilt, of);
                let error = result.unwrap_err();
                assert_eq!((&error.states[..], error.batch), (&bad[..], 50), "{of:?}");
                for (found, expected) in found.iter().zip(&expected) {
                    for i in 0..50 {
                        let at = i * nv * nv..(i + 1) * nv * nv;
                        let (found, expected) = (&found[at.clone()], &expected[at]);
                        if bad.contains(&i) {
                            assert!(found.iter().all(|x| x.is_nan()), "{of:?} of state {i}: {found:?}");
                        } else {
                            assert_eq!(bits(found), bits(expected), "{of:?} of state {i}");
                        }
                    }
                }
            }
        }
    }
}

/// A bad state leaves nothing behind that a later call could see.
#[test]
fn a_bad_batch_leaves_no_trace() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 4, ..Default::default() };
    let model = Model::new(random_robot(10, &options)).unwrap();
    let good = States::random(&model, 16, 2);
    for of in BOTH {
        let mut workspace = workspace(&model, 1, false);
        let expected = compute(&model, &mut workspace, &good, of).0;
        let mut spoilt = States::random(&model, 16, 2);
        spoilt.q.fill(f64::NAN);
        assert_eq!(compute(&model, &mut workspace, &spoilt, of).1.unwrap_err().states.len(), 16);
        let (found, result) = compute(&model, &mut workspace, &good, of);
        assert_eq!(result, Ok(()));
        assert!(found.iter().flatten().eq(expected.iter().flatten()), "{of:?}");
    }
}

#[test]
#[should_panic(expected = "the derivative by v has 3 numbers, 2 states need 8 (4 each)")]
fn a_table_of_the_wrong_length_is_refused() {
    let model = Model::new(random_robot(
        1,
        &RandomRobotOptions {
            kinds: multibody::JointKinds::Turning,
            fixed: 0.0,
            joints: 2,
            ..Default::default()
        },
    ));
    let model = model.unwrap();
    let (mut x, mut y) = ([0.0; 8], [0.0; 3]);
    let mut workspace = BatchWorkspace::new(&model);
    let numbers = [0.1; 4];
    let _ = batch::inverse_dynamics_derivatives(
        &model,
        &mut workspace,
        &numbers,
        &numbers,
        &numbers,
        &mut x,
        &mut y,
    );
}

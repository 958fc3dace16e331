//! Derivatives of batches against the functions of single states; equal bit for bit with any threads and any
//! split.
//!
//! Tolerances, relative to the largest number of the state: 1e-12 for sums, κ(M) times 1e2 ε for solutions
//! with M.

use robot_dynamics::batch;
use robot_dynamics::batch::{BadStates, BatchFloat, BatchOptions, BatchWorkspace};
use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{Robot, families, size};

/// The kind of derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Inverse,
    Forward,
}

const BOTH: [Of; 2] = [Of::Inverse, Of::Forward];

/// States of one robot, in sequence.
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
            let out = batch::InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
            let result = batch::inverse_dynamics_derivatives(model, workspace, q, v, third, out);
            (vec![x, y], result)
        }
        Of::Forward => {
            let out = batch::ForwardDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
            };
            let result = batch::forward_dynamics_derivatives(model, workspace, q, v, third, out);
            (vec![x, y, z], result)
        }
    }
}

/// The same for one state by the function of a single state.
fn compute_singly(model: &Model, states: &States<f64>, i: usize, of: Of) -> Vec<Vec<f64>> {
    let (nq, nv) = (model.nq(), model.nv());
    let w = &mut Workspace::new(model);
    let row = |x: &[f64], n: usize| x[i * n..(i + 1) * n].to_vec();
    let (q, v, third) = (row(&states.q, nq), row(&states.v, nv), row(&states.third, nv));
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; nv * nv]);
    match of {
        Of::Inverse => {
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, &q, &v, &third, out);
            vec![x, y]
        }
        Of::Forward => {
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, &q, &v, &third, out);
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
fn batches_match_single_states() {
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
                    // ∂a/∂v is small where the velocity is small: the scale is the largest of all numbers.
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

/// With any number of states and threads, and with narrow lanes, the results equal those of one batch bit for
/// bit.
#[test]
fn results_are_equal_bit_for_bit_for_any_split() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 4, ..Default::default() };
    for (seed, mimic) in [(5, 0.0), (6, 0.5)] {
        let model = Model::new(random_robot(seed, &RandomRobotOptions { mimic, ..options.clone() })).unwrap();
        let all = States::random(&model, 300, seed);
        for of in BOTH {
            let whole = compute(&model, &mut workspace(&model, 1, false), &all, of).0;
            for (threads, no_avx512) in [(1, false), (1, true), (2, false), (3, true)] {
                let mut workspace = workspace(&model, threads, no_avx512);
                for count in [0, 1, 7, 8, 9, 65, 300] {
                    // The last states, so that each state is in another lane than in the whole batch.
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

/// f32 differs from f64 by some hundred roundings of 6e-8: 1e-4 of the largest number of the state, times
/// κ(M) where M is inverted. Only well-conditioned robots can be compared.
#[test]
fn f32_is_close_to_f64() {
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

/// With a NaN, an infinity or a zero quaternion in one state, every other state is equal bit for bit.
#[test]
fn bad_states_are_named_and_others_unchanged() {
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

/// A bad state does not affect a later call.
#[test]
fn bad_batch_does_not_affect_later_calls() {
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
fn table_of_wrong_length_panics() {
    let model = Model::new(random_robot(
        1,
        &RandomRobotOptions {
            kinds: robot_dynamics::description::JointKinds::Turning,
            fixed: 0.0,
            joints: 2,
            ..Default::default()
        },
    ));
    let model = model.unwrap();
    let (mut x, mut y) = ([0.0; 8], [0.0; 3]);
    let mut workspace = BatchWorkspace::new(&model);
    let numbers = [0.1; 4];
    let call = std::panic::AssertUnwindSafe(|| {
        let (q, v, a) = (&numbers, &numbers, &numbers);
        let out = batch::InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
        batch::inverse_dynamics_derivatives(&model, &mut workspace, q, v, a, out)
    });
    assert!(std::panic::catch_unwind(call).is_err());
}

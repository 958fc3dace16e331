//! Batches against the single-state functions; the same bits for any threads and any split.

mod common;

use common::{Robot, families, size};
use dynamics::SplitMix64;
use multibody::batch::{self, BadStates, BatchFloat, BatchOptions, BatchWorkspace};
use multibody::{Model, RandomRobotOptions, Workspace, random_robot, random_state};

/// Random states of one robot, one after the other.
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
    options.no_avx512 = no_avx512;
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The names of the batch functions, for [`compute`] and [`compute_singly`].
const ALL: [&str; 6] =
    ["inverse dynamics", "bias", "gravity", "forward dynamics", "mass matrix", "inverse mass matrix"];

/// A batch function's result on all states.
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

/// The same by the single-state function.
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
            "inverse dynamics" => multibody::inverse_dynamics(model, w, q, v, a, out),
            "bias" => multibody::bias(model, w, q, v, out),
            "gravity" => multibody::gravity(model, w, q, out),
            "forward dynamics" => multibody::forward_dynamics(model, w, q, v, tau, out),
            "mass matrix" => multibody::mass_matrix(model, w, q, out),
            "inverse mass matrix" => multibody::inverse_mass_matrix(model, w, q, out),
            _ => unreachable!(),
        }
    }
    out
}

/// 1e-12 of the state's largest number, times κ(M) ε where M is inverted.
#[test]
fn a_batch_is_its_states() {
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
                    let defect = common::max_difference(found, expected);
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

/// Any number of states and threads, and the narrow lanes: the same bits as in one batch of a thousand.
#[test]
fn results_are_the_same_bits_for_any_split() {
    let options = RandomRobotOptions { base: multibody::Base::Floating, joints: 6, ..Default::default() };
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
                        // Taken from the end, so that a state stands in another lane than in the whole.
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

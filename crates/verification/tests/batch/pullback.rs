//! Pullbacks of batches against the functions of single states; equal bit for bit with any threads and any
//! split.
//!
//! Tolerances, relative to the largest number of the state: 1e-12 for sums, κ(M) times 1e2 ε for solutions
//! with M.

use std::ops::ControlFlow;

use robot_dynamics::batch;
use robot_dynamics::batch::{
    BatchFloat, BatchOptions, BatchWorkspace, PolicyInput, Rollout, RolloutError, Torques,
};
use robot_dynamics::derivatives::{RolloutPullbackWorkspace, parameter_count};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Integrator;

use crate::common::{Robot, families, max_difference, size};

/// Inverse or forward dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Inverse,
    Forward,
}

/// The newest instruction set, the previous one with equal results, and the portable one.
const LIMITS: [Option<InstructionSet>; 3] =
    [None, Some(InstructionSet::Avx2), Some(InstructionSet::Portable)];

const BOTH: [Of; 2] = [Of::Inverse, Of::Forward];

/// q, v, a or τ, and a cotangent of each state.
struct States<T> {
    count: usize,
    rows: [Vec<T>; 4],
}

impl States<f64> {
    fn random(model: &Model, count: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut rows = [(); 4].map(|()| Vec::new());
        for _ in 0..count {
            let state = random_state(model, &mut random);
            for (rows, own) in rows.iter_mut().zip([state.q, state.v, state.a, state.tau]) {
                rows.extend(own);
            }
        }
        Self { count, rows }
    }

    #[allow(clippy::cast_possible_truncation)]
    fn single(&self) -> States<f32> {
        let rows = self.rows.each_ref().map(|x| x.iter().map(|&x| x as f32).collect());
        States { count: self.count, rows }
    }

    fn state(&self, model: &Model, i: usize) -> [&[f64]; 4] {
        let widths = [model.nq(), model.nv(), model.nv(), model.nv()];
        [0, 1, 2, 3].map(|k| &self.rows[k][i * widths[k]..(i + 1) * widths[k]])
    }
}

fn robots() -> Vec<Robot> {
    families().iter().flat_map(|family| family.robots().take(3).collect::<Vec<_>>()).collect()
}

fn workspace<T: BatchFloat>(
    model: &Model,
    threads: usize,
    limit: Option<InstructionSet>,
) -> BatchWorkspace<T> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    options.limit = limit;
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The cotangents of q, v, the third and the parameters, and a.
fn compute<T: BatchFloat>(
    model: &Model,
    w: &mut BatchWorkspace<T>,
    states: &States<T>,
    of: Of,
) -> (Vec<Vec<T>>, Result<(), batch::BadStates>) {
    let [q, v, third, lambda] = &states.rows;
    let vector = || vec![T::from_f64(-7.0); states.count * model.nv()];
    let [mut a, mut x, mut y, mut z] = [(); 4].map(|()| vector());
    let mut parameters = vec![T::from_f64(-7.0); states.count * parameter_count(model)];
    let p = &mut parameters;
    let result = match of {
        Of::Inverse => {
            a.fill(T::zero());
            let out = batch::InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: p,
            };
            batch::inverse_dynamics_pullback(model, w, q, v, third, lambda, out)
        }
        Of::Forward => batch::forward_dynamics_pullback(
            model,
            w,
            q,
            v,
            third,
            lambda,
            batch::ForwardPullbackMut {
                acceleration: &mut a,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: p,
            },
        ),
    };
    (vec![x, y, z, parameters, a], result)
}

fn compute_singly(model: &Model, [q, v, third, lambda]: [&[f64]; 4], of: Of) -> Vec<Vec<f64>> {
    let w = &mut Workspace::new(model);
    let [mut a, mut x, mut y, mut z] = [(); 4].map(|()| vec![0.0; model.nv()]);
    let mut p = vec![0.0; parameter_count(model)];
    match of {
        Of::Inverse => robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
            model,
            w,
            robot_dynamics::derivatives::InversePullbackInputs {
                q,
                v,
                a: third,
                wrenches: &[],
                cotangent: lambda,
            },
            robot_dynamics::derivatives::InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut p,
            },
        ),
        Of::Forward => robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters(
            model,
            w,
            robot_dynamics::derivatives::ForwardPullbackInputs {
                q,
                v,
                tau: third,
                wrenches: &[],
                cotangent: lambda,
            },
            robot_dynamics::derivatives::ForwardPullbackMut {
                acceleration: &mut a,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut p,
            },
        ),
    }
    vec![x, y, z, p, a]
}

/// κ(M) at q.
fn condition_at(robot: &Robot, q: &[f64]) -> f64 {
    let options = families().into_iter().find(|family| family.name == robot.family).unwrap().options;
    let mut own = Robot::new(robot.family, robot.seed, &options);
    own.state.q = q.to_vec();
    own.condition()
}

#[test]
fn batches_match_single_states() {
    for robot in robots() {
        let model = &robot.model;
        let states = States::random(model, 9, robot.seed);
        for limit in LIMITS {
            let mut w = workspace(model, 1, limit);
            for of in BOTH {
                let (found, result) = compute(model, &mut w, &states, of);
                assert_eq!(result, Ok(()), "{of:?} of \"{}\", seed {}", robot.family, robot.seed);
                for i in 0..states.count {
                    let state = states.state(model, i);
                    let relative = match of {
                        Of::Inverse => 1e-12,
                        Of::Forward => (1e2 * f64::EPSILON * condition_at(&robot, state[0])).max(1e-12),
                    };
                    let expected = compute_singly(model, state, of);
                    let scale = expected.iter().map(|x| size(x)).fold(1.0, f64::max);
                    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        let own = &found[i * expected.len()..(i + 1) * expected.len()];
                        let law = format!("{of:?}, table {k} of state {i}");
                        robot.require(&law, max_difference(own, expected), relative * scale);
                    }
                }
            }
        }
    }
}

/// f32 with its own rounding, on well-conditioned robots.
#[test]
fn f32_is_close_to_f64() {
    let mut tested = 0;
    for robot in robots().into_iter().filter(|robot| robot.condition() < 1e3) {
        let model = &robot.model;
        let single = States::random(model, 17, robot.seed).single();
        let wide = States {
            count: 17,
            rows: single.rows.each_ref().map(|x| x.iter().map(|&x| f64::from(x)).collect()),
        };
        let conditions: Vec<f64> = (0..17).map(|i| condition_at(&robot, wide.state(model, i)[0])).collect();
        for of in BOTH {
            let (found, result) = compute(model, &mut workspace::<f32>(model, 1, None), &single, of);
            assert_eq!(result, Ok(()));
            for i in (0..17).filter(|&i| conditions[i] < 1e4) {
                let expected = compute_singly(model, wide.state(model, i), of);
                let scale = expected.iter().map(|x| size(x)).fold(1.0, f64::max);
                for (found, expected) in found.iter().zip(&expected) {
                    let own: Vec<f64> = found[i * expected.len()..(i + 1) * expected.len()]
                        .iter()
                        .map(|&x| f64::from(x))
                        .collect();
                    let allowed = 1e2 * f64::from(f32::EPSILON) * conditions[i].max(10.0) * scale;
                    robot.require(&format!("{of:?} of state {i}"), max_difference(&own, expected), allowed);
                    tested += 1;
                }
            }
        }
    }
    assert!(tested > 200);
}

/// Threads, instruction sets and the split of the batch change no bit.
#[test]
fn batches_are_equal_bit_for_bit_for_any_split() {
    for family in ["floating trees", "mimic joints"] {
        let families = families();
        let robot = families.iter().find(|f| f.name == family).unwrap().robots().next().unwrap();
        let model = &robot.model;
        let states = States::random(model, 203, 3);
        for of in BOTH {
            let (expected, _) = compute(model, &mut workspace(model, 1, None), &states, of);
            for (threads, limit) in [(1, LIMITS[1]), (2, None), (3, LIMITS[1])] {
                let (found, _) = compute(model, &mut workspace(model, threads, limit), &states, of);
                assert!(found == expected, "{of:?} by {threads} threads");
            }
            let widths = [model.nq(), model.nv(), model.nv(), model.nv()];
            let rows = [0, 1, 2, 3].map(|k| states.rows[k][5 * widths[k]..].to_vec());
            let (found, _) = compute(model, &mut workspace(model, 1, None), &States { count: 198, rows }, of);
            for (found, expected) in found.iter().zip(&expected) {
                assert!(found[..] == expected[expected.len() - found.len()..], "{of:?} from the fifth state");
            }
        }
    }
}

#[test]
fn bad_state_is_named_and_others_unchanged() {
    let families = families();
    let robot = families[2].robots().next().unwrap();
    let model = &robot.model;
    let good = States::random(model, 20, 3);
    for of in BOTH {
        let (expected, _) = compute(model, &mut workspace(model, 2, None), &good, of);
        for table in 0..4 {
            let mut states = States { count: 20, rows: good.rows.clone() };
            let width = states.rows[table].len() / 20;
            states.rows[table][7 * width + 1] = f64::NAN;
            let (found, result) = compute(model, &mut workspace(model, 2, None), &states, of);
            assert_eq!(result.unwrap_err().states, [7], "{of:?}, table {table}");
            for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let width = expected.len() / 20;
                for i in 0..20 {
                    let rows = i * width..(i + 1) * width;
                    if i != 7 {
                        assert_eq!(found[rows.clone()], expected[rows]);
                    } else if of == Of::Forward || k < 4 {
                        assert!(found[rows].iter().all(|x| x.is_nan()));
                    }
                }
            }
        }
    }
}

/// The results of the pullback of a rollout: q̄, v̄, τ̄ and the parameters.
fn pull(
    model: &Model,
    w: &mut BatchWorkspace<f64>,
    how: &Rollout,
    spacing: usize,
    torques: Torques<'_, f64>,
    states: &States<f64>,
    path: (&[f64], &[f64]),
) -> (Vec<Vec<f64>>, Result<(), RolloutError>) {
    let [q, v, by_q, by_v] = &states.rows;
    let (mut by_q, mut by_v) = (by_q.clone(), by_v.clone());
    let width = match torques {
        Torques::EachStep(_) => how.steps,
        Torques::Held(_) => 1,
        _ => 0,
    };
    let mut by_tau = vec![-7.0; states.count * width * model.nv()];
    let mut parameters = vec![-7.0; states.count * parameter_count(model)];
    let ends = (&mut by_q[..], &mut by_v[..]);
    let inputs = batch::RolloutPullbackInputs {
        spacing,
        torques,
        q,
        v,
        trajectory: batch::TrajectoryCotangents { by_position: path.0, by_velocity: path.1 },
    };
    let cotangents = batch::MotionCotangents {
        by_position: ends.0,
        by_velocity: ends.1,
        by_force: &mut by_tau,
        parameters: &mut parameters,
    };
    let result = batch::rollout_pullback(model, w, how, &inputs, cotangents, None);
    (vec![by_q, by_v, by_tau, parameters], result)
}

#[test]
fn rollouts_of_batch_match_single_rollouts() {
    let (steps, stride, count) = (23, 5, 9);
    for family in ["floating trees", "trees of all joints", "mimic joints"] {
        let families = families();
        let family = families.iter().find(|f| f.name == family).unwrap();
        let robot = family.robots().find(|robot| robot.condition() < 1e3).unwrap();
        let (model, nv) = (&robot.model, robot.model.nv());
        let states = States::random(model, count, robot.seed);
        let random = &mut SplitMix64::new(9);
        let mut table = |n: usize| -> Vec<f64> { (0..n).map(|_| random.uniform(-1.0, 1.0)).collect() };
        let (each, samples) = (table(count * steps * nv), steps / stride);
        let (q_path, v_path) = (table(count * samples * nv), table(count * samples * nv));
        for integrator in Integrator::ALL.into_iter().filter(|row| row.is_explicit()) {
            let how = Rollout::new(integrator, 1e-3, steps).with_stride(stride);
            let torques = Torques::EachStep(&each);
            let path = (&q_path[..], &v_path[..]);
            let (found, result) =
                pull(model, &mut workspace(model, 1, None), &how, 0, torques, &states, path);
            assert_eq!(result, Ok(()));
            for (threads, limit, spacing) in [(2, LIMITS[1], 1), (3, None, 7)] {
                let w = &mut workspace(model, threads, limit);
                let (again, _) = pull(model, w, &how, spacing, torques, &states, path);
                assert!(again == found, "{integrator}, {threads} threads, a checkpoint each {spacing}");
            }
            for i in 0..count {
                let [q, v, by_q, by_v] = states.state(model, i);
                let (mut by_q, mut by_v) = (by_q.to_vec(), by_v.to_vec());
                let (mut by_tau, mut parameters) = (vec![0.0; steps * nv], vec![0.0; parameter_count(model)]);
                let rows = |x: &[f64], width: usize| x[i * width..(i + 1) * width].to_vec();
                let w = &mut RolloutPullbackWorkspace::new(model, &how, 0);
                let path = (rows(&q_path, samples * nv), rows(&v_path, samples * nv));
                let cotangents = robot_dynamics::derivatives::MotionCotangents {
                    by_position: &mut by_q,
                    by_velocity: &mut by_v,
                    by_force: &mut by_tau,
                    parameters: &mut parameters,
                };
                robot_dynamics::derivatives::rollout_pullback(
                    model,
                    &how,
                    w,
                    robot_dynamics::derivatives::RobotState { q, v },
                    &rows(&each, steps * nv),
                    robot_dynamics::derivatives::TrajectoryCotangents {
                        by_position: &path.0,
                        by_velocity: &path.1,
                    },
                    cotangents,
                )
                .unwrap();
                let expected = [by_q, by_v, by_tau, parameters];
                let scale = expected.iter().map(|x| size(x)).fold(1.0, f64::max);
                let condition = condition_at(&robot, q);
                for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let own = rows(found, expected.len());
                    let law = format!("{integrator}, table {k} of state {i}");
                    robot.require(&law, max_difference(&own, expected), 1e-12 * condition * scale);
                }
            }
        }
        // Held forces are equal forces at each step: their cotangents are sums over the steps.
        let integrator = Integrator::RungeKutta4;
        let how = Rollout::new(integrator, 1e-3, steps);
        let held: Vec<f64> = each[..count * nv].to_vec();
        let repeated: Vec<f64> = held.chunks(nv).flat_map(|tau| tau.repeat(steps)).collect();
        let w = &mut workspace(model, 1, None);
        let (one, _) = pull(model, w, &how, 0, Torques::Held(&held), &states, (&[], &[]));
        let (each, _) = pull(model, w, &how, 0, Torques::EachStep(&repeated), &states, (&[], &[]));
        assert!(one[..2] == each[..2] && one[3] == each[3]);
        for i in 0..count {
            for k in 0..nv {
                let sum: f64 = (0..steps).map(|step| each[2][(i * steps + step) * nv + k]).sum();
                let own = one[2][i * nv + k];
                assert!((own - sum).abs() < 1e-12 * (1.0 + size(&each[2])), "{own} {sum}");
            }
        }
    }
}

#[test]
fn invalid_rollout_pullbacks_are_errors() {
    let families = families();
    let robot = families[2].robots().next().unwrap();
    let (model, nv) = (&robot.model, robot.model.nv());
    let states = States::random(model, 20, 3);
    let how = |integrator| Rollout::new(integrator, 1e-4, 4).with_dissipation(false);
    let w = &mut workspace(model, 1, None);
    let mut call = |how: &Rollout, torques: Torques<'_, f64>, states: &States<f64>| {
        pull(model, w, how, 0, torques, states, (&[], &[]))
    };
    let integrator = Integrator::VariationalYoshida4;
    let (untouched, refused) = call(&how(integrator), Torques::Zero, &states);
    assert_eq!(refused, Err(RolloutError::Implicit { integrator }));
    assert_eq!(untouched[..2], states.rows[2..]);
    let rk4 = how(Integrator::RungeKutta4);
    let policy = |_: PolicyInput<'_, f64>, _: &mut [f64]| {};
    let (_, refused) = call(&rk4, Torques::Policy(&policy), &states);
    assert_eq!(refused, Err(RolloutError::Policy));
    let (_, refused) = call(&Rollout::new(Integrator::RungeKutta4, f64::NAN, 4), Torques::Zero, &states);
    assert!(matches!(refused, Err(RolloutError::Input(_))));
    // A bad state in each table, and in the torques of a step.
    let (expected, _) = call(&rk4, Torques::Zero, &states);
    for table in 0..4 {
        let mut wrong = States { count: 20, rows: states.rows.clone() };
        let width = wrong.rows[table].len() / 20;
        wrong.rows[table][7 * width + 2] = f64::NAN;
        let (found, refused) = call(&rk4, Torques::Zero, &wrong);
        let Err(RolloutError::BadStates(bad)) = refused else { panic!("{refused:?}") };
        assert_eq!(bad.states, [7]);
        for (found, expected) in found.iter().zip(&expected).filter(|(found, _)| !found.is_empty()) {
            let width = found.len() / 20;
            assert!(found[7 * width..8 * width].iter().all(|x| x.is_nan()));
            assert_eq!(found[..7 * width], expected[..7 * width]);
            assert_eq!(found[8 * width..], expected[8 * width..]);
        }
    }
    let mut each = vec![0.0; 20 * 4 * nv];
    each[(7 * 4 + 2) * nv] = f64::INFINITY;
    let (found, refused) = call(&rk4, Torques::EachStep(&each), &states);
    let Err(RolloutError::BadStates(bad)) = refused else { panic!("{refused:?}") };
    assert_eq!(bad.states, [7]);
    assert!(found[2][7 * 4 * nv..8 * 4 * nv].iter().all(|x| x.is_nan()));
    // Cancelled at the first callback: no state has moved.
    let [q, v, by_q, by_v] = &states.rows;
    let (mut x, mut y) = (by_q.clone(), by_v.clone());
    let stop = |_| ControlFlow::Break(());
    let inputs = batch::RolloutPullbackInputs {
        spacing: 0,
        torques: Torques::Zero,
        q,
        v,
        trajectory: batch::TrajectoryCotangents::default(),
    };
    let cotangents = batch::MotionCotangents {
        by_position: &mut x,
        by_velocity: &mut y,
        by_force: &mut [],
        parameters: &mut [],
    };
    let refused = batch::rollout_pullback(model, w, &rk4, &inputs, cotangents, Some(&stop));
    let Err(RolloutError::Cancelled { unfinished, batch: 20 }) = refused else { panic!("{refused:?}") };
    assert_eq!(unfinished.len(), 20);
    assert!(x == *by_q && y == *by_v);
}

//! Objects used by several threads at once give right results, or the documented errors.
//!
//! Unsafe code: the interface takes pointers. Each call passes slices of this program.
#![allow(unsafe_code)]

#[macro_use]
mod common;

use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{scope, yield_now};

use common::{Robot, ok, same_bits};
use robot_dynamics_c::Status;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::load::{rd_load, rd_model_free};
use robot_dynamics_c::model::{ModelHandle, rd_model_nq, rd_model_nv};
use robot_dynamics_c::quantities::functions::*;
use robot_dynamics_c::simulation::*;
use robot_dynamics_c::workspace::*;

const THREADS: usize = 8;

/// Inverse dynamics at a state from a seed: the inputs and the result of one thread.
fn samples(robot: &Robot) -> Vec<([Vec<f64>; 3], Vec<f64>)> {
    let sample = |seed| {
        let (s, mut tau) = (robot.state(seed), vec![0.0; robot.model.nv()]);
        ok(rd!(rd_inverse_dynamics(robot.workspace, in s.q, in s.v, in s.a, mut tau)));
        ([s.q, s.v, s.a], tau)
    };
    (0..THREADS as u64).map(sample).collect()
}

#[test]
fn eight_threads_share_one_model() {
    let robot = Robot::load("robots/quadruped.urdf", true);
    let (samples, start) = (samples(&robot), Barrier::new(THREADS));
    let (handle, n) = (robot.handle, robot.model.nv());
    scope(|threads| {
        for _ in 0..THREADS {
            threads.spawn(|| {
                start.wait();
                for _ in 0..20 {
                    let mut w = WorkspaceHandle { id: 0 };
                    ok(rd!(rd_workspace_new(handle, &raw mut w)));
                    assert_eq!((rd_model_nq(handle), rd_model_nv(handle)), (n + 1, n));
                    for ([q, v, a], expected) in &samples {
                        let mut tau = vec![0.0; n];
                        ok(rd!(rd_inverse_dynamics(w, in q, in v, in a, mut tau)));
                        same_bits("tau", &tau, expected);
                    }
                    ok(rd_workspace_free(w));
                }
            });
        }
    });
}

#[test]
fn shared_workspace_gives_right_results_or_is_in_use() {
    let robot = Robot::load("robots/quadruped.urdf", true);
    let (samples, start, right) = (samples(&robot), Barrier::new(THREADS), AtomicUsize::new(0));
    let w = robot.workspace;
    scope(|threads| {
        for ([q, v, a], expected) in &samples {
            let (start, right) = (&start, &right);
            threads.spawn(move || {
                start.wait();
                for _ in 0..500 {
                    let mut tau = vec![f64::NAN; v.len()];
                    match rd!(rd_inverse_dynamics(w, in q, in v, in a, mut tau)) {
                        Status::Ok => {
                            same_bits("tau", &tau, expected);
                            right.fetch_add(1, Ordering::Relaxed);
                        }
                        Status::InUse => assert!(tau.iter().all(|x| x.is_nan()), "the result is untouched"),
                        status => panic!("{status:?}: {}", common::message()),
                    }
                }
            });
        }
    });
    // The thread that holds the workspace succeeds, so each thread's last free call does too.
    assert!(right.into_inner() > 0);
}

#[test]
fn objects_freed_during_use_become_invalid_for_good() {
    let robot = Robot::load("robots/quadruped.urdf", true);
    let other = Robot::load("robots/panda.urdf", false);
    let samples = samples(&robot);
    for _ in 0..10 {
        let (mut w, start) = (WorkspaceHandle { id: 0 }, Barrier::new(THREADS));
        ok(rd!(rd_workspace_new(robot.handle, &raw mut w)));
        let freed = AtomicBool::new(false);
        scope(|threads| {
            for ([q, v, a], expected) in &samples[1..] {
                let (start, freed) = (&start, &freed);
                threads.spawn(move || {
                    start.wait();
                    loop {
                        let was_freed = freed.load(Ordering::SeqCst);
                        let mut tau = vec![0.0; v.len()];
                        match rd!(rd_inverse_dynamics(w, in q, in v, in a, mut tau)) {
                            Status::Ok => {
                                same_bits("tau", &tau, expected);
                                assert!(!was_freed, "a freed workspace is used");
                            }
                            Status::InUse => yield_now(),
                            Status::InvalidHandle if was_freed => break,
                            Status::InvalidHandle => {}
                            status => panic!("{status:?}: {}", common::message()),
                        }
                    }
                });
            }
            start.wait();
            loop {
                match rd_workspace_free(w) {
                    Status::InUse => yield_now(),
                    status => break ok(status),
                }
            }
            // Workspaces of another robot take the slot.
            let mut next = [WorkspaceHandle { id: 0 }; 4];
            for next in &mut next {
                ok(rd!(rd_workspace_new(other.handle, &raw mut *next)));
                assert_ne!(next.id, w.id);
            }
            freed.store(true, Ordering::SeqCst);
            for next in next {
                // A call of the old handle that began before it was freed may hold the slot for an instant.
                while rd_workspace_free(next) == Status::InUse {
                    yield_now();
                }
            }
        });
    }
}

#[test]
fn a_model_is_freed_while_others_make_objects_of_it() {
    let path = common::c(common::file("robots/panda.urdf").to_str().expect("UTF-8"));
    for _ in 0..10 {
        let (mut model, start) = (ModelHandle { id: 0 }, Barrier::new(4));
        ok(rd!(rd_load(path.as_ptr(), std::ptr::null(), &raw mut model)));
        scope(|threads| {
            for _ in 0..3 {
                threads.spawn(|| {
                    start.wait();
                    loop {
                        let (mut w, mut g) = (WorkspaceHandle { id: 0 }, [0.0; 7]);
                        match rd!(rd_workspace_new(model, &raw mut w)) {
                            Status::Ok => {
                                // The workspace remains valid without the model.
                                ok(rd!(rd_gravity(w, in [0.3; 7], mut g)));
                                assert!(g[1] != 0.0);
                                ok(rd_workspace_free(w));
                            }
                            Status::InUse => yield_now(),
                            status => break assert_eq!(status, Status::InvalidHandle),
                        }
                    }
                });
            }
            start.wait();
            loop {
                match rd_model_free(model) {
                    Status::InUse => yield_now(),
                    status => break ok(status),
                }
            }
        });
        assert_eq!(rd_model_nq(model), 0);
    }
}

#[test]
fn constraints_serve_threads_at_once() {
    let robot = Robot::load("robots/linkage.xml", false);
    let mut set = ConstraintsHandle { id: 0 };
    ok(rd!(rd_constraints_from_file(robot.handle, &raw mut set)));
    let rows = rd_constraints_row_count(set);
    let (n, q) = (robot.model.nv(), robot_dynamics::model::neutral(&robot.model));
    let motion = |w: WorkspaceHandle, seed: u64| {
        let (s, mut a, mut multipliers) = (robot.state(seed), vec![0.0; n], vec![0.0; rows]);
        let (v, tau) = (s.v, s.tau);
        ok(rd!(rd_constrained_forward_dynamics(w, set, in q, in v, in tau, mut a, mut multipliers)));
        [a, multipliers].concat()
    };
    let expected: Vec<Vec<f64>> = (0..THREADS as u64).map(|seed| motion(robot.workspace, seed)).collect();
    let (motion, expected) = (&motion, &expected);
    scope(|threads| {
        for _ in 0..THREADS {
            threads.spawn(move || {
                let mut w = WorkspaceHandle { id: 0 };
                ok(rd!(rd_workspace_new(robot.handle, &raw mut w)));
                for (seed, expected) in expected.iter().enumerate() {
                    same_bits("a and multipliers", &motion(w, seed as u64), expected);
                }
                ok(rd_workspace_free(w));
            });
        }
    });
    ok(rd_constraints_free(set));
}

/// The steps of several threads add up, and each read is a state between steps.
#[test]
fn shared_simulation_takes_whole_steps() {
    let robot = Robot::load("robots/three_r.urdf", false);
    let (mut simulation, taken) = (SimulationHandle { id: 0 }, AtomicUsize::new(0));
    ok(rd!(rd_simulation_new(robot.handle, std::ptr::null(), &raw mut simulation)));
    let start = Barrier::new(4);
    scope(|threads| {
        for _ in 0..4 {
            threads.spawn(|| {
                start.wait();
                for _ in 0..200 {
                    match rd_simulation_step(simulation, 1) {
                        Status::Ok => _ = taken.fetch_add(1, Ordering::Relaxed),
                        status => assert_eq!(status, Status::InUse),
                    }
                }
            });
        }
    });
    let mut own = robot_dynamics::simulation(&robot.model).build().expect("a simulation");
    (0..taken.into_inner()).for_each(|_| own.step().expect("a step"));
    let mut q = vec![0.0; robot.model.nq()];
    ok(rd!(rd_simulation_q(simulation, mut q)));
    same_bits("q", &q, own.q());
    assert_eq!(rd_simulation_time(simulation).to_bits(), own.time().to_bits());
    ok(rd_simulation_free(simulation));
}

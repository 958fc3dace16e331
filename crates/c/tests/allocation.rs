//! Functions that the header names as free of allocation request no memory.
//!
//! Unsafe code: the interface takes pointers, and counting needs a global allocator. It passes each request
//! to the system's allocator and exists in this test program only.
#![allow(unsafe_code)]
// Numbers of frames and quantities are small.
#![allow(clippy::cast_possible_truncation)]

#[macro_use]
mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ptr::null;

use common::{Robot, ok};
use robot_dynamics::description::Base;
use robot_dynamics::quantity::{Input, Quantity};
use robot_dynamics_c::batch::*;
use robot_dynamics_c::configuration::*;
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::frames::*;
use robot_dynamics_c::quantities::functions::*;
use robot_dynamics_c::quantities::*;
use robot_dynamics_c::simulation::inputs::*;
use robot_dynamics_c::simulation::*;

struct Counting;

thread_local! {
    /// Number of requests by this thread; tests run in parallel.
    static REQUESTS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // This fails only while a thread is being torn down; nothing is measured then.
    let _ = REQUESTS.try_with(|requests| requests.set(requests.get() + 1));
}

// SAFETY: every method hands its arguments to `System` unchanged and returns what it returns.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The number of requests for memory that a call makes.
fn allocations(call: impl FnOnce()) -> usize {
    let before = REQUESTS.get();
    call();
    REQUESTS.get() - before
}

/// Runs a call three times. The first one may make machine code. So may the second: the check of the rank of
/// M needs bounds from the first. The third must not allocate.
#[track_caller]
fn allocates_nothing(name: &str, mut call: impl FnMut()) {
    call();
    call();
    let requests = allocations(call);
    assert_eq!(requests, 0, "{name}");
}

fn robots() -> [Robot; 3] {
    [
        Robot::load("robots/panda.urdf", false),
        Robot::load("robots/quadruped.urdf", true),
        Robot::random(7, Base::Floating),
    ]
}

#[test]
fn allocations_are_counted() {
    assert_eq!(allocations(|| assert_eq!(1 + 1, 2)), 0);
    assert_eq!(allocations(|| drop(vec![1.0; 10])), 1);
    let robot = Robot::load("robots/panda.urdf", false);
    let mut y = [0.0; 7];
    let failed =
        allocations(|| assert_ne!(rd!(rd_gravity(robot.workspace, in y[..3], mut y[3..])) as i32, 0));
    assert!(failed > 0, "a failed call makes a text");
}

/// The table's inputs and results for some states.
fn arguments(
    quantity: Quantity,
    s: &[Vec<f64>; 4],
    frames: &[u32],
    out: &mut [Vec<f64>; 3],
) -> (InputsC, ResultsC) {
    let [q, v, a, tau] = s;
    let read = |input, x: &Vec<f64>| if quantity.reads(input) { (x.as_ptr(), x.len()) } else { (null(), 0) };
    let (v, a, tau) = (read(Input::Velocity, v), read(Input::Acceleration, a), read(Input::Force, tau));
    let mut inputs = InputsC { q: q.as_ptr(), q_len: q.len(), ..InputsC::default() };
    (inputs.v, inputs.v_len, inputs.a, inputs.a_len, inputs.tau, inputs.tau_len) =
        (v.0, v.1, a.0, a.1, tau.0, tau.1);
    if quantity.reads(Input::Frame) {
        (inputs.frames, inputs.frames_len) = (frames.as_ptr(), frames.len());
    }
    let [x, y, z] = out;
    let results = ResultsC {
        first: x.as_mut_ptr(),
        first_len: x.len(),
        second: y.as_mut_ptr(),
        second_len: y.len(),
        third: z.as_mut_ptr(),
        third_len: z.len(),
    };
    (inputs, results)
}

#[test]
fn quantities_and_batches_of_one_thread_do_not_allocate() {
    const STATES: usize = 11;
    const FRAME: [u32; 1] = [1];
    for robot in &robots() {
        let mut batch = BatchHandle { id: 0 };
        ok(rd!(rd_batch_new(robot.handle, 1, &raw mut batch)));
        for (number, quantity) in Quantity::ALL.into_iter().enumerate() {
            let (number, name) = (number as u32, format!("{} of {}", quantity.name(), robot.name));
            let (mut lengths, w) = ([0; 3], robot.workspace);
            let frames = robot.model.frames().len();
            allocates_nothing("lengths", || ok(rd!(rd_quantity_lengths(w, number, frames, mut lengths))));
            let (s, mut out) = (robot.state(1), lengths.map(|length| vec![0.0; length]));
            let one = [s.q, s.v, s.a, s.tau];
            let (inputs, results) = arguments(quantity, &one, &FRAME, &mut out);
            let (i, r) = (&raw const inputs, &raw const results);
            allocates_nothing(&name, || ok(rd!(rd_compute(w, number, i, r))));
            let states: Vec<_> = (0..STATES as u64).map(|seed| robot.state(seed)).collect();
            let q = states.iter().flat_map(|s| s.q.clone()).collect();
            let v = states.iter().flat_map(|s| s.v.clone()).collect();
            let a = states.iter().flat_map(|s| s.a.clone()).collect();
            let tau = states.iter().flat_map(|s| s.tau.clone()).collect();
            let mut out = lengths.map(|length| vec![0.0; STATES * length]);
            let all = [q, v, a, tau];
            let (inputs, results) = arguments(quantity, &all, &FRAME, &mut out);
            let (i, r) = (&raw const inputs, &raw const results);
            allocates_nothing(&name, || ok(rd!(rd_batch_compute(batch, number, STATES, i, r))));
        }
        ok(rd_batch_free(batch));
    }
}

#[test]
fn motions_of_frames_and_configurations_do_not_allocate() {
    for robot in &robots() {
        let (s, t, w, h) = (robot.state(1), robot.state(2), robot.workspace, robot.handle);
        let (nq, n) = (robot.model.nq(), robot.model.nv());
        let [mut pose, mut six] = [vec![0.0; 12], vec![0.0; 6]];
        allocates_nothing("pose", || ok(rd!(rd_frame_pose(w, 1, in s.q, mut pose))));
        let mut jacobian = vec![0.0; 6 * n];
        for axes in 0..3 {
            allocates_nothing("velocity", || ok(rd!(rd_frame_velocity(w, 1, axes, in s.q, in s.v, mut six))));
            allocates_nothing("acceleration", || {
                ok(rd!(rd_frame_acceleration(w, 1, axes, in s.q, in s.v, in s.a, mut six)));
            });
            allocates_nothing("bias acceleration", || {
                ok(rd!(rd_frame_bias_acceleration(w, 1, axes, in s.q, in s.v, mut six)));
            });
            allocates_nothing("Jacobian", || ok(rd!(rd_frame_jacobian(w, 1, axes, in s.q, mut jacobian))));
        }
        allocates_nothing("ċ", || ok(rd!(rd_center_of_mass_velocity(w, in s.q, in s.v, mut six[..3]))));
        let mut reactions = vec![0.0; 6 * robot.model.joints().len()];
        allocates_nothing("reactions", || {
            ok(rd!(rd_joint_reactions(w, in s.q, in s.v, in s.a, mut reactions)));
        });
        let mut regressor = vec![0.0; n * rd_inertial_parameter_count(w)];
        allocates_nothing("regressor", || {
            ok(rd!(rd_joint_torque_regressor(w, in s.q, in s.v, in s.a, mut regressor)));
        });
        let [mut q, mut v] = [vec![0.0; nq], vec![0.0; n]];
        allocates_nothing("integrate", || ok(rd!(rd_integrate(h, in s.q, in s.v, mut q))));
        allocates_nothing("difference", || ok(rd!(rd_difference(h, in s.q, in t.q, mut v))));
        allocates_nothing("normalize", || ok(rd!(rd_normalize(h, mut q))));
    }
}

/// A round of each control law: a new reference, a state, a torque.
#[test]
fn control_loops_do_not_allocate() {
    for robot in &robots() {
        let (n, h) = (robot.model.nv(), robot.handle);
        let (kp, mut tau) = (vec![20.0; n], vec![0.0; n]);
        let (s, t) = (robot.state(1), robot.state(2));
        let mut law = ComputedTorqueHandle { id: 0 };
        ok(rd!(rd_computed_torque_new(h, in kp, in kp, 1, &raw mut law)));
        allocates_nothing("computed torque", || {
            ok(rd!(rd_computed_torque_set_reference(law, in t.q, in t.v, in t.a)));
            ok(rd!(rd_computed_torque_torque(law, in s.q, in s.v, mut tau)));
        });
        ok(rd_computed_torque_free(law));
        let mut observer = MomentumObserverHandle { id: 0 };
        ok(rd!(rd_momentum_observer_new(h, in kp, 1, &raw mut observer)));
        let mut external = vec![0.0; n];
        allocates_nothing("observer", || {
            for s in [&s, &t] {
                ok(rd!(rd_momentum_observer_update(observer, in s.q, in s.v, in s.tau, 1e-3, mut external)));
            }
        });
        ok(rd_momentum_observer_free(observer));
        let (last, none) = (robot.model.frames().len() as u32 - 1, [0.0; 0]);
        let (mut pose, still) = ([0.0; 12], [0.1; 6]);
        ok(rd!(rd_frame_pose(robot.workspace, last, in t.q, mut pose)));
        for kind in [0, 1] {
            let mut law = TaskControlHandle { id: 0 };
            ok(rd!(rd_task_control_new(h, last, kind, 10.0, 5.0, 1.0, in none, 0.0, &raw mut law)));
            allocates_nothing("task control", || {
                ok(rd!(rd_task_control_set_target(law, in pose, in still, in still)));
                ok(rd!(rd_task_control_torque(law, in s.q, in s.v, mut tau)));
            });
            ok(rd_task_control_free(law));
        }
    }
}

/// Steps with torques, and reading the state.
fn steps(simulation: SimulationHandle, nq: usize, tau: &[f64]) {
    let n = tau.len();
    let [mut q, mut v, mut a, mut applied] = [nq, n, n, n].map(|n| vec![0.0; n]);
    let mut energy = EnergyAccountC::default();
    let (frames, axes, wrench) = ([0u32], [0u32], [0.1; 6]);
    allocates_nothing("a simulation", || {
        for _ in 0..20 {
            ok(rd!(rd_simulation_set_torques(simulation, in tau)));
            ok(rd!(rd_simulation_set_wrenches(simulation, frames.as_ptr(), axes.as_ptr(), 1, in wrench)));
            ok(rd_simulation_step(simulation, 2));
            ok(rd!(rd_simulation_q(simulation, mut q)));
            ok(rd!(rd_simulation_v(simulation, mut v)));
            ok(rd!(rd_simulation_acceleration(simulation, mut a)));
            ok(rd!(rd_simulation_applied_torques(simulation, mut applied)));
            ok(rd!(rd_simulation_energy(simulation, &raw mut energy)));
            assert!(rd_simulation_time(simulation) > 0.0);
        }
    });
}

#[test]
fn simulations_without_contact_do_not_allocate() {
    for robot in &robots() {
        for method in [c"rk4", c"implicit", c"semi-implicit-euler"] {
            let mut simulation = SimulationHandle { id: 0 };
            let options = SimulationOptionsC {
                method: method.as_ptr(),
                without: c"contacts,link-contacts".as_ptr(),
                ..SimulationOptionsC::default()
            };
            ok(rd!(rd_simulation_new(robot.handle, &raw const options, &raw mut simulation)));
            let tau: Vec<f64> = (0..robot.model.nv()).map(|k| 0.01 * k as f64).collect();
            steps(simulation, robot.model.nq(), &tau);
            ok(rd_simulation_free(simulation));
        }
    }
}

#[test]
fn controls_of_actuators_do_not_allocate() {
    let robot = Robot::load("robots/arm.xml", false);
    let mut simulation = SimulationHandle { id: 0 };
    ok(rd!(rd_simulation_new(robot.handle, null(), &raw mut simulation)));
    let controls = vec![0.1; rd_simulation_control_count(simulation)];
    assert!(!controls.is_empty());
    allocates_nothing("controls", || {
        for _ in 0..20 {
            ok(rd!(rd_simulation_set_controls(simulation, in controls)));
            ok(rd_simulation_step(simulation, 1));
        }
    });
    ok(rd_simulation_free(simulation));
}

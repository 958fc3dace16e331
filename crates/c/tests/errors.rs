//! Invalid arguments give a status and a text that names the argument.
//!
//! Unsafe code: the interface takes pointers. Invalid ones are refused before they are read.
#![allow(unsafe_code)]

#[macro_use]
mod common;

use std::ptr::{null, null_mut};

use common::{Robot, c, fails, message, ok, text};
use robot_dynamics_c::Status;
use robot_dynamics_c::batch::*;
use robot_dynamics_c::calls::*;
use robot_dynamics_c::configuration::*;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::frames::*;
use robot_dynamics_c::identification::*;
use robot_dynamics_c::inverse_kinematics::rd_inverse_kinematics;
use robot_dynamics_c::linearization::rd_linearize_step;
use robot_dynamics_c::load::*;
use robot_dynamics_c::model::*;
use robot_dynamics_c::optimal::mpc::*;
use robot_dynamics_c::optimal::*;
use robot_dynamics_c::quantities::functions::*;
use robot_dynamics_c::quantities::*;
use robot_dynamics_c::simulation::inputs::rd_simulation_reset;
use robot_dynamics_c::simulation::snapshots::*;
use robot_dynamics_c::simulation::*;
use robot_dynamics_c::workspace::*;

fn arm() -> Robot {
    Robot::load("robots/panda.urdf", false)
}

fn quadruped() -> Robot {
    Robot::load("robots/quadruped.urdf", true)
}

/// Two joints about one axis with a link without mass between them: M is singular.
const COAXIAL: &str = r#"<robot name="coaxial">
  <link name="base"/><link name="ring"/>
  <link name="disc"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="outer" type="continuous"><parent link="base"/><child link="ring"/><axis xyz="0 0 1"/></joint>
  <joint name="inner" type="continuous"><parent link="ring"/><child link="disc"/><axis xyz="0 0 1"/></joint>
</robot>"#;

/// One use of each kind of handle.
fn uses(id: u64) -> [(&'static str, Status); 12] {
    let (mut x, mut w) = ([0.0; 3], WorkspaceHandle { id: 0 });
    let (mut energy, mut snapshot) = (EnergyAccountC::default(), SnapshotHandle { id: 0 });
    let (inputs, results) = (InputsC::default(), ResultsC::default());
    let (i, r) = (&raw const inputs, &raw const results);
    let simulation = SimulationHandle { id };
    [
        ("model", rd!(rd_workspace_new(ModelHandle { id }, &raw mut w))),
        ("workspace", rd!(rd_center_of_mass(WorkspaceHandle { id }, in [0.0; 3], mut x))),
        ("batch", rd!(rd_batch_compute(BatchHandle { id }, 0, 1, i, r))),
        ("simulation", rd!(rd_simulation_energy(simulation, &raw mut energy))),
        ("simulation", rd!(rd_simulation_snapshot(simulation, &raw mut snapshot))),
        ("controller", rd!(rd_computed_torque_torque(ComputedTorqueHandle { id }, in x, in x, mut x))),
        ("task controller", rd!(rd_task_control_torque(TaskControlHandle { id }, in x, in x, mut x))),
        ("observer", rd_momentum_observer_reset(MomentumObserverHandle { id })),
        ("record", rd!(rd_motion_record_set_noise(MotionRecordHandle { id }, in x))),
        ("problem", rd_problem_clear_costs(ProblemHandle { id })),
        ("predictive controller", rd!(rd_mpc_step(MpcHandle { id }, in x, mut x))),
        ("constraints", constraints_of(id)),
    ]
}

/// Uses constraints with a valid workspace.
fn constraints_of(id: u64) -> Status {
    let robot = arm();
    let mut q = [0.0; 7];
    rd!(rd_project_position(robot.workspace, ConstraintsHandle { id }, 1e-9, mut q))
}

#[test]
fn null_and_random_handles_are_invalid_for_every_kind() {
    for id in [0, 1, u64::MAX, 0x0d00_0000_0000_0000, 0xff << 56, 0x0100_0000_ffff_ffff] {
        for (kind, status) in uses(id) {
            assert_eq!(status, Status::InvalidHandle, "{kind} {id:x}");
        }
    }
    fails(rd_problem_clear_costs(ProblemHandle { id: 0 }), Status::InvalidHandle, "the problem is null");
    fails(
        rd_momentum_observer_reset(MomentumObserverHandle { id: 0 }),
        Status::InvalidHandle,
        "the observer is null",
    );
}

#[test]
fn queries_of_invalid_handles_have_their_documented_values() {
    let (model, simulation) = (ModelHandle { id: 7 }, SimulationHandle { id: 7 });
    assert_eq!([rd_model_nq(model), rd_model_nv(model), rd_model_frame_count(model)], [0; 3]);
    assert!(rd_model_mass(model).is_nan() && rd_simulation_time(simulation).is_nan());
    assert!(rd_model_name(model).is_null() && rd_simulation_method(simulation).is_null());
    assert_eq!(rd_constraints_row_count(ConstraintsHandle { id: 7 }), 0);
    assert_eq!(rd_problem_control_count(ProblemHandle { id: 7 }), 0);
    let robot = arm();
    assert!(rd_model_joint_name(robot.handle, 1000).is_null());
    assert!(message().contains("1000"), "{}", message());
}

#[test]
fn handles_of_other_kinds_and_of_freed_objects_are_invalid() {
    let robot = arm();
    let (mut q, other) = ([0.0; 7], WorkspaceHandle { id: robot.handle.id });
    fails(rd!(rd_gravity(other, in [0.0; 7], mut q)), Status::InvalidHandle, "another kind");
    let mut w = WorkspaceHandle { id: 0 };
    ok(rd!(rd_workspace_new(robot.handle, &raw mut w)));
    ok(rd_workspace_free(w));
    fails(rd!(rd_gravity(w, in [0.0; 7], mut q)), Status::InvalidHandle, "the workspace was freed");
    fails(rd_workspace_free(w), Status::InvalidHandle, "freed");
    // A new object in the same slot has another handle.
    let mut next = WorkspaceHandle { id: 0 };
    ok(rd!(rd_workspace_new(robot.handle, &raw mut next)));
    assert_ne!(next.id, w.id);
    fails(rd!(rd_gravity(w, in [0.0; 7], mut q)), Status::InvalidHandle, "freed");
    ok(rd!(rd_gravity(next, in [0.0; 7], mut q)));
    ok(rd_workspace_free(next));
    ok(rd_workspace_free(WorkspaceHandle { id: 0 }));
    ok(rd_model_free(ModelHandle { id: 0 }));
}

#[test]
fn objects_remain_valid_after_their_model_is_freed() {
    let (first, mut g) = (arm(), [0.0; 7]);
    let w = first.workspace;
    ok(rd_model_free(first.handle));
    ok(rd!(rd_gravity(w, in [0.1; 7], mut g)));
    assert!(g[1] != 0.0);
}

#[test]
fn objects_of_other_robots_are_refused() {
    let (robot, other) = (Robot::load("robots/linkage.xml", false), quadruped());
    let mut set = ConstraintsHandle { id: 0 };
    ok(rd!(rd_constraints_from_file(robot.handle, &raw mut set)));
    let mut q = robot_dynamics::model::neutral(&other.model);
    let status = rd!(rd_project_position(other.workspace, set, 1e-9, mut q));
    fails(status, Status::InvalidHandle, "constraints");
    ok(rd_constraints_free(set));
}

#[test]
fn null_pointers_are_named() {
    let (robot, x) = (arm(), [0.0; 7]);
    let (w, mut y, bad) = (robot.workspace, [0.0; 7], Status::InvalidInput);
    fails(rd!(rd_bias(w, null(), 7, in x, mut y)), bad, "q is null");
    fails(rd!(rd_bias(w, in x, null(), 7, mut y)), bad, "v is null");
    fails(rd!(rd_bias(w, in x, in x, null_mut(), 7)), bad, "first result is null");
    fails(rd!(rd_inverse_dynamics(w, in x, in x, null(), 7, mut y)), bad, "a is null");
    fails(rd!(rd_forward_dynamics(w, in x, in x, null(), 7, mut y)), bad, "tau is null");
    fails(rd!(rd_kinetic_energy(w, in x, in x, null_mut())), bad, "result is null");
    fails(rd!(rd_load(null(), null(), null_mut())), bad, "`model` is null");
    let mut handle = ModelHandle { id: 0 };
    fails(rd!(rd_load(null(), null(), &raw mut handle)), bad, "path is null");
    fails(rd!(rd_load_text(null(), null(), &raw mut handle)), bad, "text is null");
    fails(rd!(rd_load_files(null(), 1, c"x".as_ptr(), null(), &raw mut handle)), bad, "files is null");
    fails(rd!(rd_model_frame(robot.handle, null(), null_mut())), bad, "name is null");
    fails(rd!(rd_model_frame(robot.handle, c"panda_link1".as_ptr(), null_mut())), bad, "`frame` is null");
    fails(rd!(rd_workspace_new(robot.handle, null_mut())), bad, "`workspace` is null");
    fails(rd!(rd_batch_new(robot.handle, 1, null_mut())), bad, "`batch` is null");
    fails(rd!(rd_simulation_new(robot.handle, null(), null_mut())), bad, "`simulation` is null");
    fails(rd!(rd_constraints_from_file(robot.handle, null_mut())), bad, "`constraints` is null");
    let (mut out, e, s) = ([0.0; 49], null(), 1e-3);
    let status = rd!(rd_linearize_step(w, e, s, 0, in x, in x, in x, mut out, mut y));
    fails(status, bad, "integrator is null");
    let matrix = [1.0];
    let m = matrix.as_ptr();
    fails(rd!(rd_dlqr(1, 1, null(), m, m, m, mut y, null_mut())), bad, "A is null");
    fails(rd!(rd_compute(w, 0, null(), null())), bad, "q has 0 entries");
    assert_eq!(y, [0.0; 7]);
}

#[test]
fn wrong_lengths_are_named() {
    let (robot, x) = (arm(), [0.0; 8]);
    let (w, mut y, bad) = (robot.workspace, [0.0; 8], Status::InvalidInput);
    fails(rd!(rd_gravity(w, in x, mut y[..7])), bad, "q has 8");
    fails(rd!(rd_gravity(w, in x[..7], mut y)), bad, "result has 8");
    fails(rd!(rd_bias(w, in x[..7], in x[..6], mut y[..7])), bad, "v has 6");
    fails(rd!(rd_gravity(w, in x[..0], mut y)), bad, "q has 0");
    fails(rd!(rd_gravity(w, x.as_ptr(), usize::MAX, mut y)), bad, "q has");
    fails(rd!(rd_model_gravity(robot.handle, mut y)), bad, "result has 8");
    fails(rd!(rd_frame_pose(w, 1, in x[..7], mut y)), bad, "pose has 8");
    fails(rd!(rd_frame_pose(w, 1000, in x[..7], mut y)), bad, "frame 1000");
    let status = rd!(rd_frame_velocity(w, 1, 3, in x[..7], in x[..7], mut y[..6]));
    fails(status, bad, "reference frame 3");
    let status = rd!(rd_inverse_kinematics(w, 1, in x[..5], in x[..7], null(), mut y[..7], null_mut()));
    fails(status, bad, "target has 5");
    fails(rd!(rd_integrate(robot.handle, in x[..7], in x, mut y[..7])), bad, "displacement has 8");
    let mut lengths = [usize::MAX; 3];
    fails(rd!(rd_quantity_lengths(w, 99, 0, mut lengths)), bad, "quantity 99");
    fails(rd!(rd_quantity_lengths(w, 15, usize::MAX, mut lengths)), bad, "frames");
    let mut batch = BatchHandle { id: 0 };
    ok(rd!(rd_batch_new(robot.handle, 1, &raw mut batch)));
    let inputs = InputsC { q: x.as_ptr(), q_len: 7, ..InputsC::default() };
    let (i, results) = (&raw const inputs, ResultsC::default());
    fails(rd!(rd_batch_compute(batch, 2, 2, i, &raw const results)), bad, "q has 7");
    fails(rd!(rd_batch_compute(batch, 2, usize::MAX, i, &raw const results)), bad, "states");
    fails(rd!(rd_batch_compute(batch, 2, 1, i, &raw const results)), bad, "first result has 0");
    ok(rd_batch_free(batch));
    assert_eq!(y, [0.0; 8]);
}

#[test]
fn unaligned_and_overlapping_arrays_are_named() {
    let (robot, mut x) = (arm(), [0.0; 14]);
    let (w, bad) = (robot.workspace, Status::InvalidInput);
    // The pointers remain within the array.
    #[allow(clippy::cast_ptr_alignment)] // on purpose
    let odd = x.as_mut_ptr().cast::<u8>().wrapping_add(1).cast::<f64>();
    let mut y = [0.0; 7];
    fails(rd!(rd_gravity(w, odd.cast_const(), 7, mut y)), bad, "q is not aligned");
    fails(rd!(rd_gravity(w, in x[..7], odd, 7)), bad, "result is not aligned");
    fails(rd!(rd_kinetic_energy(w, in x[..7], in x[..7], odd)), bad, "result is not aligned");
    let p = x.as_mut_ptr();
    fails(rd!(rd_gravity(w, p.cast_const(), 7, p, 7)), bad, "result overlaps");
    fails(rd!(rd_gravity(w, p.cast_const(), 7, p.wrapping_add(6), 7)), bad, "result overlaps");
    // Neighbours do not overlap, and inputs may.
    ok(rd!(rd_gravity(w, p.cast_const(), 7, p.wrapping_add(7), 7)));
    ok(rd!(rd_bias(w, in x[..7], in x[..7], mut y)));
    let (mut out, s) = ([0.0; 49], robot.state(1));
    let o = out.as_mut_ptr();
    let status = rd!(rd_inverse_dynamics_derivatives(w, in s.q, in s.v, in s.a, o, 49, o, 49));
    fails(status, bad, "second result overlaps");
    fails(rd!(rd_kinetic_energy(w, p.cast_const(), 7, in y, p)), bad, "overlaps");
    let one = [1.0; 1];
    let (m, mut gain) = (one.as_ptr(), [0.0; 1]);
    let k = gain.as_mut_ptr();
    fails(rd!(rd_dlqr(1, 1, m, m, m, m, k, 1, k)), bad, "spectral radius overlaps");
    assert_eq!(out, [0.0; 49]);
}

#[test]
fn invalid_numbers_are_refused_with_their_argument() {
    let robot = quadruped();
    let (w, s, n) = (robot.workspace, robot.state(1), robot.model.nv());
    let (mut y, bad) = (vec![0.0; n], Status::InvalidInput);
    for x in [f64::NAN, f64::INFINITY] {
        let (mut q, mut v) = (s.q.clone(), s.v.clone());
        (q[8], v[3]) = (x, x);
        fails(rd!(rd_bias(w, in q, in s.v, mut y)), bad, "q");
        fails(rd!(rd_bias(w, in s.q, in v, mut y)), bad, "v");
        fails(rd!(rd_inverse_dynamics(w, in s.q, in s.v, in v, mut y)), bad, "a");
        fails(rd!(rd_forward_dynamics(w, in s.q, in s.v, in v, mut y)), bad, "tau");
        fails(rd!(rd_integrate(robot.handle, in s.q, in v, mut q)), bad, "displacement");
        let mut between = s.q.clone();
        fails(rd!(rd_interpolate(robot.handle, in s.q, in s.q, x, mut between)), bad, "s");
    }
    let mut long = s.q.clone();
    long[3..7].iter_mut().for_each(|x| *x *= 1.1);
    fails(rd!(rd_gravity(w, in long, mut y)), bad, "q");
    long[3..7].fill(0.0);
    fails(rd!(rd_normalize(robot.handle, mut long)), bad, "q");
    let mut handle = SimulationHandle { id: 0 };
    for dt in [-1e-3, f64::NAN, f64::INFINITY] {
        let options = SimulationOptionsC { dt, ..SimulationOptionsC::default() };
        fails(rd!(rd_simulation_new(robot.handle, &raw const options, &raw mut handle)), bad, "step");
    }
    ok(rd!(rd_simulation_new(robot.handle, null(), &raw mut handle)));
    fails(rd!(rd_simulation_reset(handle, in s.q[1..], in s.v)), bad, "q");
    ok(rd_simulation_free(handle));
}

#[test]
fn singular_mass_matrices_have_their_status() {
    let robot = Robot::from_text(COAXIAL);
    let (w, x) = (robot.workspace, [0.3; 2]);
    let [mut m, mut a] = [[0.0; 4]; 2];
    ok(rd!(rd_mass_matrix(w, in x, mut m)));
    assert_eq!(m[0] * m[3], m[1] * m[2]);
    fails(rd!(rd_inverse_mass_matrix(w, in x, mut m)), Status::Singular, "`outer`");
    fails(rd!(rd_forward_dynamics(w, in x, in x, in x, mut a[..2])), Status::Singular, "`outer`");
}

#[test]
fn unknown_names_have_their_status() {
    let (robot, unknown) = (arm(), Status::UnknownName);
    let (mut frame, mut q, mut v) = (0, [0.0; 7], [0.0; 7]);
    fails(rd!(rd_model_frame(robot.handle, c"hnd".as_ptr(), &raw mut frame)), unknown, "`hnd`");
    fails(rd!(rd_quantity_named(c"mass".as_ptr(), &raw mut frame)), unknown, "`mass`");
    fails(rd!(rd_named_pose(robot.handle, c"hme".as_ptr(), mut q, mut v)), unknown, "`hme`");
    let (mut a, mut b, w) = ([0.0; 196], [0.0; 98], robot.workspace);
    let status = rd!(rd_linearize_step(w, c"rk5".as_ptr(), 1e-3, 0, in q, in q, in q, mut a, mut b));
    fails(status, unknown, "rk5");
    let mut handle = SimulationHandle { id: 0 };
    let method = SimulationOptionsC { method: c"rk5".as_ptr(), ..SimulationOptionsC::default() };
    fails(rd!(rd_simulation_new(robot.handle, &raw const method, &raw mut handle)), unknown, "rk5");
    let without = SimulationOptionsC { without: c"wind".as_ptr(), ..SimulationOptionsC::default() };
    fails(rd!(rd_simulation_new(robot.handle, &raw const without, &raw mut handle)), unknown, "wind");
    let bytes = [0xffu8, 0];
    fails(rd!(rd_quantity_named(bytes.as_ptr().cast(), &raw mut frame)), Status::InvalidInput, "UTF-8");
    assert_eq!((handle.id, frame), (0, 0));
}

#[test]
fn missing_and_malformed_files_have_their_status() {
    let mut handle = ModelHandle { id: 0 };
    let status = rd!(rd_load(c"no/such/robot.urdf".as_ptr(), null(), &raw mut handle));
    fails(status, Status::File, "no/such/robot.urdf");
    fails(rd!(rd_load_text(c"<robot".as_ptr(), null(), &raw mut handle)), Status::File, "");
    let files: [FileC; 0] = [];
    let status = rd!(rd_load_files(in files, c"a.urdf".as_ptr(), null(), &raw mut handle));
    fails(status, Status::File, "a.urdf");
    assert_eq!(handle.id, 0);
}

#[test]
fn messages_belong_to_their_thread() {
    let mut frame = 0;
    fails(rd!(rd_quantity_named(c"first".as_ptr(), &raw mut frame)), Status::UnknownName, "`first`");
    let other = std::thread::spawn(move || {
        assert_eq!(message(), "", "a new thread has no error");
        fails(rd!(rd_quantity_named(c"second".as_ptr(), &raw mut frame)), Status::UnknownName, "`second`");
    });
    other.join().expect("no panic");
    assert!(message().contains("`first`"));
    ok(rd!(rd_quantity_named(c"bias".as_ptr(), &raw mut frame)));
    assert!(message().contains("`first`"), "a call that succeeds keeps the text");
}

#[test]
fn long_messages_are_cut_at_a_character() {
    let mut frame = 0;
    for lead in ["", "x", "xy"] {
        // Three bytes each: the cut falls into different places of a character.
        let name = c(&format!("{lead}{}", "€".repeat(4000)));
        let status = rd!(rd_quantity_named(name.as_ptr(), &raw mut frame));
        assert_eq!(status, Status::UnknownName);
        let found = message();
        assert!(found.ends_with("€...") && found.len() > 8180, "{} bytes", found.len());
    }
}

#[test]
fn statuses_and_versions_have_their_numbers() {
    assert_eq!(text(rd_status_name(Status::InvalidHandle as i32)), "invalid handle");
    let names: Vec<String> = (0..=Status::Panic as i32).map(|status| text(rd_status_name(status))).collect();
    let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
    assert_eq!(distinct.len(), names.len());
    assert_eq!(text(rd_status_name(17)), "unknown status");
    assert_eq!(text(rd_status_name(-1)), "unknown status");
    assert_eq!((rd_version(), rd_abi_version()), (RD_VERSION, RD_ABI_VERSION));
    let parts: Vec<u32> =
        env!("CARGO_PKG_VERSION").split('.').map(|part| part.parse().expect("a number")).collect();
    assert_eq!(RD_VERSION, parts[0] * 10_000 + parts[1] * 100 + parts[2]);
}

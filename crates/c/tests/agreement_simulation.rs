//! Models, constraints and simulations give the names, numbers and bits of the library's calls in Rust.
//!
//! Unsafe code: the interface takes pointers. Each call passes slices of this program.
#![allow(unsafe_code)]
// Numbers of frames and seeds are small.
#![allow(clippy::cast_possible_truncation)]

#[macro_use]
mod common;

use std::ptr::null;

use common::{Robot, c, file, ok, robots, same_bits, text};
use robot_dynamics::constraints::{
    ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis, constrained_forward_dynamics,
    project_position,
};
use robot_dynamics::contact::Ground;
use robot_dynamics::description::LoadReport;
use robot_dynamics::model::Workspace;
use robot_dynamics::simulation::{AppliedWrench, Effect, EnergyAccount, Method, Simulation};
use robot_dynamics_c::Status;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::load::*;
use robot_dynamics_c::model::*;
use robot_dynamics_c::simulation::contacts::{ContactC, rd_simulation_contacts};
use robot_dynamics_c::simulation::inputs::*;
use robot_dynamics_c::simulation::sensors::*;
use robot_dynamics_c::simulation::snapshots::*;
use robot_dynamics_c::simulation::*;

#[test]
fn facts_of_models_are_those_of_library() {
    for robot in &robots() {
        let (h, model) = (robot.handle, &robot.model);
        assert_eq!((rd_model_nq(h), rd_model_nv(h)), (model.nq(), model.nv()));
        assert_eq!(text(rd_model_name(h)), model.name());
        assert_eq!(rd_model_mass(h).to_bits(), model.mass().to_bits());
        assert_eq!(rd_model_fingerprint(h), model.fingerprint());
        let names = |count: usize, name: &dyn Fn(usize) -> String| (0..count).map(name).collect::<Vec<_>>();
        let joints: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names(rd_model_joint_count(h), &|k| text(rd_model_joint_name(h, k))), joints);
        let frames: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
        assert_eq!(names(rd_model_frame_count(h), &|k| text(rd_model_frame_name(h, k as u32))), frames);
        assert_eq!(names(model.nv(), &|k| text(rd_model_coordinate_name(h, k))), model.coordinate_names());
        for (k, name) in frames.iter().enumerate() {
            let (name, mut found) = (c(name), u32::MAX);
            ok(rd!(rd_model_frame(h, name.as_ptr(), &raw mut found)));
            assert_eq!(found as usize, k);
        }
        for (k, joint) in model.joints().iter().enumerate() {
            let [mut q, mut nq, mut v, mut nv] = [usize::MAX; 4];
            ok(rd!(rd_model_joint_indices(h, k, &raw mut q, &raw mut nq, &raw mut v, &raw mut nv)));
            assert_eq!([q, nq, v, nv], [joint.q_index, joint.nq, joint.v_index, joint.nv]);
        }
        let mut gravity = [0.0; 3];
        ok(rd!(rd_model_gravity(h, mut gravity)));
        same_bits("gravity", &gravity, &model.gravity());
        let limits = model.coordinate_limits();
        let mut found = [(); 4].map(|()| vec![0.0; model.nv()]);
        ok(rd!(rd_model_lower_limits(h, mut found[0])));
        ok(rd!(rd_model_upper_limits(h, mut found[1])));
        ok(rd!(rd_model_velocity_limits(h, mut found[2])));
        ok(rd!(rd_model_effort_limits(h, mut found[3])));
        for (k, limits) in limits.iter().enumerate() {
            let expected = [limits.lower, limits.upper, limits.velocity, limits.effort];
            same_bits("limits", &[0, 1, 2, 3].map(|kind: usize| found[kind][k]), &expected);
        }
    }
}

#[test]
fn files_in_memory_and_texts_give_the_robot_of_the_file() {
    let content = std::fs::read(file("robots/panda.urdf")).expect("a file");
    let (mut by_text, mut by_files) = (ModelHandle { id: 0 }, ModelHandle { id: 0 });
    let name = c("folder/arm.urdf");
    let files = [FileC { path: name.as_ptr(), content: content.as_ptr(), length: content.len() }];
    ok(rd!(rd_load_files(in files, name.as_ptr(), null(), &raw mut by_files)));
    let content = c(std::str::from_utf8(&content).expect("UTF-8"));
    ok(rd!(rd_load_text(content.as_ptr(), null(), &raw mut by_text)));
    let robot = Robot::load("robots/panda.urdf", false);
    for handle in [by_text, by_files] {
        assert_eq!(rd_model_fingerprint(handle), robot.model.fingerprint());
        ok(rd_model_free(handle));
    }
    let report = robot_dynamics::load(file("robots/panda.urdf")).expect("a robot").report;
    let report = LoadReport::to_string(&report);
    assert_eq!(text(rd_model_report(robot.handle)), report);
}

/// a, the multipliers and the projected q by the library.
fn constrained(robot: &Robot, set: &ConstraintSet, tolerance: f64) -> [Vec<f64>; 3] {
    let (options, s, mut w) = (ConstraintOptions::of_files(), robot.state(1), Workspace::new(&robot.model));
    let mut q = robot_dynamics::model::neutral(&robot.model);
    let motion = constrained_forward_dynamics(&robot.model, &mut w, set, &options, &q, &s.v, &s.tau);
    let motion = motion.expect("a motion");
    q[0] += 0.01;
    project_position(&robot.model, &mut w, set, &options, tolerance, &mut q).expect("a projection");
    [motion.acceleration.as_slice().to_vec(), motion.multipliers.as_slice().to_vec(), q]
}

/// The same by handle.
fn constrained_by_handle(robot: &Robot, set: ConstraintsHandle, tolerance: f64) -> [Vec<f64>; 3] {
    let (s, w) = (robot.state(1), robot.workspace);
    let mut q = robot_dynamics::model::neutral(&robot.model);
    let (mut a, mut multipliers) = (vec![0.0; robot.model.nv()], vec![0.0; rd_constraints_row_count(set)]);
    ok(rd!(rd_constrained_forward_dynamics(w, set, in q, in s.v, in s.tau, mut a, mut multipliers)));
    q[0] += 0.01;
    ok(rd!(rd_project_position(w, set, tolerance, mut q)));
    [a, multipliers, q]
}

#[track_caller]
fn same_constraints(robot: &Robot, handle: ConstraintsHandle, set: &ConstraintSet) {
    let rows: Vec<String> =
        (0..rd_constraints_row_count(handle)).map(|row| text(rd_constraints_row_name(handle, row))).collect();
    assert_eq!(rows, set.row_names());
    let (found, expected) = (constrained_by_handle(robot, handle, 1e-9), constrained(robot, set, 1e-9));
    for (name, (found, expected)) in ["a", "multipliers", "q"].iter().zip(found.iter().zip(&expected)) {
        same_bits(name, found, expected);
    }
    assert!(found[1].iter().any(|multiplier| *multiplier != 0.0));
    ok(rd_constraints_free(handle));
}

#[test]
fn constraints_give_bits_of_library() {
    let robot = Robot::load("robots/linkage.xml", false);
    let mut handle = ConstraintsHandle { id: 0 };
    ok(rd!(rd_constraints_from_file(robot.handle, &raw mut handle)));
    same_constraints(&robot, handle, &ConstraintSet::from_equalities(&robot.model).expect("loops"));

    let robot = Robot::load("robots/quadruped.urdf", true);
    let names = ["front_left_foot", "hind_right_foot"];
    let ids = names.map(|name| robot.model.frame(name).expect("a foot"));
    let q = robot_dynamics::model::neutral(&robot.model);
    let mut w = Workspace::new(&robot.model);
    let poses = ids.map(|id| robot_dynamics::algorithms::frame_pose(&robot.model, &mut w, &q, id));
    let numbers = names.map(|name| {
        let (name, mut frame) = (c(name), 0);
        ok(rd!(rd_model_frame(robot.handle, name.as_ptr(), &raw mut frame)));
        frame
    });
    let points: Vec<f64> = poses.iter().flat_map(|pose| pose.translation).collect();
    ok(rd!(rd_constraints_at_points(robot.handle, in numbers, in points, &raw mut handle)));
    let held =
        [0, 1].map(|k| (names[k].to_owned(), FrameConstraint::point_contact(ids[k], poses[k].translation)));
    let set = held.map(|(name, constraint)| (name, constraint.into()));
    same_constraints(&robot, handle, &ConstraintSet::new(&robot.model, set.to_vec()).expect("supports"));

    // The pose of one foot: two would need axes that the legs do not have.
    let twelve: Vec<f64> = poses[0].rotation.iter().flatten().chain(&poses[0].translation).copied().collect();
    ok(rd!(rd_constraints_at_poses(robot.handle, in numbers[..1], in twelve, &raw mut handle)));
    let held = FrameConstraint::contact(ids[0], poses[0], &ALL_AXES);
    let set = vec![(names[0].to_owned(), held.into())];
    same_constraints(&robot, handle, &ConstraintSet::new(&robot.model, set).expect("a support"));
}

const ALL_AXES: [SpatialAxis; 6] =
    [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

/// The state and the results of a simulation must equal those by handle.
#[track_caller]
fn same_simulation(handle: SimulationHandle, own: &Simulation) {
    let (nq, nv) = (own.q().len(), own.v().len());
    let [mut q, mut v, mut a, mut tau] = [nq, nv, nv, nv].map(|n| vec![0.0; n]);
    ok(rd!(rd_simulation_q(handle, mut q)));
    ok(rd!(rd_simulation_v(handle, mut v)));
    ok(rd!(rd_simulation_acceleration(handle, mut a)));
    ok(rd!(rd_simulation_applied_torques(handle, mut tau)));
    same_bits("q", &q, own.q());
    same_bits("v", &v, own.v());
    same_bits("a", &a, own.acceleration());
    same_bits("tau", &tau, own.applied_torques());
    assert_eq!(rd_simulation_time(handle).to_bits(), own.time().to_bits());
    let mut energy = EnergyAccountC::default();
    ok(rd!(rd_simulation_energy(handle, &raw mut energy)));
    let account: &EnergyAccount = own.energy_account();
    let found = [energy.kinetic, energy.potential, energy.start, energy.work, energy.dissipated];
    let rest = [energy.imbalance, energy.relative_imbalance, energy.drift];
    let expected = [account.kinetic(), account.potential(), account.start(), account.work()];
    let last = [account.imbalance(), account.relative_imbalance(), account.drift()];
    same_bits(
        "energies",
        &[&found[..], &rest].concat(),
        &[&expected[..], &[account.dissipated()], &last].concat(),
    );
    let mut contacts = [ContactC::default(); 32];
    let mut count = usize::MAX;
    ok(rd!(rd_simulation_contacts(handle, mut contacts, &raw mut count)));
    let found = own.contacts();
    assert_eq!(count, found.len());
    for (found, own) in contacts.iter().zip(&found) {
        same_bits("point", &found.point, &own.point);
        same_bits("normal", &found.normal, &own.normal);
        same_bits("gap", &[found.gap], &[own.gap]);
        same_bits("force", &found.force, &own.force);
        same_bits("moment", &found.moment, &own.moment);
        assert_eq!(found.other_link == u32::MAX, own.other_link.is_none());
    }
}

/// A quadruped above the ground, by handle and by value.
fn dropped(method: Option<&str>) -> (Robot, SimulationHandle, Simulation) {
    let robot = Robot::load("robots/quadruped.urdf", true);
    let name = method.map(c);
    let options = SimulationOptionsC {
        dt: 2e-3,
        method: name.as_ref().map_or(null(), |name| name.as_ptr()),
        without: c"dissipation, link-contacts".as_ptr(),
        has_ground: 1,
        ground_friction: 0.7,
        ..SimulationOptionsC::default()
    };
    let mut handle = SimulationHandle { id: 0 };
    ok(rd!(rd_simulation_new(robot.handle, &raw const options, &raw mut handle)));
    let mut ground = Ground::level(0.0);
    ground.friction = Some(0.7);
    let mut builder = robot_dynamics::simulation(&robot.model).dt(2e-3).ground(ground);
    builder = builder.without(Effect::Dissipation).without(Effect::LinkContacts);
    if let Some(name) = method {
        builder = builder.method(name.parse::<Method>().expect("a method"));
    }
    let mut own = builder.build().expect("a simulation");
    let (mut q, v) = (robot_dynamics::model::neutral(&robot.model), vec![0.0; robot.model.nv()]);
    q[2] = 0.45;
    ok(rd!(rd_simulation_reset(handle, in q, in v)));
    own.reset(&q, &v).expect("a state");
    (robot, handle, own)
}

#[test]
fn dropped_quadruped_gives_bits_of_library() {
    for method in [None, Some("implicit")] {
        let (robot, handle, mut own) = dropped(method);
        assert_eq!(text(rd_simulation_method(handle)), own.method().to_string());
        assert_eq!(text(rd_simulation_reason(handle)), own.reason());
        let mut touched = false;
        for k in 0..60 {
            ok(rd_simulation_step(handle, 5));
            (0..5).for_each(|_| own.step().expect("a step"));
            touched |= !own.contacts().is_empty();
            same_simulation(handle, &own);
            let tau: Vec<f64> =
                (0..robot.model.nv()).map(|i| if i < 6 { 0.0 } else { (i + k) as f64 }).collect();
            ok(rd!(rd_simulation_set_torques(handle, in tau)));
            own.set_torques(&tau);
        }
        assert!(touched, "the robot reaches the ground");
        let (frames, axes, wrench) = ([0u32], [1u32], [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
        ok(rd!(rd_simulation_set_wrenches(
            handle, frames.as_ptr(), axes.as_ptr(), 1, in wrench
        )));
        let first = robot.model.frame(&robot.model.frames()[0].name).expect("a frame");
        let axes = robot_dynamics::algorithms::ReferenceFrame::Local;
        let (force, moment) = ([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]);
        own.set_wrenches(&[AppliedWrench { frame: first, axes, force, moment }]);
        let (q, v) = (own.q().to_vec(), vec![0.1; robot.model.nv()]);
        ok(rd!(rd_simulation_set_state(handle, in q, in v)));
        own.set_state(&q, &v).expect("a state");
        ok(rd_simulation_step(handle, 10));
        (0..10).for_each(|_| own.step().expect("a step"));
        same_simulation(handle, &own);
        ok(rd_simulation_free(handle));
    }
}

#[test]
fn snapshots_restore_every_bit() {
    let (_robot, handle, mut own) = dropped(None);
    ok(rd_simulation_step(handle, 100));
    let mut snapshot = SnapshotHandle { id: 0 };
    ok(rd!(rd_simulation_snapshot(handle, &raw mut snapshot)));
    ok(rd_simulation_step(handle, 77));
    ok(rd_simulation_restore(handle, snapshot));
    (0..100).for_each(|_| own.step().expect("a step"));
    same_simulation(handle, &own);
    ok(rd_simulation_step(handle, 50));
    (0..50).for_each(|_| own.step().expect("a step"));
    same_simulation(handle, &own);
    let (_other_robot, other, _) = dropped(None);
    common::fails(rd_simulation_restore(other, snapshot), Status::InvalidHandle, "snapshot");
    ok(rd_snapshot_free(snapshot));
    ok(rd_simulation_free(handle));
    ok(rd_simulation_free(other));
}

/// A simulation with the defaults, by handle and by value.
fn default_simulation(robot: &Robot) -> (SimulationHandle, Simulation) {
    let mut handle = SimulationHandle { id: 0 };
    ok(rd!(rd_simulation_new(robot.handle, null(), &raw mut handle)));
    (handle, robot_dynamics::simulation(&robot.model).build().expect("a simulation"))
}

#[test]
fn sensors_and_actuators_give_bits_of_library() {
    for name in ["testdata/mjcf/sensors/arm.xml", "testdata/mjcf/sensors/walker.xml", "robots/arm.xml"] {
        let robot = Robot::load(name, false);
        let (handle, mut own) = default_simulation(&robot);
        let names: Vec<&str> = own.control_names().collect();
        let count = rd_simulation_control_count(handle);
        let found: Vec<String> = (0..count).map(|k| text(rd_simulation_control_name(handle, k))).collect();
        assert_eq!(found, names);
        let controls: Vec<f64> = (0..count).map(|k| 0.1 * k as f64).collect();
        ok(rd!(rd_simulation_set_controls(handle, in controls)));
        own.set_controls(&controls);
        ok(rd_simulation_step(handle, 20));
        (0..20).for_each(|_| own.step().expect("a step"));
        same_simulation(handle, &own);
        let mut values = vec![0.0; rd_simulation_sensor_value_count(handle)];
        ok(rd!(rd_simulation_sensors(handle, mut values)));
        let sensors = own.sensors();
        assert_eq!(rd_simulation_sensor_count(handle), sensors.len());
        for (k, (name, expected)) in sensors.iter().enumerate() {
            assert_eq!(&text(rd_simulation_sensor_name(handle, k)), name);
            let (mut first, mut count) = (0, 0);
            ok(rd!(rd_simulation_sensor_range(handle, k, &raw mut first, &raw mut count)));
            same_bits(name, &values[first..first + count], expected);
        }
        assert!(name.starts_with("robots") || !sensors.is_empty());
        if robot.model.named_pose("home").is_some() {
            ok(rd!(rd_simulation_reset_to(handle, c"home".as_ptr())));
            own.reset_to("home").expect("a pose");
            ok(rd_simulation_step(handle, 3));
            (0..3).for_each(|_| own.step().expect("a step"));
            same_simulation(handle, &own);
        }
        ok(rd_simulation_free(handle));
    }
}

/// The left-out features of a file have one line each.
#[test]
fn left_out_features_are_those_of_library() {
    for name in ["robots/hand.xml", "testdata/mjcf/tendons.xml", "robots/quadruped.xml"] {
        let robot = Robot::load(name, false);
        let (handle, own) = default_simulation(&robot);
        let lines: Vec<String> = own.unsupported_features().iter().map(ToString::to_string).collect();
        assert_eq!(text(rd_simulation_left_out(handle)), lines.join("\n"));
        ok(rd_simulation_free(handle));
    }
}

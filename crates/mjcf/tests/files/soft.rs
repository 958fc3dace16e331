//! Compares accelerations under MuJoCo's constraint law with MuJoCo: `testdata/mjcf/soft/golden.json`, or the
//! file that the environment variable `SOFT_GOLDEN` names.
//!
//! Tolerance: 1e-8 of the largest acceleration. MuJoCo's Newton method stops when its steps no longer lower
//! the cost, whose rounding is 1e-16, so its result has an error of about the root of that.

use nalgebra::Vector3;
use robot_dynamics::contact::{ContactSet, Ground, SoftConstraints, SoftContact, SoftDynamicsInputs};
use robot_dynamics::conventions::{
    acceleration_to_mujoco, configuration_from_mujoco, configuration_to_mujoco, force_from_mujoco,
    force_to_mujoco, velocity_to_mujoco,
};
use robot_dynamics::description::{PassiveForces, PolynomialStiffnessDamping, SolverImpedance, Surface};
use robot_dynamics::mjcf::{LoadOptions, load};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{MujocoEuler, StepForces, StepWorkspace, Stepper};
use serde_json::Value;

use crate::golden::{Golden, assert_near, numbers, root};

const SOLVED: f64 = 1e-8;

fn vector<const N: usize>(value: &Value) -> [f64; N] {
    numbers(value).try_into().expect("so many numbers")
}

/// A contact of MuJoCo.
fn contact(model: &Model, value: &Value) -> SoftContact {
    let frame = |key: &str| model.frame(value[key].as_str().expect("a name"));
    let [normal, point] = ["normal", "point"].map(|key| vector::<3>(&value[key]));
    let distance = value["distance"].as_f64().expect("a number");
    let link = frame("body").expect("a link");
    let mut contact = SoftContact::new(link, point, normal, distance).with_surface(&Surface::default());
    contact.other = frame("other").filter(|_| value["other"] != "world");
    contact.margin = value["margin"].as_f64().expect("a number");
    contact.condim = u8::try_from(value["condim"].as_u64().expect("a number")).expect("small");
    contact.friction = vector(&value["friction"]);
    if !value["surface_motion"].is_null() {
        contact.surface_motion = [0, 1].map(|part| vector::<3>(&value["surface_motion"][part]));
    }
    contact.softness = SolverImpedance { solref: vector(&value["solref"]), solimp: vector(&value["solimp"]) };
    contact
}

/// Checks that this library and MuJoCo have the same contact.
fn assert_alike(what: &str, own: &SoftContact, theirs: &SoftContact) {
    assert_eq!((own.link, own.other, own.condim), (theirs.link, theirs.other, theirs.condim), "{what}");
    let numbers = |contact: &SoftContact| {
        let SoftContact { point, normal, friction, softness, surface_motion, .. } = *contact;
        let rest = [contact.distance, contact.margin];
        // Sliding and torsion count only the tangential velocity and the normal angular velocity.
        let (n, [velocity, spin]) = (Vector3::from(normal), surface_motion.map(Vector3::from));
        let sideways = velocity - n * n.dot(&velocity);
        let turn = if contact.condim > 3 { n.dot(&spin) } else { 0.0 };
        let moved = [sideways.x, sideways.y, sideways.z, turn];
        [&point[..], &normal, &friction, &softness.solref, &softness.solimp, &rest, &moved].concat()
    };
    assert_near(&format!("{what}, a contact"), &numbers(own), &numbers(theirs), 1e-12);
}

fn golden() -> Value {
    let own = root().join("testdata/mjcf/soft/golden.json");
    let file = std::env::var_os("SOFT_GOLDEN").map_or(own, Into::into);
    serde_json::from_str(&std::fs::read_to_string(file).expect("the file")).expect("JSON")
}

/// Combines the surface of a shape with that of MuJoCo's default plane, because the ground here has no
/// surface of its own. The priority of the plane is 0, and its weight in the mix is that of a default shape.
fn on_plane(own: &Surface) -> Surface {
    let plane = Surface::default();
    if own.priority > 0 {
        return *own;
    }
    let mut both = if own.priority < 0 { plane } else { *own };
    (both.contype, both.conaffinity, both.margin) = (own.contype, own.conaffinity, own.margin);
    if own.priority < 0 {
        return both;
    }
    let share = own.solmix / (own.solmix + plane.solmix);
    let mean = |own: f64, plane: f64| share * own + (1.0 - share) * plane;
    both.condim = own.condim.max(plane.condim);
    for k in 0..3 {
        both.friction[k] = own.friction[k].max(plane.friction[k]);
    }
    for k in 0..2 {
        let is_direct = own.solref[0] <= 0.0;
        both.solref[k] =
            if is_direct { own.solref[k].min(plane.solref[k]) } else { mean(own.solref[k], plane.solref[k]) };
    }
    for k in 0..5 {
        both.solimp[k] = mean(own.solimp[k], plane.solimp[k]);
    }
    both
}

/// The robot without the forces that are absent in the golden data, and its constraints.
fn robot(file: &str, record: &Value) -> (Model, SoftConstraints, ContactSet) {
    let mut robot = load(root().join(file), &LoadOptions::default()).expect("a robot").description;
    for link in &mut robot.links {
        link.gravity_compensation = 0.0;
    }
    for tendon in &mut robot.tendons {
        let PassiveForces { armature, friction, .. } = tendon.passive;
        tendon.passive = PassiveForces::default().with_armature(armature).with_friction(friction);
        tendon.higher_terms = PolynomialStiffnessDamping::default();
    }
    robot.actuators.clear();
    for shape in &mut robot.shapes {
        shape.surface = on_plane(&shape.surface);
    }
    let model = Model::new(robot).expect("a model");
    let number = |key: &str| record[key].as_f64().expect("a number");
    let soft = SoftConstraints::new(&model, number("time_step")).expect("weights");
    let ground = ContactSet::new(&model, &[Ground::level(0.0)]).expect("a ground");
    (model, soft.with_impratio(number("impratio")), ground)
}

#[test]
fn accelerations_under_soft_constraints_are_mujocos() {
    let golden = golden();
    let (mut compared, mut handed, mut found_own) = (0, 0, 0);
    for (file, record) in golden["files"].as_object().expect("files") {
        let (model, mut soft, ground) = robot(file, record);
        let mut workspace = Workspace::new(&model);
        let mut by_itself = soft.clone().with_ground(&model, ground).expect("no restitution");
        for (at, state) in record["states"].as_array().expect("states").iter().enumerate() {
            let (q, v) = Golden::state(&model, state);
            let (mut tau, mut a) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
            force_from_mujoco(&model, &q, &numbers(&state["qfrc"]), &mut tau);
            let (expected, constraint) = (numbers(&state["qacc"]), numbers(&state["constraint"]));
            let contacts: Vec<SoftContact> = state["contacts"]
                .as_array()
                .expect("contacts")
                .iter()
                .map(|value| contact(&model, value))
                .collect();
            soft.forward(
                &model,
                &mut workspace,
                SoftDynamicsInputs { q: &q, v: &v, tau: &tau, contacts: &contacts },
                &mut a,
            )
            .expect("an acceleration");
            let mut theirs = vec![0.0; model.nv()];
            acceleration_to_mujoco(&model, &q, &v, &a, &mut theirs);
            assert_near(&format!("{file} {at}, qacc"), &theirs, &expected, SOLVED);
            force_to_mujoco(&model, &q, soft.forces(), &mut theirs);
            assert_near(&format!("{file} {at}, constraint forces"), &theirs, &constraint, SOLVED);
            compared += 1;
            handed += contacts.len();
            if state["on_ground"] == true {
                by_itself
                    .forward(
                        &model,
                        &mut workspace,
                        SoftDynamicsInputs { q: &q, v: &v, tau: &tau, contacts: &[] },
                        &mut a,
                    )
                    .expect("an acceleration");
                assert_eq!(by_itself.contacts().count(), contacts.len(), "{file} {at}: contacts");
                for ((own, _), theirs) in by_itself.contacts().zip(&contacts) {
                    assert_alike(&format!("{file} {at}"), own, theirs);
                }
                acceleration_to_mujoco(&model, &q, &v, &a, &mut theirs);
                assert_near(&format!("{file} {at}, qacc on own contacts"), &theirs, &expected, SOLVED);
                found_own += contacts.len();
            }
        }
    }
    assert!(compared >= 40 && handed >= 30 && found_own >= 20, "{compared} {handed} {found_own}");
}

/// Robots that fall, by MuJoCo's step: the motion and the contacts are the same.
///
/// Tolerance: 1e-6 rad or m. The difference between the two solvers, 1e-11 of the accelerations, grows in
/// impacts.
#[test]
fn falls_by_mujocos_step_are_mujocos() {
    let (golden, mut dropped) = (golden(), 0);
    for (file, record) in golden["files"].as_object().expect("files") {
        let drop = &record["drop"];
        if drop.is_null() {
            continue;
        }
        dropped += 1;
        let (model, soft, ground) = robot(file, record);
        let mut stepper = MujocoEuler::new(&model, soft.with_ground(&model, ground).expect("no restitution"));
        let mut workspace = StepWorkspace::new(&model);
        let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
        configuration_from_mujoco(&model, &numbers(&drop["start"]), &mut q);
        let (tau, h) = (vec![0.0; model.nv()], record["time_step"].as_f64().expect("a number"));
        let forces = StepForces::new(&tau, true);
        let compared = drop["steps"].as_u64().expect("a number");
        let (mut same, mut most) = (0, 0);
        let counts = numbers(&drop["contacts"]);
        for (step, &count) in counts.iter().enumerate() {
            if step as u64 == compared {
                let (mut qpos, mut qvel) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
                configuration_to_mujoco(&model, &q, &mut qpos);
                velocity_to_mujoco(&model, &q, &v, &mut qvel);
                assert_near(&format!("{file}, qpos"), &qpos, &numbers(&drop["end_qpos"]), 1e-6);
                assert_near(&format!("{file}, qvel"), &qvel, &numbers(&drop["end_qvel"]), 1e-6);
            }
            stepper.step(&model, &mut workspace, &forces, h, &mut q, &mut v).expect("a step");
            let own = stepper.law().contacts().count();
            same += usize::from(own as f64 == count);
            most = most.max(own);
        }
        println!("{file}: as many contacts in {same} of {} steps, at most {most}", counts.len());
        assert!(same == counts.len() && most > 1, "{file}: {same} of {}", counts.len());
    }
    // The project's own file has two robots with falls; other files have some.
    let is_own = std::env::var_os("SOFT_GOLDEN").is_none();
    assert!(if is_own { dropped == 2 } else { dropped > 0 }, "{dropped} robots fell");
}

//! USD files: those that converters write from the robots of this project, and features by hand.
//!
//! Tolerances: USD stores masses, poses of joints and rotations as floats. Floats are read as the shortest
//! decimal numbers that round to them. Where these are the numbers of the robot's file, M and the bias agree
//! to 1e-12 of the largest entry. Otherwise each number has a part of 6e-8 of rounding, half the unit in the
//! last place of a float. A chain of a dozen joints has about 128 such numbers: two rotations of four numbers
//! for each joint, and its masses.

use std::path::PathBuf;

use robot_dynamics::description::{MassProperties, Mimic, RobotDescription};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{LoadOptions, LoadedDescription, load_description};

const EXACT: f64 = 1e-12;
const FLOAT: f64 = 128.0 * 6e-8;

fn root(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn load(path: &str) -> LoadedDescription {
    load_description(root(path), &LoadOptions::default()).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The places of a model's coordinates in another, by the names of joints: for q and v.
fn places(model: &Model, other: &Model) -> [Vec<usize>; 2] {
    let mut places = [Vec::new(), Vec::new()];
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        let found = other.joints().iter().find(|other| other.name == joint.name);
        // The joint of a free body has the name of a floating base, or of the file.
        let free = || other.joints().iter().find(|other| other.nv == 6 && joint.nv == 6);
        let found = found.or_else(free).unwrap_or_else(|| panic!("no joint {}", joint.name));
        assert_eq!(found.nv, joint.nv, "{}", joint.name);
        places[0].extend(found.q());
        places[1].extend(found.v());
    }
    places
}

fn assert_same(what: &str, one: &RobotDescription, other: &RobotDescription, tolerance: f64) {
    let [one, other] =
        [one, other].map(|robot| Model::new(robot.clone()).unwrap_or_else(|error| panic!("{what}: {error}")));
    assert_eq!((one.nq(), one.nv()), (other.nq(), other.nv()), "{what}");
    let [in_q, in_v] = places(&one, &other);
    let mut random = SplitMix64::new(7);
    for _ in 0..3 {
        let state = random_state(&one, &mut random);
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        in_q.iter().enumerate().for_each(|(at, &place)| q[place] = state.q[at]);
        in_v.iter().enumerate().for_each(|(at, &place)| v[place] = state.v[at]);
        let (m, bias) = (one.mass_matrix(&state.q).expect("M"), one.bias(&state.q, &state.v).expect("bias"));
        let other_m = other.mass_matrix(&q).expect("M");
        let other_bias = other.bias(&q, &v).expect("bias");
        for row in 0..one.nv() {
            for column in 0..one.nv() {
                let error = (m[(row, column)] - other_m[(in_v[row], in_v[column])]).abs();
                assert!(error <= tolerance * m.amax(), "{what}: M differs by {error:e} of {:e}", m.amax());
            }
            let error = (bias[row] - other_bias[in_v[row]]).abs();
            assert!(
                error <= tolerance * bias.amax(),
                "{what}: bias differs by {error:e} of {:e}",
                bias.amax()
            );
        }
    }
}

/// The files of `bench/golden/make_usd.py`, by urdf-usd-converter and mujoco-usd-converter.
#[test]
fn converted_robots_have_the_dynamics_of_their_files() {
    let exact = ["two_r", "three_r", "panda", "ur5", "linkage", "gripper_and_box"];
    for entry in std::fs::read_dir(root("testdata/usd")).expect("the folder") {
        let file = entry.expect("a file").file_name().into_string().expect("a name");
        let Some((stem, kind)) = file.strip_suffix(".usdc").and_then(|name| name.rsplit_once('_')) else {
            continue;
        };
        let usd = load(&format!("testdata/usd/{file}"));
        let mut own = load(&format!("robots/{stem}.{kind}"));
        if file == "hand_xml.usdc" {
            // The equality of two joints is a mimic joint in USD.
            let joint = own.description.joints.iter_mut().find(|joint| joint.name == "second_root");
            joint.expect("the joint").mimic = Some(Mimic::new("first_root", 1.0, 0.0));
        }
        if file == "quadruped_urdf.usdc" {
            // Without a mass, USD fills the collision shape of a foot with 1000 kg/m³.
            for link in own.description.links.iter_mut().filter(|link| link.name.ends_with("foot")) {
                link.mass_properties = MassProperties::solid_sphere(1000.0, 0.02).ok();
            }
        }
        let tolerance = if exact.contains(&stem) { EXACT } else { FLOAT };
        assert_same(&file, &own.description, &usd.description, tolerance);
    }
}

//! Rust over lanes: Cargo builds it with `robot-dynamics-number`, and its tests hold it to the functions of one state.

use std::path::Path;

use generate::{Arithmetic, Function, Precision, Request, Sine, Target, generate};
use multibody::Model;

use crate::folder::Folder;
use crate::robots;

/// Builds the crate and runs the tests that come with the code; a command that reads nothing from the network.
pub(crate) fn test(name: &str, model: &Model, functions: Vec<Function>, arithmetic: Arithmetic) -> String {
    let request =
        Request::new(Target::Rust, functions).with_arithmetic(arithmetic).with_lanes().with_name(name);
    let folder = Folder::of(name, &generate(model, &request).unwrap());
    let number = Path::new(env!("CARGO_MANIFEST_DIR")).join("../number").canonicalize().unwrap();
    let patch = format!("patch.crates-io.robot-dynamics-number.path={:?}", number.to_str().unwrap());
    // One build of `number` for all, whose crates differ in name.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("generated/lanes_target");
    let arguments = ["test", "--offline", "--quiet", "--config", &patch];
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    folder.run(&cargo, &[&arguments[..], &["--target-dir", target.to_str().unwrap()]].concat())
}

/// Each kind of operation, of argument and of result: compiled thrice each, all functions would take minutes.
fn functions(model: &Model) -> Vec<Function> {
    let frame = model.frames().last().unwrap().name.clone();
    vec![
        Function::InverseDynamics,
        Function::ForwardDynamics,
        Function::MassMatrix,
        Function::MassMatrixRelated,
        Function::Dissipation,
        Function::SemiImplicitEulerStep,
        Function::FramePose(frame),
    ]
}

/// Functions of a robot with a ball, a free base, springs and friction, in both precisions, on every instruction set that is here.
#[test]
fn each_kind_of_joint_and_number_gives_the_bits_of_one_state() {
    let model = robots::random();
    for (name, precision) in [("lanes_double", Precision::Double), ("lanes_single", Precision::Single)] {
        let told = test(name, &model, functions(&model), Arithmetic::new(precision));
        assert!(told.contains("14 passed"), "{told}");
    }
}

/// Every function there is, of a small arm.
#[test]
fn every_function_gives_the_bits_of_one_state() {
    let model = robots::named("two_r.urdf");
    let functions = robots::with_slopes(&model);
    let count = 2 * functions.len();
    let told = test("lanes_every_function", &model, functions, Arithmetic::default());
    assert!(told.contains(&format!("{count} passed")), "{told}");
}

/// Where the registers round a multiply-add once, they do so as one state's code does.
#[test]
fn fused_multiply_adds_are_those_of_one_state() {
    let model = robots::named("gripper.urdf");
    let functions = vec![Function::InverseDynamics, Function::ForwardDynamics];
    let told = test("lanes_fused", &model, functions, Arithmetic::default().with_fused());
    assert!(told.contains("4 passed"), "{told}");
}

/// A robot whose functions come in parts, with arrays between them.
#[test]
fn parts_give_the_bits_of_one_state() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
    let options = robot_dynamics::Options::default().with_floating_base();
    let model = robot_dynamics::load_with(path, &options).unwrap().model;
    let told = test("lanes_parts", &model, vec![Function::ForwardDynamics], Arithmetic::default());
    assert!(told.contains("2 passed"), "{told}");
}

#[test]
fn what_lanes_have_not_is_refused() {
    let model = robots::named("two_r.urdf");
    let refused = |target, sine| {
        let arithmetic = Arithmetic::default().with_sine(sine);
        let request = Request::new(target, vec![Function::Gravity]).with_arithmetic(arithmetic);
        generate(&model, &request.with_lanes()).unwrap_err().to_string()
    };
    assert_eq!(refused(Target::C, Sine::Own), "c has no lanes: they are for the target rust");
    let told = refused(Target::Rust, Sine::Platform);
    assert!(told.starts_with("Rust over lanes has no platform's sine"), "{told}");
}

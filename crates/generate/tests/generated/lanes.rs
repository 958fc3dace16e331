//! Rust over lanes: Cargo builds it with `robot-dynamics-number`, and its tests compare it with the functions
//! for one state.

use std::path::Path;

use robot_dynamics::model::Model;
use robot_dynamics_generate::{
    Arithmetic, Function, GenerateError, Precision, Request, Sine, Target, generate,
};

use crate::folder::Folder;
use crate::robots;

/// Builds the crate and runs its tests, without access to the network.
pub(crate) fn test(name: &str, model: &Model, functions: Vec<Function>, arithmetic: Arithmetic) -> String {
    let request =
        Request::new(Target::Rust, functions).with_arithmetic(arithmetic).with_lanes().with_name(name);
    let folder = Folder::of(name, &generate(model, &request).unwrap());
    let number = Path::new(env!("CARGO_MANIFEST_DIR")).join("../number").canonicalize().unwrap();
    let patch = format!("patch.crates-io.robot-dynamics-number.path={:?}", number.to_str().unwrap());
    // All crates share one build of `number`, as their names differ.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("generated/lanes_target");
    let arguments = ["test", "--offline", "--quiet", "--config", &patch];
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    folder.run(&cargo, &[&arguments[..], &["--target-dir", target.to_str().unwrap()]].concat())
}

/// Functions with each kind of operation, argument and result. All functions, compiled three times each,
/// would take minutes.
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

/// Functions of a robot with a spherical joint, a floating base, springs and friction, in both precisions, on
/// every instruction set of this machine.
#[test]
fn each_kind_of_joint_and_number_gives_the_bits_of_one_state() {
    let model = robots::random();
    for (name, precision) in [("lanes_double", Precision::Double), ("lanes_single", Precision::Single)] {
        let output = test(name, &model, functions(&model), Arithmetic::new(precision));
        assert!(output.contains("14 passed"), "{output}");
    }
}

/// Every function of a small arm.
#[test]
fn every_function_gives_the_bits_of_one_state() {
    let model = robots::named("two_r.urdf");
    let functions = robots::with_derivatives(&model);
    let count = 2 * functions.len();
    let output = test("lanes_every_function", &model, functions, Arithmetic::default());
    assert!(output.contains(&format!("{count} passed")), "{output}");
}

/// Fused multiply-adds over lanes have the bits of those for one state.
#[test]
fn fused_multiply_adds_are_those_of_one_state() {
    let model = robots::named("gripper.urdf");
    let functions = vec![Function::InverseDynamics, Function::ForwardDynamics];
    let output = test("lanes_fused", &model, functions, Arithmetic::default().with_fused());
    assert!(output.contains("4 passed"), "{output}");
}

/// A robot whose functions have parts, with arrays between them.
#[test]
fn parts_give_the_bits_of_one_state() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
    let options = robot_dynamics::LoadOptions::default().with_floating_base();
    let model = robot_dynamics::load_with(path, &options).unwrap().model;
    let output = test("lanes_parts", &model, vec![Function::ForwardDynamics], Arithmetic::default());
    assert!(output.contains("2 passed"), "{output}");
}

#[test]
fn unsupported_requests_are_rejected() {
    let model = robots::named("two_r.urdf");
    let refused = |target, sine| {
        let arithmetic = Arithmetic::default().with_sine(sine);
        let request = Request::new(target, vec![Function::Gravity]).with_arithmetic(arithmetic);
        let error = generate(&model, &request.with_lanes()).unwrap_err();
        let GenerateError::NotInTarget { target, .. } = error else { panic!("{error}") };
        target
    };
    assert_eq!(refused(Target::C, Sine::Own), "c");
    assert_eq!(refused(Target::Rust, Sine::Platform), "Rust over lanes");
}

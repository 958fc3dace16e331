//! The texts of errors and notes.

use std::fmt::Write;
use std::path::PathBuf;

use robot_dynamics::description::{RobotDescription, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics_generate::{
    Arithmetic, Builder, Function, GenerateError, Precision, Request, Sine, Target, generate, measure,
};

use crate::robots;

/// Requests that are refused.
#[test]
fn refusals() {
    let model = robots::named("two_r.urdf");
    let single = Arithmetic::new(Precision::Single);
    let platform = Arithmetic::default().with_sine(Sine::Platform);
    let gravity = |target| Request::new(target, vec![Function::Gravity]);
    let mut text = String::new();
    for request in [
        gravity(Target::Wgsl),
        gravity(Target::Wgsl).with_arithmetic(single.with_sine(Sine::Platform)),
        gravity(Target::Casadi).with_arithmetic(single),
        gravity(Target::C).with_lanes(),
        gravity(Target::Rust).with_arithmetic(platform).with_lanes(),
        Request::new(Target::C, vec![Function::Gravity, Function::Gravity]),
        Request::new(Target::C, vec![Function::FramePose("nowhere".into())]),
    ] {
        let error = generate(&model, &request).unwrap_err();
        let _ = writeln!(text, "{}: {error}", request.target);
    }
    let error =
        measure(&model, &gravity(Target::Wgsl).with_arithmetic(single), &std::env::temp_dir()).unwrap_err();
    let _ = writeln!(text, "measure: {error}");
    let mut still: RobotDescription = pendulum(2.0, 0.5);
    still.joints.clear();
    still.frames.clear();
    still.links.truncate(1);
    let error = generate(&Model::new(still).unwrap(), &gravity(Target::C)).unwrap_err();
    let _ = writeln!(text, "without joints: {error}");
    let error = Builder::new("robots/panda.urdf").write_module("panda.rs").unwrap_err();
    let _ = writeln!(text, "outside a build script: {error}");
    insta::assert_snapshot!(text);
}

/// Errors that depend on the system, or that no correct program gives.
#[test]
fn other_errors() {
    let (robot, function) = ("arm".to_owned(), "gravity".to_owned());
    let path = PathBuf::from("code/arm.c");
    let errors = [
        GenerateError::NotFinite { robot: robot.clone(), function: function.clone() },
        GenerateError::Differs { robot, function },
        GenerateError::Compiler { program: "cc".into(), what: "not found".into() },
        GenerateError::Foreign { path: path.clone() },
        GenerateError::File { path, cause: std::io::ErrorKind::PermissionDenied.into() },
    ];
    let mut text = String::new();
    for error in errors {
        let _ = writeln!(text, "{error}");
    }
    insta::assert_snapshot!(text);
}

/// Notes for robots whose names a target cannot have.
#[test]
fn other_names() {
    let mut text = String::new();
    for (target, name) in [
        (Target::Rust, "fn"),
        (Target::Rust, "std"),
        (Target::Rust, "main"),
        (Target::C, "math"),
        (Target::C, "_arm"),
        (Target::C, "com1"),
    ] {
        let mut robot = pendulum(2.0, 0.5);
        robot.name = name.into();
        let generated = generate(&Model::new(robot).unwrap(), &Request::new(target, vec![Function::Gravity]));
        let _ = writeln!(text, "{target}: {}", generated.unwrap().renamed.unwrap());
    }
    insta::assert_snapshot!(text);
}

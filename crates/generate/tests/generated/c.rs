//! C, compiled by the system's compiler and by Clang if it is installed, with all warnings.

use std::process::Command;

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::description::Shape;
use robot_dynamics::model::Model;
use robot_dynamics_generate::{
    Arithmetic, Function, GenerateError, Precision, Request, Sine, Target, generate,
};

use crate::folder::{Folder, summary};
use crate::{machine_code, robots};

const STRICT: [&str; 7] =
    ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-fno-math-errno"];

/// Undefined behaviour that GCC detects ends the program.
pub(crate) const SANITIZED: [&str; 3] = ["-O0", "-fsanitize=undefined", "-fno-sanitize-recover=all"];

/// The system's compiler, and Clang if it is installed.
fn compilers() -> Vec<&'static str> {
    let is_there = |compiler: &&str| Command::new(compiler).arg("--version").output().is_ok();
    std::iter::once("cc").chain(["clang"].into_iter().filter(is_there)).collect()
}

/// Compiles and runs the generated test; the output must be the same for every compiler. With the code's own
/// sine, machine code made in memory must have the bits of the compiled functions.
pub(crate) fn test(
    name: &str,
    model: &Model,
    functions: Vec<Function>,
    arithmetic: Arithmetic,
    options: &[&str],
) -> String {
    test_by(&compilers(), name, model, functions, arithmetic, options)
}

fn test_by(
    compilers: &[&str],
    name: &str,
    model: &Model,
    functions: Vec<Function>,
    arithmetic: Arithmetic,
    options: &[&str],
) -> String {
    let called = functions.clone();
    let request = Request::new(Target::C, functions).with_arithmetic(arithmetic).with_name("robot");
    let mut generated = generate(model, &request).unwrap();
    let has_own_sine = arithmetic.sine == Sine::Own;
    if has_own_sine {
        let mut caller = generated.files[0].clone();
        caller.name = "bits.c".into();
        caller.text = machine_code::caller(model, &called, arithmetic);
        generated.files.push(caller);
    }
    let folder = Folder::of(name, &generated);
    let output = compilers.iter().map(|&compiler| {
        // Clang's sanitizer is a library that is rarely installed.
        let options = if compiler == "clang" && options == SANITIZED { &["-O0"] } else { options };
        let compile = |arguments: &[&str]| folder.compile(compiler, &[&STRICT, options, arguments].concat());
        let object = format!("robot_{compiler}.o");
        compile(&["-c", "robot.c", "-o", &object]);
        let test = format!("./test_{compiler}");
        compile(&["test_robot.c", &object, "-lm", "-o", &test]);
        if has_own_sine {
            let bits = format!("./bits_{compiler}");
            compile(&["bits.c", &object, "-lm", "-o", &bits]);
            machine_code::check(name, model, &called, arithmetic, &folder.run(&bits, &[]));
        }
        folder.run(&test, &[])
    });
    output
        .reduce(|one, other| {
            assert_eq!(one, other, "{name}");
            one
        })
        .unwrap()
}

/// Inverse and forward dynamics, M and a frame of every robot, without optimisation.
#[test]
fn every_robot_has_the_bits_of_the_library() {
    for (name, model) in robots::all() {
        let frame = model.frames().last().unwrap().name.clone();
        let functions = vec![
            Function::InverseDynamics,
            Function::ForwardDynamics,
            Function::MassMatrix,
            Function::Dissipation,
            Function::FramePose(frame.clone()),
            Function::FrameJacobian(ReferenceFrame::Local, frame),
        ];
        let output = test(&format!("c_{name}"), &model, functions, Arithmetic::default(), &["-O0"]);
        assert_eq!(output, summary(6, true), "{name}");
    }
}

/// Every function of a robot with a floating base, in both precisions, doubles with the sanitizer.
#[test]
fn every_function_has_the_bits_of_the_library_without_undefined_behaviour() {
    let model = robots::random();
    let single = Arithmetic::new(Precision::Single);
    for (name, arithmetic, options) in
        [("c_double", Arithmetic::default(), &SANITIZED[..]), ("c_single", single, &["-O0"])]
    {
        let output = test(name, &model, robots::functions(&model), arithmetic, options);
        assert_eq!(output, summary(28, true));
    }
}

/// A step with contact as one expression, and its stages.
#[test]
fn a_step_with_contact_has_the_bits_of_the_library() {
    let mut functions = Function::OF_CONTACT.to_vec();
    functions.push(Function::ContactStep { sweeps: 3 });
    let output = test("c_contact", &robots::on_ground(), functions, Arithmetic::default(), &SANITIZED);
    assert_eq!(output, summary(7, true));
}

/// A robot whose contacts are unsupported has no such function, and the error names the shape.
#[test]
fn a_mesh_on_the_ground_is_refused() {
    let mut robot = robots::on_ground().description().clone();
    robot.shapes[0].shape = Shape::mesh("sole.stl");
    for target in [Target::C, Target::Cuda] {
        let request = Request::new(target, vec![Function::OF_CONTACT[0].clone()]);
        let error = generate(&Model::new(robot.clone()).unwrap(), &request).unwrap_err().to_string();
        assert!(error.contains(&robot.shapes[0].link) && error.contains("remove or replace"), "{error}");
    }
}

/// The derivatives of every function. The sanitizer runs on those of an arm, as it takes minutes for long
/// functions. The longest function of the floating robot, longer than all others together, is tested for the
/// arm only. Its singles, whose text differs in the type only, are tested with the fastest compiler.
#[test]
fn derivatives_agree_with_the_library() {
    let (free, arm) = (robots::random(), robots::named("three_r.urdf"));
    let derivatives = |model| robots::with_derivatives(model).split_off(28);
    let mut but_longest = derivatives(&free);
    but_longest.retain(|slope| slope.to_string() != "rk4_step_derivatives");
    let (double, single) = (Arithmetic::default(), Arithmetic::new(Precision::Single));
    let all = compilers();
    for (compilers, name, model, derivatives, arithmetic, options, count) in [
        (&all[..], "c_derivatives", &free, but_longest.clone(), double, &["-O0"][..], 43),
        (&all[all.len() - 1..], "c_derivatives_single", &free, but_longest, single, &["-O0"], 43),
        (&all[..], "c_derivatives_sanitised", &arm, derivatives(&arm), double, &SANITIZED, 44),
    ] {
        let output = test_by(compilers, name, model, derivatives, arithmetic, options);
        assert_eq!(output, summary(count, false), "{name}");
    }
}

/// With optimisation; with fused multiply-adds, which the C library computes exactly and slowly; with the
/// platform's sine.
#[test]
fn every_arithmetic_agrees_with_the_library() {
    let model = robots::named("gripper.urdf");
    let own = Arithmetic::default();
    for (name, arithmetic, is_exact) in [
        ("c_own", own, true),
        ("c_fused", own.with_fused(), true),
        ("c_single_fused", Arithmetic::new(Precision::Single).with_fused(), true),
        ("c_platform", own.with_sine(Sine::Platform), false),
    ] {
        let output = test(name, &model, robots::functions(&model), arithmetic, &["-O1"]);
        assert_eq!(output, summary(28, is_exact), "{name}");
    }
}

/// A wrong number fails the generated test, which reports its position.
#[test]
fn a_wrong_number_is_found() {
    let model = robots::named("two_r.urdf");
    let request = Request::new(Target::C, vec![Function::Gravity]).with_name("robot");
    let mut generated = generate(&model, &request).unwrap();
    for file in &mut generated.files {
        if file.name == "robot.c" {
            assert!(file.text.contains("9.81"));
            file.text = file.text.replace("9.81", "9.80665");
        }
    }
    let folder = Folder::of("c_wrong", &generated);
    folder.run("cc", &["robot.c", "test_robot.c", "-o", "test"]);
    let output = folder.fail("./test", &[]);
    assert!(output.contains("gravity: gravity, state 0, number 0: "), "{output}");
}

/// The same request gives the same bytes. A file that was not generated is kept, and nothing is written then.
#[test]
fn files_are_the_same_each_time_and_replace_no_other() {
    let model = robots::named("two_r.urdf");
    let request = Request::new(Target::C, vec![Function::MassMatrix]).with_name("robot");
    let (one, two) = (generate(&model, &request).unwrap(), generate(&model, &request).unwrap());
    assert_eq!(one, two);
    let folder = Folder::of("c_twice", &one);
    two.write(&folder.0).unwrap(); // generated files are replaced
    std::fs::write(folder.0.join("robot.c"), "int mine;\n").unwrap();
    std::fs::remove_file(folder.0.join("robot.h")).unwrap();
    let error = two.write(&folder.0).unwrap_err();
    assert!(matches!(&error, GenerateError::Foreign { path } if path.ends_with("robot.c")), "{error}");
    assert!(!folder.0.join("robot.h").exists());
}

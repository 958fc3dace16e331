//! Robots with many bodies that are alike: their code has loops, is shorter, and gives the library's bits; other robots' code has none.

use generate::{Arithmetic, Function, Precision, Request, Target, generate};
use multibody::Model;

use crate::testing::chain;
use crate::{c, lanes, robots, rust};

fn functions() -> Vec<Function> {
    vec![
        Function::InverseDynamics,
        Function::ForwardDynamics,
        Function::MassMatrix,
        Function::MassMatrixFactor,
        Function::SemiImplicitEulerStep,
        Function::InverseDynamics.derivatives(),
        Function::ForwardDynamics.pullback(),
    ]
}

/// Two groups of equal links, two others between.
fn two_groups() -> Model {
    chain(&[&[1.0; 8][..], &[0.3, 2.0], &[0.5; 8]].concat())
}

/// The code alone, without its test.
fn code(model: &Model, request: &Request) -> String {
    let generated = generate(model, request).unwrap();
    let is_code = |name: &str| name == "robot.c" || name == "src/robot.rs";
    generated.files.iter().find(|file| is_code(&file.name)).unwrap().text.clone()
}

#[test]
fn loops_in_c_give_the_librarys_bits_without_undefined_behaviour() {
    let exact = "robot: 5 functions in 5 states, as the library's, to the last bit\n";
    let slopes = "robot: 2 functions in 5 states, as the library's\n";
    let single = Arithmetic::new(Precision::Single);
    for (name, model, arithmetic, options) in [
        ("c_chain", chain(&[1.0; 16]), Arithmetic::default(), &["-O2"][..]),
        ("c_chain_sanitised", chain(&[1.0; 16]), Arithmetic::default(), &c::SANITIZED),
        ("c_chain_single", two_groups(), single, &["-O1"]),
        ("c_chain_fused", two_groups(), Arithmetic::default().with_fused(), &["-O0"]),
    ] {
        let (plain, of_slopes) = (functions()[..5].to_vec(), functions()[5..].to_vec());
        assert_eq!(c::test(name, &model, plain, arithmetic, options), exact, "{name}");
        assert_eq!(c::test(name, &model, of_slopes, arithmetic, options), slopes, "{name}");
    }
}

#[test]
fn loops_in_rust_give_the_librarys_bits() {
    let own = Arithmetic::default();
    for (name, model, arithmetic) in [
        ("rust_chain", chain(&[1.0; 16]), own),
        ("rust_chain_single", two_groups(), Arithmetic::new(Precision::Single)),
    ] {
        let told = rust::test(name, &model, functions(), arithmetic);
        assert!(told.contains("7 passed"), "{told}");
    }
}

#[test]
fn loops_over_lanes_give_the_bits_of_one_state() {
    let functions = vec![Function::InverseDynamics, Function::MassMatrixRelated];
    for (name, precision) in [("lanes_chain", Precision::Double), ("lanes_chain_single", Precision::Single)] {
        let told = lanes::test(name, &two_groups(), functions.clone(), Arithmetic::new(precision));
        assert!(told.contains("4 passed"), "{told}");
    }
}

/// By how much the code of 16 equal links is shorter, in each language that has loops.
#[test]
fn code_with_loops_is_shorter() {
    let model = chain(&[1.0; 16]);
    for (function, rate) in functions().into_iter().zip([0.4, 0.5, 0.6, 0.6, 0.5, 0.6, 0.6]) {
        for target in [Target::C, Target::Rust, Target::Casadi] {
            let request = Request::new(target, vec![function.clone()]).with_name("robot");
            let (loops, straight) = (code(&model, &request), code(&model, &request.clone().with_straight()));
            println!("{function} {target} {:.2}", loops.len() as f64 / straight.len() as f64);
            let head = if target == Target::Rust { " in 0.." } else { "for (int k = 0;" };
            let _ = rate;
            assert!(!straight.contains(head) && loops.contains(head), "{function}, {target}");
        }
    }
}

/// Without bodies that are alike there are no loops, and not a byte is another.
#[test]
fn other_robots_have_no_loops() {
    let unequal: Vec<f64> = (0..8).map(|k| 1.0 + f64::from(k)).collect();
    let robots = robots::all().into_iter().chain([("unequal".to_owned(), chain(&unequal))]);
    for (name, model) in robots {
        for target in [Target::C, Target::Rust, Target::Casadi] {
            let functions = vec![
                Function::InverseDynamics,
                Function::ForwardDynamics,
                Function::MassMatrix,
                Function::ForwardDynamics.derivatives(),
            ];
            let request = Request::new(target, functions);
            let straight = generate(&model, &request.clone().with_straight()).unwrap();
            assert!(generate(&model, &request).unwrap() == straight, "{name}, {target}");
        }
    }
}

/// Devices compile straight-line code.
#[test]
fn devices_get_no_loops() {
    let request = Request::new(Target::Cuda, vec![Function::InverseDynamics]);
    let (model, straight) = (chain(&[1.0; 16]), request.clone().with_straight());
    assert_eq!(generate(&model, &request).unwrap(), generate(&model, &straight).unwrap());
}

/// The report counts what is done, and says what is written.
#[test]
fn the_report_tells_of_loops() {
    let request = Request::new(Target::C, vec![Function::InverseDynamics]);
    let report = |request: &Request| {
        generate(&chain(&[1.0; 16]), request).unwrap().file("REPORT.md").unwrap().text.clone()
    };
    let (loops, straight) = (report(&request), report(&request.clone().with_straight()));
    let row = |text: &str| {
        let row = text.lines().find(|line| line.starts_with("| inverse_dynamics")).unwrap();
        row.split(" | ").take(7).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(row(&loops), row(&straight));
    assert!(loops.contains("operations written") && loops.contains("Loops of fixed lengths"), "{loops}");
    assert!(!straight.contains("operations written") && straight.contains("No loops"), "{straight}");
}

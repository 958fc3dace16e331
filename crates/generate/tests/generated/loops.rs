//! The code of robots with many equal bodies has loops, is shorter, and has the library's bits; other robots'
//! code has none.

use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, GeneratedFiles, Precision, Request, Target, generate};

use crate::folder::{Folder, summary};
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

/// Two groups of equal links, with two others between.
fn two_groups() -> Model {
    chain(&[&[1.0; 8][..], &[0.3, 2.0], &[0.5; 8]].concat())
}

/// Links of one shape and different masses.
fn unequal() -> Model {
    let masses: Vec<f64> = (1..=12).map(f64::from).collect();
    chain(&masses)
}

/// Whether a code has a loop over bodies, in C or Rust.
fn has_loop(code: &str) -> bool {
    code.contains("for (int k = 0;") || code.contains("for k in 0..")
}

/// The code, without its test.
fn code(model: &Model, request: &Request) -> String {
    let generated = generate(model, request).unwrap();
    let is_code = |name: &str| name == "robot.c" || name == "src/robot.rs";
    generated.files.iter().find(|file| is_code(&file.name)).unwrap().text.clone()
}

#[test]
fn loops_in_c_have_the_bits_of_the_library_without_undefined_behaviour() {
    let single = Arithmetic::new(Precision::Single);
    for (name, model, arithmetic, options) in [
        ("c_chain", chain(&[1.0; 16]), Arithmetic::default(), &["-O2"][..]),
        ("c_chain_sanitised", chain(&[1.0; 16]), Arithmetic::default(), &c::SANITIZED),
        ("c_chain_single", two_groups(), single, &["-O1"]),
        ("c_chain_fused", two_groups(), Arithmetic::default().with_fused(), &["-O0"]),
        // The same operations on other numbers need tables of constants.
        ("c_chain_unequal", unequal(), Arithmetic::default(), &["-O1"]),
    ] {
        // Separate folders, so that neither is compiled again the next time.
        let (plain, of_derivatives) = (functions()[..5].to_vec(), functions()[5..].to_vec());
        assert_eq!(c::test(name, &model, plain, arithmetic, options), summary(5, true), "{name}");
        let of_derivatives = c::test(&format!("{name}_slopes"), &model, of_derivatives, arithmetic, options);
        assert_eq!(of_derivatives, summary(2, true), "{name}");
    }
}

#[test]
fn loops_in_rust_have_the_bits_of_the_library() {
    let own = Arithmetic::default();
    for (name, model, arithmetic) in [
        ("rust_chain", chain(&[1.0; 16]), own),
        ("rust_chain_single", two_groups(), Arithmetic::new(Precision::Single)),
    ] {
        let output = rust::test(name, &model, functions(), arithmetic);
        assert!(output.contains("7 passed"), "{output}");
    }
}

#[test]
fn loops_over_lanes_give_the_bits_of_one_state() {
    let functions = vec![Function::InverseDynamics, Function::MassMatrixRelated];
    for (name, precision) in [("lanes_chain", Precision::Double), ("lanes_chain_single", Precision::Single)] {
        let output = lanes::test(name, &two_groups(), functions.clone(), Arithmetic::new(precision));
        assert!(output.contains("4 passed"), "{output}");
    }
}

/// The code of equal links is shorter by these factors.
#[test]
fn code_with_loops_is_shorter() {
    for (links, function, factor) in [
        (16, Function::InverseDynamics, 4.0),
        (64, Function::InverseDynamics, 16.0),
        (16, Function::ForwardDynamics, 3.5),
        (64, Function::ForwardDynamics, 14.0),
        (16, Function::ForwardDynamics.pullback(), 3.0),
        (16, Function::SemiImplicitEulerStep, 3.5),
        (16, Function::InverseDynamics.derivatives(), 1.5),
        (32, Function::MassMatrix, 2.0),
    ] {
        let model = chain(&vec![1.0; links]);
        for target in [Target::C, Target::Rust] {
            let request = Request::new(target, vec![function.clone()]).with_name("robot");
            let (loops, straight) = (code(&model, &request), code(&model, &request.clone().with_straight()));
            let found = straight.len() as f64 / loops.len() as f64;
            assert!(found > factor, "{function}, {links} links, {target}: {found}");
            assert!(!has_loop(&straight) && has_loop(&loops), "{function}, {target}");
        }
    }
}

/// Calls the functions with loops and without, and compares the bits.
const CASADI_CALLER: &str = r#"
#include <stdio.h>
#include <string.h>
typedef int function(const double **, double **, long long *, double *, int);
function loops_inverse_dynamics, straight_inverse_dynamics, loops_mass_matrix, straight_mass_matrix;
function jac_loops_inverse_dynamics, jac_straight_inverse_dynamics;
static double x[4][18], one[3][324], other[3][324], w[4096];
static int same(function *f, function *g) {
    const double *arg[4] = {x[0], x[1], x[2], x[3]};
    double *left[3] = {one[0], one[1], one[2]}, *right[3] = {other[0], other[1], other[2]};
    f(arg, left, 0, w, 0);
    g(arg, right, 0, w, 0);
    return memcmp(one, other, sizeof one) == 0 && one[0][0] != 0;
}
int main(void) {
    for (int i = 0; i < 72; i++) x[i / 18][i % 18] = 0.1 + 0.37 * i - (i * i) % 7;
    printf("%d%d%d\n", same(loops_inverse_dynamics, straight_inverse_dynamics),
           same(loops_mass_matrix, straight_mass_matrix),
           same(jac_loops_inverse_dynamics, jac_straight_inverse_dynamics));
    return 0;
}
"#;

/// Code for CasADi, with matrices by columns and without zeros, has the bits of straight code.
#[test]
fn loops_for_casadi_change_no_bit() {
    let functions = vec![Function::InverseDynamics, Function::MassMatrix];
    let request = Request::new(Target::Casadi, functions);
    let model = two_groups();
    let loops = generate(&model, &request.clone().with_name("loops")).unwrap();
    let straight = generate(&model, &request.clone().with_straight().with_name("straight")).unwrap();
    let source = |generated: &GeneratedFiles, name: &str| generated.file(name).unwrap().text.clone();
    assert!(has_loop(&source(&loops, "loops.c")) && !has_loop(&source(&straight, "straight.c")));
    let folder = Folder::of("casadi_chain", &loops);
    std::fs::write(folder.0.join("straight.c"), source(&straight, "straight.c")).unwrap();
    std::fs::write(folder.0.join("caller.c"), CASADI_CALLER).unwrap();
    folder.run("make", &["loops.so"]); // with all warnings
    let sources = ["caller.c", "loops.c", "straight.c"];
    folder.run("cc", &[&["-std=c99", "-ffp-contract=off"], &sources[..], &["-lm", "-o", "caller"]].concat());
    assert_eq!(folder.run("./caller", &[]), "111\n");
}

/// Without equal bodies there are no loops, and the code is the same byte by byte.
#[test]
fn other_robots_have_no_loops() {
    let robots = robots::all().into_iter().chain([("random".to_owned(), robots::random())]);
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

/// Code for devices is straight.
#[test]
fn code_for_devices_has_no_loops() {
    let request = Request::new(Target::Cuda, vec![Function::InverseDynamics]);
    let (model, straight) = (chain(&[1.0; 16]), request.clone().with_straight());
    assert_eq!(generate(&model, &request).unwrap(), generate(&model, &straight).unwrap());
}

/// The report counts the operations done, and those written.
#[test]
fn the_report_lists_loops() {
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

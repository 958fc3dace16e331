//! Measurements by the compilers of this machine.

use robot_dynamics_expression::Arithmetic;

use super::*;

/// Functions of a small arm by both compilers, in both precisions: code, stack on this machine, both times,
/// and functions that the library lacks.
#[test]
fn code_stack_and_times_are_reported() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    let model = robot_dynamics::load(path).unwrap().model;
    let functions = vec![
        Function::InverseDynamics,
        Function::MassMatrixRelated,
        Function::SemiImplicitEulerStep,
        Function::KineticEnergy.derivatives(),
    ];
    for (target, precision) in [(Target::C, Precision::Double), (Target::Rust, Precision::Single)] {
        let folder = std::env::temp_dir().join(format!("generate_measure_{target}_{}", std::process::id()));
        let request = Request::new(target, functions.clone()).with_arithmetic(Arithmetic::new(precision));
        let text = measure(&model, &request, &folder).unwrap().text;
        std::fs::remove_dir_all(&folder).unwrap();
        for function in &functions {
            let line = text.lines().find(|line| line.starts_with(&format!("| {function} |"))).unwrap();
            let fields: Vec<&str> = line.split('|').map(str::trim).collect();
            let number = |k: usize| fields[k].parse::<f64>().unwrap_or_else(|_| panic!("{line}"));
            assert!(number(2) > 50.0 && number(2) < 20_000.0, "code: {line}");
            assert!(!cfg!(target_arch = "x86_64") || (8.0..2000.0).contains(&number(3)), "stack: {line}");
            assert!(number(4) > 0.5, "time: {line}");
            let is_alone = function.is_through_graph();
            assert!(fields[5].is_empty() == is_alone && fields[6].is_empty() == is_alone, "{line}");
            assert!(is_alone || (number(6) - number(5) / number(4)).abs() < 0.1 * number(6) + 0.02, "{line}");
        }
    }
    let request = Request::new(Target::Wgsl, functions).with_arithmetic(Arithmetic::new(Precision::Single));
    let error = measure(&model, &request, &std::env::temp_dir()).unwrap_err();
    assert!(matches!(error, GenerateError::NotInTarget { target: "wgsl", .. }), "{error}");
}

//! The trace of every function of every robot has the bits of the library's recursions.

use std::path::Path;

use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
use robot_dynamics::model::InstructionSet;
use robot_dynamics_expression::{Precision, interpret};
use robot_dynamics_native::{CompileError, Float, Kernel, Width};

use super::*;

/// The robots of the repository, those with legs with a floating base, and random ones.
fn robots() -> Vec<(String, Model)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let load = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut options = robot_dynamics::LoadOptions::default();
        if name == "humanoid.urdf" || name == "quadruped.urdf" {
            options = options.with_floating_base();
        }
        (name, robot_dynamics::load_with(path, &options).unwrap().model)
    };
    let options = RandomRobotOptions {
        joints: 6,
        base: Base::Floating,
        mimic: 0.2,
        tendons: 1,
        passive: 1.0,
        ..Default::default()
    };
    let random =
        (0..4).map(|seed| (format!("random {seed}"), Model::new(random_robot(seed, &options)).unwrap()));
    paths.iter().map(load).chain(random).collect()
}

fn functions(model: &Model) -> Vec<Function> {
    let of_frames = Function::of_frame(&model.frames().last().unwrap().name);
    Function::PLAIN.into_iter().chain(of_frames).collect()
}

/// In both precisions, fused and not, with either sine, the simplified operations give the same bits as the
/// recursions with all of theirs.
#[test]
fn simplifications_change_no_bit() {
    let (own, single) = (Arithmetic::default(), Arithmetic::new(Precision::Single));
    let ways = [
        own,
        single,
        own.with_fused(),
        single.with_fused(),
        own.with_sine(Sine::Platform),
        single.with_sine(Sine::Platform),
    ];
    let mut compared = 0;
    for (name, model) in robots() {
        for function in functions(&model) {
            for arithmetic in ways {
                let program = Program::new(&function, &model, arithmetic, 2).unwrap();
                for case in &program.cases {
                    let (found, _) = interpret(
                        &program.graph,
                        &program.plan,
                        &program.results,
                        arithmetic,
                        &case.arguments,
                    );
                    assert_eq!(found, case.results, "{name}, {function}, {arithmetic:?}");
                    compared += found.iter().map(Vec::len).sum::<usize>();
                }
                if arithmetic.sine == Sine::Own {
                    match arithmetic.precision {
                        Precision::Double => machine_code_is_the_same::<f64>(&name, &program, arithmetic),
                        Precision::Single => machine_code_is_the_same::<f32>(&name, &program, arithmetic),
                    }
                }
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

/// Machine code made in memory has the bits of the graph. All instruction sets of this machine are tested,
/// for one state and for several at once.
fn machine_code_is_the_same<T: Float>(name: &str, program: &Program, arithmetic: Arithmetic) {
    let Program { graph, results, arguments, cases, .. } = program;
    let lengths: Vec<usize> = arguments.iter().map(|argument| argument.length).collect();
    let states = cases.len();
    let inputs: Vec<Vec<T>> = (0..lengths.len())
        .map(|k| cases.iter().flat_map(|case| &case.arguments[k]).map(|&x| T::nearest(x)).collect())
        .collect();
    let inputs: Vec<&[T]> = inputs.iter().map(|input| &input[..]).collect();
    for &instructions in InstructionSet::ALL {
        for width in [Width::One, Width::Lanes] {
            let what =
                || format!("{name}, {}, {arithmetic:?}, {instructions:?}, {width:?}", program.function);
            let compiled = Kernel::<T>::compile(graph, results, &lengths, arithmetic, instructions, width);
            let kernel = match compiled {
                Ok(kernel) => kernel,
                Err(CompileError::NoEncoder { .. } | CompileError::NotOnThisProcessor { .. }) => continue,
                Err(error) => panic!("{}: {error}", what()),
            };
            let mut found: Vec<Vec<T>> =
                results.iter().map(|result| vec![T::nearest(f64::NAN); states * result.len()]).collect();
            let mut outputs: Vec<&mut [T]> = found.iter_mut().map(|output| &mut output[..]).collect();
            let mut scratch = vec![T::nearest(f64::NAN); kernel.scratch_len()];
            kernel.call_rows(states, &inputs, &mut outputs, &mut scratch, |_| panic!("{}: angles", what()));
            for (k, found) in found.iter().enumerate() {
                let found: Vec<f64> = found.iter().map(|&x| x.into()).collect();
                let expected: Vec<f64> = cases.iter().flat_map(|case| case.results[k].clone()).collect();
                assert_eq!(found, expected, "{}", what());
            }
        }
    }
}

/// The expected values of generated tests are the library's own, over its own floats, with the platform's
/// sine. They agree to rounding (the condition of M is below 1e7 in these states). They agree to the last bit
/// on the traced model, except for functions that the library computes in another frame.
#[test]
fn expected_values_agree_with_the_library() {
    for (name, model) in robots() {
        for function in functions(&model) {
            check_expected_values(&name, &model, &function, Precision::Double);
            // Singles have too few digits to compare where the condition is 1e7.
            if !in_other_frames(&model, &function) {
                check_expected_values(&name, &model, &function, Precision::Single);
            }
        }
    }
}

/// The same for five published robots, a floating humanoid among them; the simplified operations give these
/// values, too.
#[test]
fn published_robots_agree_with_the_library() {
    for name in ["allegro_hand", "anymal_c", "kinova", "talos", "tiago"] {
        let path = format!("{}/../../testdata/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let mut record: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let model = Model::new(serde_json::from_value(record["description"].take()).unwrap()).unwrap();
        for function in functions(&model) {
            check_expected_values(name, &model, &function, Precision::Double);
            let own = Arithmetic::default();
            let Program { graph, plan, results, cases, .. } =
                Program::new(&function, &model, own, 1).unwrap();
            let (found, _) = interpret(&graph, &plan, &results, own, &cases[0].arguments);
            assert_eq!(found, cases[0].results, "{name}, {function}");
        }
    }
}

/// Compares the expected values of a function in three states with the library.
fn check_expected_values(name: &str, model: &Model, function: &Function, precision: Precision) {
    let arithmetic = Arithmetic::new(precision).with_sine(Sine::Platform);
    let cases = Program::new(function, model, arithmetic, 3).unwrap().cases;
    let traced = &function.traced_model(model);
    let other_frames = in_other_frames(model, function);
    for case in &cases {
        if !other_frames {
            let expected = library_results(traced, function, case, precision);
            assert_eq!(case.results, expected, "{name}, {function}");
        }
        let expected = library_results(model, function, case, precision);
        // Terms that cancel have the size of M's entries, as the states are of order one.
        let least =
            if function.regroups(model) { largest(&mass_matrix(model, &case.arguments[0])) } else { 0.0 };
        for (found, expected) in case.results.iter().zip(&expected) {
            let size = largest(expected).max(least);
            for (x, y) in found.iter().zip(expected) {
                let allowed = if function.inverts_mass() { 1e7 } else { 32.0 * model.nv() as f64 };
                let allowed = allowed * arithmetic.precision.epsilon() * size;
                assert!((x - y).abs() <= allowed, "{name}, {function}: {x:e}, {y:e}");
            }
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, x| most.max(x.abs()))
}

fn mass_matrix(model: &Model, q: &[f64]) -> Vec<f64> {
    let mut mass = vec![0.0; model.nv() * model.nv()];
    robot_dynamics::algorithms::mass_matrix(
        model,
        &mut robot_dynamics::model::Workspace::new(model),
        q,
        &mut mass,
    );
    mass
}

/// The library's results, over its own floats.
fn library_results(model: &Model, function: &Function, case: &Case, precision: Precision) -> Vec<Vec<f64>> {
    match precision {
        Precision::Double => function.compute(model, &case.arguments).unwrap(),
        #[allow(clippy::cast_possible_truncation)] // they are singles
        Precision::Single => {
            let narrow = |row: &Vec<f64>| row.iter().map(|&x| x as f32).collect();
            let arguments: Vec<Vec<f32>> = case.arguments.iter().map(narrow).collect();
            let found = function.compute::<f32>(model, &arguments).unwrap();
            found.iter().map(|row| row.iter().map(|&x| f64::from(x)).collect()).collect()
        }
    }
}

/// Whether the traced recursions use body frames where those over floats use one frame. With mimic joints, or
/// armature on tendons, derivatives of forward dynamics need M, too.
fn in_other_frames(model: &Model, function: &Function) -> bool {
    use Function::{
        ForwardDynamics, ForwardDynamicsDerivatives, ForwardDynamicsPullback, InverseDynamicsDerivatives,
        InverseMassMatrix, MassMatrix, MassMatrixFactor, MassMatrixRelated, Rk4Step, SemiImplicitEulerStep,
    };
    let by_mass =
        [InverseDynamicsDerivatives, InverseMassMatrix, MassMatrix, MassMatrixFactor, MassMatrixRelated];
    let by_articulated = [ForwardDynamics, Rk4Step, SemiImplicitEulerStep];
    let with_mimic_joints = [ForwardDynamicsDerivatives, ForwardDynamicsPullback];
    let robot = model.description();
    let is_coupled = !robot.tendons.is_empty() || robot.joints.iter().any(|joint| joint.mimic.is_some());
    by_mass.contains(function)
        || by_articulated.contains(function)
        || is_coupled && with_mimic_joints.contains(function)
}

/// The results with the own and the platform's sine agree to rounding. The recursions propagate the sine's
/// last digit; the condition of M is below 1e7 in these states.
#[test]
fn the_own_sine_changes_results_by_rounding_alone() {
    let model = &robots().into_iter().find(|(name, _)| name == "panda.urdf").unwrap().1;
    for function in functions(model) {
        let [own, platform] = [Sine::Own, Sine::Platform]
            .map(|sine| Program::new(&function, model, Arithmetic::default().with_sine(sine), 20).unwrap());
        for (own, platform) in own.cases.iter().zip(&platform.cases) {
            for (own, platform) in own.results.iter().zip(&platform.results) {
                let size = platform.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for (x, y) in own.iter().zip(platform) {
                    assert!((x - y).abs() <= 1e7 * f64::EPSILON * size, "{function}: {x:e}, {y:e}");
                }
            }
        }
    }
}

/// Functions that invert M are rejected with the joints' names where M is singular in every pose; other
/// functions are accepted.
#[test]
fn a_singular_mass_matrix_is_rejected_with_its_joints() {
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    robot.links.iter_mut().for_each(|link| link.mass_properties = None);
    let model = Model::new(robot).unwrap();
    let error = Program::new(&Function::ForwardDynamics, &model, Arithmetic::default(), 1).unwrap_err();
    let GenerateError::Function(crate::FunctionError::Singular { cause, .. }) = &error else {
        panic!("{error}")
    };
    assert!(cause.to_string().contains("hinge"), "{error}");
    assert!(Program::new(&Function::InverseDynamics, &model, Arithmetic::default(), 1).is_ok());
}

//! Every function of every robot: what is traced gives the library's bits.

use std::path::Path;

use super::*;
use multibody::{Base, RandomRobotOptions, random_robot};

use crate::Precision;

/// The robots of the repository, those with legs floating.
fn robots() -> Vec<(String, Model)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let load = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut options = robot_dynamics::Options::default();
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
    let frame = model.frames().last().unwrap().name.clone();
    let of_frames = [
        Function::FramePose(frame.clone()),
        Function::FrameJacobianWorldAligned(frame.clone()),
        Function::FrameJacobianInFrame(frame),
    ];
    Function::PLAIN.into_iter().chain(of_frames).collect()
}

/// In both precisions, fused and not, with either sine: the operations that are left give what the recursions give when every one
/// of theirs is done, to the last bit.
#[test]
fn what_is_left_out_changes_no_bit() {
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
                    let found = interpret(
                        &program.graph,
                        &program.plan,
                        &program.results,
                        arithmetic,
                        &case.arguments,
                    );
                    assert_eq!(found, case.results, "{name}, {function}, {arithmetic:?}");
                    compared += found.iter().map(Vec::len).sum::<usize>();
                }
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

/// The values that generated tests hold the code to are the library's own, over its own floats, with the platform's sine: to the
/// last bit, or, of what the library over floats computes in another frame, to rounding (the condition of M is below 1e7 in
/// these states).
#[test]
fn the_expected_values_are_the_librarys() {
    for (name, model) in robots() {
        for function in functions(&model) {
            let hold = |found: &[Vec<f64>], expected: &[Vec<f64>], epsilon: f64| {
                if !in_other_frames(&model, &function) {
                    assert_eq!(found, expected, "{name}, {function}");
                    return;
                }
                for (found, expected) in found.iter().zip(expected) {
                    let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    for (x, y) in found.iter().zip(expected) {
                        assert!((x - y).abs() <= 1e7 * epsilon * size, "{name}, {function}: {x:e}, {y:e}");
                    }
                }
            };
            let double =
                Program::new(&function, &model, Arithmetic::default().with_sine(Sine::Platform), 3).unwrap();
            let library = call::call::<f64>(&function, &model).unwrap();
            for case in &double.cases {
                hold(&case.results, &library(&case.arguments), f64::EPSILON);
            }
            let single = Arithmetic::new(Precision::Single).with_sine(Sine::Platform);
            let single = Program::new(&function, &model, single, 3).unwrap();
            if in_other_frames(&model, &function) {
                continue; // singles leave nothing to compare where the condition is 1e7
            }
            let library = call::call::<f32>(&function, &model).unwrap();
            for case in &single.cases {
                #[allow(clippy::cast_possible_truncation)] // they are singles
                let narrow = |rows: &[Vec<f64>]| -> Vec<Vec<f32>> {
                    rows.iter().map(|row| row.iter().map(|&x| x as f32).collect()).collect()
                };
                assert_eq!(library(&narrow(&case.arguments)), narrow(&case.results), "{name}, {function}");
            }
        }
    }
}

/// Whether the traced recursions work in body frames where those over floats work in one. With followers, or armature on tendons,
/// derivatives of forward dynamics need M, too.
fn in_other_frames(model: &Model, function: &Function) -> bool {
    use Function::{
        ForwardDynamics, ForwardDynamicsDerivatives, ForwardDynamicsPullback, InverseDynamicsDerivatives,
    };
    use Function::{InverseMassMatrix, MassMatrix, MassMatrixRelated, Rk4Step, SemiImplicitEulerStep};
    let by_mass = [InverseDynamicsDerivatives, InverseMassMatrix, MassMatrix, MassMatrixRelated];
    let by_articulated = [ForwardDynamics, Rk4Step, SemiImplicitEulerStep];
    let with_followers = [ForwardDynamicsDerivatives, ForwardDynamicsPullback];
    let robot = model.description();
    let is_coupled = !robot.tendons.is_empty() || robot.joints.iter().any(|joint| joint.mimic.is_some());
    by_mass.contains(function)
        || by_articulated.contains(function)
        || is_coupled && with_followers.contains(function)
}

/// Own and platform's sine give the same to rounding: a sine's last digit, carried through the recursions (the condition
/// of M is below 1e7 in these states).
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

/// What inverts M is refused, with the joints' names, where M is singular in every pose; the rest is not.
#[test]
fn a_singular_mass_matrix_is_refused_by_its_joints() {
    let mut robot = multibody::pendulum(2.0, 0.5);
    robot.links.iter_mut().for_each(|link| link.mass_properties = None);
    let model = Model::new(robot).unwrap();
    let error = Program::new(&Function::ForwardDynamics, &model, Arithmetic::default(), 1).unwrap_err();
    assert!(error.to_string().contains("hinge"), "{error}");
    assert!(Program::new(&Function::InverseDynamics, &model, Arithmetic::default(), 1).is_ok());
}

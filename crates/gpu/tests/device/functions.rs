//! Every function of generated code.

use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Precision, Request, Target, generate};
use robot_dynamics_gpu::{Device, Function};
use serde_json::Value;

use crate::bounds::{Bounds, inverts_mass};
use crate::robots;

/// Each function on the device agrees with the library's recursions over singles, evaluated on the CPU in the
/// order of the code. A device may fuse operations and round quotients differently. So the tolerance is k ε
/// of the largest number of a table. Where M is inverted it is κ² times that, as derivatives of functions
/// that invert M invert it twice.
#[test]
fn every_function_agrees_with_the_library() {
    let Some(device) = crate::device() else { return };
    for model in [robots::named("gripper.urdf"), robots::with_ball()] {
        let of_frames = Function::of_frame(&model.frames().last().unwrap().name);
        let derivatives = [
            Function::SemiImplicitEulerStep.derivatives(),
            Function::Rk4Step.pullback(),
            of_frames[0].clone().derivatives(),
            Function::CoriolisMatrix.pullback(),
            Function::KineticEnergy.derivatives(),
        ];
        let functions: Vec<Function> =
            Function::PLAIN.into_iter().chain(of_frames).chain(derivatives).collect();
        check(&device, &model, &functions);
    }
}

/// Compares functions with the expected values of the generated tests.
pub(crate) fn check(device: &Device, model: &Model, functions: &[Function]) {
    let request = Request::new(Target::Wgsl, functions.to_vec())
        .with_arithmetic(Arithmetic::new(Precision::Single))
        .with_name("robot");
    let golden = generate(model, &request).unwrap().file("golden.json").unwrap().text.clone();
    let golden: Value = serde_json::from_str(&golden).unwrap();
    let mut batches = device.compile::<f32>(model, functions).unwrap();
    let mut worst = 0.0_f64;
    for function in functions {
        let values = &golden[function.symbol()];
        let table = |name: &str| -> Vec<f32> {
            let rows = values[name].as_array().unwrap_or_else(|| panic!("{function}: {name}"));
            let numbers = rows.iter().flat_map(|row| row.as_array().unwrap());
            #[allow(clippy::cast_possible_truncation)] // they are singles
            numbers.map(|x| x.as_f64().unwrap() as f32).collect()
        };
        let inputs: Vec<Vec<f32>> = function.reads(model).iter().map(|x| table(x.name)).collect();
        let expected: Vec<Vec<f32>> =
            function.writes(model).iter().map(|x| table(&format!("-> {}", x.name))).collect();
        let mut found: Vec<Vec<f32>> = expected.iter().map(|x| vec![f32::NAN; x.len()]).collect();
        let given: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut asked: Vec<&mut [f32]> = found.iter_mut().map(Vec::as_mut_slice).collect();
        batches.compute(function, &given, &mut asked).unwrap();
        let condition = condition(model, function, &inputs);
        for (found, expected) in found.iter().zip(&expected) {
            let size = expected.iter().fold(1.0_f64, |most, x| most.max(f64::from(x.abs())));
            let allowed = 4.0 * model.nv() as f64 * f64::from(f32::EPSILON) * condition * size;
            for (x, y) in found.iter().zip(expected) {
                let off = f64::from((x - y).abs());
                assert!(off <= allowed, "{function} of {}: {x:e}, not {y:e}, to {allowed:e}", model.name());
                worst = worst.max(off / allowed);
            }
        }
    }
    println!("{}: {} functions, the worst is {worst:e} of what is allowed", model.name(), functions.len());
}

/// κ² of the worst state if a function inverts M, else 1.
fn condition(model: &robot_dynamics::model::Model, function: &Function, inputs: &[Vec<f32>]) -> f64 {
    if !inverts_mass(function) {
        return 1.0;
    }
    let count = inputs[0].len() / model.nq();
    let of = |state: usize| {
        let mut q = robots::row(&inputs[0], count, state);
        robot_dynamics::model::normalize_quaternions(model, &mut q);
        let rest = vec![0.0; model.nv()];
        Bounds::new(model, &q, &rest, &rest).condition
    };
    let worst = (0..count).map(of).fold(1.0, f64::max);
    worst * worst
}

//! Errors and panics of calls that a device refuses.

use std::panic::{AssertUnwindSafe, catch_unwind};

use robot_dynamics::description::{PassiveForces, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{DeviceError, Function, Rollout, RolloutError, RolloutStates, Torques};

use crate::robots;

#[test]
fn missing_functions_and_precisions_are_rejected() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("two_r.urdf");
    match device.compile::<f64>(&model, &[Function::Gravity]) {
        Ok(_) => assert!(crate::is_cuda(), "{} has doubles", device.name()),
        Err(error) => assert!(matches!(error, DeviceError::NoDoubles { .. }) && !crate::is_cuda(), "{error}"),
    }
    let error = device.compile::<f32>(&model, &[Function::FramePose("hand".into())]).unwrap_err();
    let DeviceError::Generate(robot_dynamics_generate::GenerateError::Function(error)) = error else {
        panic!("{error}")
    };
    assert!(matches!(error, robot_dynamics_generate::FunctionError::Input(_)), "{error}");
    let mut batches = device.compile::<f32>(&model, &[Function::Gravity, Function::MassMatrix]).unwrap();
    assert_eq!(batches.functions(), [&Function::Gravity, &Function::MassMatrix]);
    let error = batches.bias(&[0.0; 2], &[0.0; 2], &mut [0.0; 2]).unwrap_err();
    let DeviceError::NotCompiled { function, compiled } = error else { panic!("{error}") };
    assert_eq!((function.as_str(), compiled.as_str()), ("bias", "gravity, mass_matrix"));
    assert!(batches.gravity(&[], &mut []).is_ok(), "an empty batch is valid");
}

#[test]
fn tables_of_wrong_lengths_panic() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("two_r.urdf");
    let mut batches = device.compile::<f32>(&model, &[Function::Bias]).unwrap();
    let mut panic_text = |q: usize, v: usize, out: usize| -> String {
        let (q, v, mut out) = (vec![0.0; q], vec![0.0; v], vec![0.0; out]);
        let panic = catch_unwind(AssertUnwindSafe(|| batches.bias(&q, &v, &mut out))).unwrap_err();
        panic.downcast_ref::<String>().cloned().unwrap_or_default()
    };
    let texts = [panic_text(3, 4, 4), panic_text(4, 2, 4), panic_text(4, 4, 6)];
    insta::assert_snapshot!(texts.join("\n"));
}

#[test]
fn unsupported_rollouts_are_rejected() {
    let Some(device) = crate::device() else { return };
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_damping(0.1);
    let model = Model::new(robot).unwrap();
    let mut batches = device.compile::<f32>(&model, &[Function::Rk4Step]).unwrap();
    let (mut q, mut v) = ([0.5_f32], [0.0_f32]);
    let mut refused = |how: Rollout, torques: Torques<'_, f32>| {
        batches.rollout(&how, torques, RolloutStates::ends(&mut q, &mut v), None).unwrap_err()
    };
    let rk4 = Rollout::new(Integrator::RungeKutta4, 1e-3, 10);
    let error = refused(Rollout::new(Integrator::RungeKutta4, f64::NAN, 10), Torques::Zero);
    assert!(matches!(error, DeviceError::Rollout(RolloutError::Input(_))), "{error}");
    let error = refused(Rollout::new(Integrator::VariationalMidpoint, 1e-3, 10), Torques::Zero);
    let integrator = Integrator::VariationalMidpoint;
    assert!(matches!(error, DeviceError::NoStep { integrator: refused } if refused == integrator), "{error}");
    let error = refused(Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 10), Torques::Zero);
    assert!(matches!(&error, DeviceError::NotCompiled { compiled, .. } if compiled == "rk4_step"), "{error}");
    let error = refused(rk4.with_dissipation(false), Torques::Zero);
    assert!(matches!(error, DeviceError::Dissipation { .. }), "{error}");
    let error = refused(rk4, Torques::Policy(&|_, _| ()));
    assert!(matches!(error, DeviceError::Policy), "{error}");
    assert_eq!((q, v), ([0.5], [0.0]));
    // Without damping or friction both settings give the same motion.
    let undamped = Model::new(pendulum(2.0, 0.5)).unwrap();
    let mut batches = device.compile::<f32>(&undamped, &[Function::Rk4Step]).unwrap();
    let mut ends = [true, false].map(|dissipation| {
        let (mut q, mut v) = ([0.5_f32], [0.0_f32]);
        let how = rk4.with_dissipation(dissipation);
        batches.rollout(&how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None).unwrap();
        (q, v)
    });
    assert_eq!(ends[0], ends[1]);
    ends[0].0[0] = 0.0;
    assert_ne!(ends[0], ends[1]);
}

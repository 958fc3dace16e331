//! What is refused, and in which words.

use dynamics::Integrator;
use gpu::{DeviceError, Function, Rollout, RolloutError, Torques};
use multibody::{Model, PassiveForces, pendulum};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::robots;

fn go_on(_: gpu::RolloutProgress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("two_r.urdf");
    match device.compile::<f64>(&model, &[Function::Gravity]) {
        Ok(_) => assert!(crate::is_cuda(), "{} has doubles", device.name()),
        Err(error) => assert!(matches!(error, DeviceError::NoDoubles { .. }) && !crate::is_cuda(), "{error}"),
    }
    let error = device.compile::<f32>(&model, &[Function::FramePose("hand".into())]).unwrap_err();
    assert!(error.to_string().contains("no frame or link `hand`"), "{error}");
    let mut batches = device.compile::<f32>(&model, &[Function::Gravity, Function::MassMatrix]).unwrap();
    assert_eq!(batches.functions(), [&Function::Gravity, &Function::MassMatrix]);
    let error = batches.bias(&[0.0; 2], &[0.0; 2], &mut [0.0; 2]).unwrap_err();
    let expected = "`bias` is not among the functions compiled for this device: gravity, mass_matrix; name it to \
                    `Device::compile`";
    assert_eq!(error.to_string(), expected);
    assert!(batches.gravity(&[], &mut []).is_ok(), "no states are no error");
}

#[test]
fn tables_of_other_lengths_are_the_callers_fault() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("two_r.urdf");
    let mut batches = device.compile::<f32>(&model, &[Function::Bias]).unwrap();
    let mut said = |q: usize, v: usize, out: usize| -> String {
        let (q, v, mut out) = (vec![0.0; q], vec![0.0; v], vec![0.0; out]);
        let panic = catch_unwind(AssertUnwindSafe(|| batches.bias(&q, &v, &mut out))).unwrap_err();
        panic.downcast_ref::<String>().cloned().unwrap_or_default()
    };
    assert_eq!(said(3, 4, 4), "q has 3 numbers, not a multiple of 2");
    assert_eq!(said(4, 2, 4), "v has 2 numbers, 2 states need 4 (2 each)");
    assert_eq!(said(4, 4, 6), "bias has 6 numbers, 2 states need 4 (2 each)");
}

#[test]
fn rollouts_that_no_device_can_do_are_refused() {
    let Some(device) = crate::device() else { return };
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_damping(0.1);
    let model = Model::new(robot).unwrap();
    let mut batches = device.compile::<f32>(&model, &[Function::Rk4Step]).unwrap();
    let (mut q, mut v) = ([0.5_f32], [0.0_f32]);
    let mut refused = |how: Rollout, torques: Torques<'_, f32>| {
        batches.rollout(&how, torques, &mut q, &mut v, (&mut [], &mut []), &go_on).unwrap_err()
    };
    let rk4 = Rollout::new(Integrator::RungeKutta4, 1e-3, 10);
    let error = refused(Rollout::new(Integrator::RungeKutta4, f64::NAN, 10), Torques::Zero);
    assert!(matches!(error, DeviceError::Rollout(RolloutError::BadStep { .. })), "{error}");
    let error = refused(Rollout::new(Integrator::VariationalMidpoint, 1e-3, 10), Torques::Zero);
    assert!(error.to_string().contains("variational-midpoint"), "{error}");
    let error = refused(Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 10), Torques::Zero);
    assert!(error.to_string().contains("functions compiled for this device: rk4_step;"), "{error}");
    let error = refused(rk4.with_dissipation(false), Torques::Zero);
    assert!(matches!(error, DeviceError::Dissipation { .. }), "{error}");
    let error = refused(rk4, Torques::Policy(&|_, _| ()));
    assert!(matches!(error, DeviceError::Policy), "{error}");
    assert_eq!((q, v), ([0.5], [0.0]));
    // Without damping or friction both settings are the same motion.
    let undamped = Model::new(pendulum(2.0, 0.5)).unwrap();
    let mut batches = device.compile::<f32>(&undamped, &[Function::Rk4Step]).unwrap();
    let mut ends = [true, false].map(|dissipation| {
        let (mut q, mut v) = ([0.5_f32], [0.0_f32]);
        let how = rk4.with_dissipation(dissipation);
        batches.rollout(&how, Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on).unwrap();
        (q, v)
    });
    assert_eq!(ends[0], ends[1]);
    ends[0].0[0] = 0.0;
    assert_ne!(ends[0], ends[1]);
}

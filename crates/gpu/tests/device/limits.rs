//! Batches that exceed the limits of a device.

use robot_dynamics::model::Model;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{Device, DeviceError, Function, Limits, Rollout, RolloutStates, Torques};

use crate::robots::{self, States};

const COUNT: usize = 1000;

/// M, and the end of a rollout with its trajectory.
fn compute(device: &Device, model: &Model) -> [Vec<f32>; 5] {
    let states = States::random(model, COUNT, 5);
    let functions = [Function::MassMatrix, Function::SemiImplicitEulerStep];
    let mut batches = device.compile::<f32>(model, &functions).unwrap();
    let (nq, nv) = (model.nq(), model.nv());
    let mut mass = vec![f32::NAN; COUNT * nv * nv];
    batches.mass_matrix(&states.q, &mut mass).unwrap();
    let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 70).with_stride(20);
    let (mut q, mut v) = (states.q.clone(), states.v.clone());
    let mut tau = Vec::new();
    for step in 0..how.steps {
        tau.extend(states.tau.iter().map(|tau| tau * step as f32 * 0.01));
    }
    let mut trajectory = (vec![f32::NAN; COUNT * 3 * nq], vec![f32::NAN; COUNT * 3 * nv]);
    let tables = (&mut trajectory.0[..], &mut trajectory.1[..]);
    batches
        .rollout(
            &how,
            Torques::EachStep(&tau),
            RolloutStates { q: &mut q, v: &mut v, q_trajectory: tables.0, v_trajectory: tables.1 },
            None,
        )
        .unwrap();
    [mass, q, v, trajectory.0, trajectory.1]
}

/// Tables that hold a few dozen states, and launches of one and of three workgroups, give the same bits as
/// one launch.
#[test]
fn a_batch_beyond_the_limits_is_split() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("gripper.urdf");
    let whole = compute(&device, &model);
    assert!(whole.iter().flatten().all(|x| x.is_finite()));
    let width = model.nv() * model.nv() * 4;
    for limits in [
        Limits::default().with_table_bytes(37 * width as u64),
        Limits::default().with_launch_states(64),
        Limits::default().with_launch_states(200).with_table_bytes(150 * width as u64),
    ] {
        let small = crate::open_with(limits).unwrap();
        assert!(compute(&small, &model) == whole, "{limits:?}");
    }
}

/// A device with tables smaller than one state reports both sizes.
#[test]
fn a_state_that_is_too_large_is_rejected() {
    if crate::device().is_none() {
        return;
    }
    let model = robots::named("panda.urdf");
    let small = crate::open_with(Limits::default().with_table_bytes(100)).unwrap();
    let mut batches = small.compile::<f32>(&model, &[Function::MassMatrix]).unwrap();
    let error = batches.mass_matrix(&[0.0; 7], &mut [0.0; 49]).unwrap_err();
    assert!(matches!(error, DeviceError::TooLarge { bytes: 196, most: 100, .. }), "{error}");
}

/// Buffers of one call are reused by the next, whatever its function and size: the results are those of new
/// buffers.
#[test]
fn buffers_are_reused() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("three_r.urdf");
    let functions = [Function::MassMatrix, Function::Gravity, Function::SemiImplicitEulerStep];
    let mut used = device.compile::<f32>(&model, &functions).unwrap();
    for (seed, count) in [100, 7, 1000, 64, 1].into_iter().enumerate() {
        let mut fresh = device.compile::<f32>(&model, &functions).unwrap();
        let states = States::random(&model, count, seed as u64);
        let both = [&mut used, &mut fresh].map(|batches| {
            let (mut mass, mut gravity) = (vec![f32::NAN; count * 9], vec![f32::NAN; count * 3]);
            batches.mass_matrix(&states.q, &mut mass).unwrap();
            batches.gravity(&states.q, &mut gravity).unwrap();
            let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 5).with_stride(1);
            let (mut q, mut v) = (states.q.clone(), states.v.clone());
            let mut trajectory = [(); 2].map(|()| vec![f32::NAN; count * 15]);
            let [of_q, of_v] = &mut trajectory;
            batches
                .rollout(
                    &how,
                    Torques::Held(&states.tau),
                    RolloutStates { q: &mut q, v: &mut v, q_trajectory: of_q, v_trajectory: of_v },
                    None,
                )
                .unwrap();
            (mass, gravity, q, v, trajectory)
        });
        assert!(both[0] == both[1], "{count} states");
    }
}

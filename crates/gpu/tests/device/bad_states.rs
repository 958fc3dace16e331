//! States without a valid result are named, have NaN, and do not affect others.

use robot_dynamics::batch;
use robot_dynamics::batch::BatchWorkspace;
use robot_dynamics::description::JointKind;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{DeviceError, Function, Rollout, RolloutStates, Torques};

use crate::robots::{self, States};

/// The states that an error names.
fn named(result: Result<(), DeviceError>) -> Vec<usize> {
    match result {
        Ok(()) => Vec::new(),
        Err(DeviceError::BadStates(bad)) => bad.states,
        Err(other) => panic!("{other}"),
    }
}

/// NaN, infinity, and zero quaternions. The same states are named as on the CPU. All of their results are
/// NaN, and all others keep their bits. An angle beyond the range of the device's sine is another case.
#[test]
fn bad_states_are_those_of_the_cpu_and_affect_no_other() {
    let Some(device) = crate::device() else { return };
    let model = robots::with_ball();
    let (nq, nv, count) = (model.nq(), model.nv(), 100);
    let good = States::random(&model, count, 1);
    let mut invalid = States::random(&model, count, 1);
    invalid.q[3 * nq] = f32::NAN;
    invalid.q[99 * nq] = f32::NEG_INFINITY;
    invalid.q[12 * nq + 3..12 * nq + 7].fill(0.0); // the base's quaternion
    let ball = model.joints().iter().find(|joint| joint.kind == JointKind::Spherical).unwrap();
    invalid.q[13 * nq + ball.q_index..][..4].fill(0.0);
    invalid.v[20 * nv + 2] = f32::NAN;
    invalid.a[21 * nv + 1] = f32::INFINITY;
    let mut batches = device.compile::<f32>(&model, &[Function::InverseDynamics]).unwrap();
    let mut expected = vec![0.0; count * nv];
    batches.inverse_dynamics(&good.q, &good.v, &good.a, &mut expected).unwrap();
    let (mut found, mut on_processor) = (expected.clone(), expected.clone());
    let bad = named(batches.inverse_dynamics(&invalid.q, &invalid.v, &invalid.a, &mut found));
    let mut workspace = BatchWorkspace::<f32>::new(&model);
    let there = batch::inverse_dynamics(
        &model,
        &mut workspace,
        &invalid.q,
        &invalid.v,
        &invalid.a,
        &mut on_processor,
    );
    assert_eq!(bad, there.unwrap_err().states);
    assert_eq!(bad, [3, 12, 13, 20, 21, 99]);
    for (state, (found, expected)) in found.chunks(nv).zip(expected.chunks(nv)).enumerate() {
        if bad.contains(&state) {
            assert!(found.iter().all(|x| x.is_nan()), "state {state}");
        } else {
            assert_eq!(found, expected, "state {state}");
        }
    }
}

/// Angles are limited to 8192 rad, those of mimic joints too; lengths are unlimited.
#[test]
fn angles_beyond_the_sines_range_are_named() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("gripper.urdf");
    let joints = model.joints();
    let hinge = joints.iter().find(|joint| matches!(joint.kind, JointKind::Revolute { .. })).unwrap();
    // A wheel that rotates by 20 rad for each metre of the jaw.
    let wheel =
        joints.iter().find(|joint| joint.mimic.as_ref().is_some_and(|mimic| mimic.ratio == 20.0)).unwrap();
    let leader = &wheel.mimic.as_ref().unwrap().joint;
    let jaw = joints.iter().find(|joint| joint.name == *leader).unwrap();
    assert!(
        matches!(jaw.kind, JointKind::Prismatic { .. }) && matches!(wheel.kind, JointKind::Revolute { .. })
    );
    let nq = model.nq();
    let mut q = vec![0.25_f32; 6 * nq];
    for (state, joint, x) in
        [(0, hinge, 8191.0), (1, hinge, 8193.0), (2, hinge, -9000.0), (3, jaw, 400.0), (4, jaw, 410.0)]
    {
        q[state * nq + joint.q_index] = x;
    }
    let mut batches = device.compile::<f32>(&model, &[Function::Gravity]).unwrap();
    let mut g = vec![0.0; 6 * model.nv()];
    assert_eq!(named(batches.gravity(&q, &mut g)), [1, 2, 4]);
    for (state, g) in g.chunks(model.nv()).enumerate() {
        assert!(g.iter().all(|x| x.is_nan() == [1, 2, 4].contains(&state)), "state {state}");
    }
}

/// A rollout names the states that are invalid at its start and those that become so, like the CPU's rollout.
#[test]
fn a_rollout_names_bad_states_at_its_end() {
    let Some(device) = crate::device() else { return };
    let model: Model = robots::named("two_r.urdf");
    let count = 10;
    let states = States::random(&model, count, 2);
    let mut batches = device.compile::<f32>(&model, &[Function::SemiImplicitEulerStep]).unwrap();
    let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-2, 100);
    let (mut q, mut v, mut tau) = (states.q.clone(), states.v.clone(), vec![0.0; count * 2]);
    v[3 * 2] = f32::NAN;
    tau[5 * 2 + 1] = f32::INFINITY;
    tau[7 * 2] = 3e38; // finite, and its results soon are not
    let (mut q_there, mut v_there) = (q.clone(), v.clone());
    let bad = named(batches.rollout(&how, Torques::Held(&tau), RolloutStates::ends(&mut q, &mut v), None));
    assert_eq!(bad, [3, 5, 7]);
    let there = robots::roll_out_on_cpu(&model, &how, &tau, &mut q_there, &mut v_there);
    assert!(matches!(there, Err(batch::RolloutError::BadStates(there)) if there.states == bad));
    for (state, (q, v)) in q.chunks(2).zip(v.chunks(2)).enumerate() {
        let all = |is: fn(&f32) -> bool| q.iter().chain(v).all(is);
        assert!(if bad.contains(&state) { all(|x| x.is_nan()) } else { all(|x| x.is_finite()) }, "{state}");
    }
}

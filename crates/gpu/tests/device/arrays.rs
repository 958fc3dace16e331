//! Functions and rollouts on arrays of the device.

use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{DeviceArray, DeviceError, Function, Limits, Rollout, RolloutStates, Torques};

use crate::robots::{self, States};

const COUNT: usize = 70;

fn read(array: &DeviceArray<f32>) -> Vec<f32> {
    let mut numbers = vec![f32::NAN; array.len()];
    array.read(&mut numbers).unwrap();
    numbers
}

/// The kernels are those of tables on the host, so the results have the same bits.
#[test]
fn functions_have_the_bits_of_tables_on_the_host() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("panda.urdf");
    let functions = [Function::InverseDynamics, Function::ForwardDynamicsPullback];
    let mut batches = device.compile::<f32>(&model, &functions).unwrap();
    let states = States::random(&model, COUNT, 3);
    let [q, v, a] = [&states.q, &states.v, &states.a].map(|rows| device.array(rows).unwrap());
    let mut tau = vec![f32::NAN; COUNT * model.nv()];
    batches.inverse_dynamics(&states.q, &states.v, &states.a, &mut tau).unwrap();
    let mut found = device.array(&vec![0.0_f32; tau.len()]).unwrap();
    batches.compute_arrays(&functions[0], &[&q, &v, &a], &mut [&mut found]).unwrap();
    assert_eq!(read(&found), tau);
    // The torques stay on the device as an argument; λ = v.
    let mut expected = [(); 4].map(|()| vec![f32::NAN; tau.len()]);
    let mut tables: Vec<&mut [f32]> = expected.iter_mut().map(Vec::as_mut_slice).collect();
    batches.compute(&functions[1], &[&states.q, &states.v, &tau, &states.v], &mut tables).unwrap();
    let mut results = [(); 4].map(|()| device.array(&vec![0.0_f32; tau.len()]).unwrap());
    let mut written: Vec<&mut DeviceArray<f32>> = results.iter_mut().collect();
    batches.compute_arrays(&functions[1], &[&q, &v, &found, &v], &mut written).unwrap();
    assert!(results.iter().map(read).eq(expected));
}

#[test]
fn rollouts_have_the_bits_of_tables_on_the_host() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("quadruped.urdf");
    let step = Function::SemiImplicitEulerStep;
    let mut batches = device.compile::<f32>(&model, core::slice::from_ref(&step)).unwrap();
    let states = States::random(&model, COUNT, 3);
    let tau = device.array(&states.tau).unwrap();
    let h = device.array(&[1e-3_f32; COUNT]).unwrap();
    for steps in [1, 2, 67] {
        let (mut q_host, mut v_host) = (states.q.clone(), states.v.clone());
        let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, steps);
        let ends = RolloutStates::ends(&mut q_host, &mut v_host);
        batches.rollout(&how, Torques::Held(&states.tau), ends, None).unwrap();
        let (mut q, mut v) = (device.array(&states.q).unwrap(), device.array(&states.v).unwrap());
        batches.rollout_arrays(&step, steps, &mut [&mut q, &mut v], &[&tau, &h]).unwrap();
        assert!(read(&q) == q_host && read(&v) == v_host, "{steps} steps");
    }
}

#[test]
fn wrong_arrays_are_errors() {
    let Some(device) = crate::device() else { return };
    let model = robots::named("two_r.urdf");
    let functions = [Function::Bias, Function::Rk4Step];
    let mut batches = device.compile::<f32>(&model, &functions).unwrap();
    let array = |count: usize| device.array(&vec![0.0_f32; count]).unwrap();
    let (q, short, none) = (array(4), array(3), array(0));
    let mut out = array(4);
    let mut refused = |inputs: &[&DeviceArray<f32>], out: &mut DeviceArray<f32>| {
        batches.compute_arrays(&functions[0], inputs, &mut [out]).unwrap_err()
    };
    for inputs in [&[&q, &short][..], &[&q], &[&q, &none]] {
        let error = refused(inputs, &mut out);
        assert!(matches!(error, DeviceError::Tables { .. }), "{error}");
    }
    let error = batches.rollout_arrays(&functions[0], 1, &mut [&mut out], &[&q]).unwrap_err();
    assert!(matches!(error, DeviceError::Tables { .. }), "{error}");
    let mut empty = array(0);
    batches.compute_arrays(&functions[0], &[&none, &none], &mut [&mut empty]).unwrap();
    // The same driver opened twice is another device.
    let other = crate::open_with(Limits::default()).unwrap();
    let foreign = other.array(&[0.0_f32; 4]).unwrap();
    let error = batches.compute_arrays(&functions[0], &[&q, &foreign], &mut [&mut out]).unwrap_err();
    assert!(matches!(error, DeviceError::Tables { .. }), "{error}");
}

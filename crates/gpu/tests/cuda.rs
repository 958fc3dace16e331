//! Without CUDA, opening a device is a typed error. With a device, `tests/device` can run on it.
#![cfg(feature = "cuda")]

use robot_dynamics::description::pendulum;
use robot_dynamics::model::Model;
use robot_dynamics_gpu::{Device, DeviceError, Function, Limits};

/// Without the libraries no device opens; with them, gravity of a pendulum is computed in both precisions.
#[test]
fn a_missing_device_is_a_typed_error_and_a_present_one_computes() {
    let device = match Device::open_cuda(0, Limits::default()) {
        Ok(device) => device,
        Err(error) => {
            assert!(matches!(error, DeviceError::NoCuda { .. }), "{error}");
            println!("left out: {error}");
            return;
        }
    };
    let model = Model::new(pendulum(2.0, 0.5)).unwrap();
    let mut g = [f64::NAN; 1000];
    device.compile::<f64>(&model, &[Function::Gravity]).unwrap().gravity(&[0.0; 1000], &mut g).unwrap();
    assert!(g.iter().all(|g| (g + 9.81).abs() < 1e-13));
    let mut g = [f32::NAN; 1000];
    device.compile::<f32>(&model, &[Function::Gravity]).unwrap().gravity(&[0.0; 1000], &mut g).unwrap();
    assert!(g.iter().all(|g| (g + 9.81).abs() < 1e-5));
}

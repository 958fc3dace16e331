//! Comparison of a device's results with the library's doubles on the CPU.
//!
//! If no device is found the tests are left out, unless `ROBOT_DYNAMICS_DEVICE` announces one, as
//! `cargo xtask test gpu` does. With the value `cuda` they run on a CUDA device.
#![cfg(feature = "wgpu")]

mod arrays;
mod bad_states;
mod bounds;
mod contact;
mod doubles;
mod errors;
mod functions;
mod limits;
mod messages;
mod robots;
mod rollouts;
mod values;

use std::sync::OnceLock;

use robot_dynamics_gpu::{Device, DeviceError, Limits};

/// The environment variable for the expected device.
const EXPECTED: &str = "ROBOT_DYNAMICS_DEVICE";

/// Whether the tests run on a CUDA device, which supports doubles.
fn is_cuda() -> bool {
    std::env::var_os(EXPECTED).is_some_and(|name| name == "cuda")
}

/// Opens a device with these limits.
fn open_with(limits: Limits) -> Result<Device, DeviceError> {
    if !is_cuda() {
        return Device::open_with(limits);
    }
    #[cfg(feature = "cuda")]
    return Device::open_cuda(0, limits);
    #[cfg(not(feature = "cuda"))]
    panic!("these tests were compiled without the feature `cuda`");
}

/// The first device; `None` on a machine without one, unless the tests expect one.
fn device() -> Option<Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match open_with(Limits::default()) {
        Ok(device) => {
            println!("on {}", device.name());
            Some(device)
        }
        Err(error) => {
            assert!(std::env::var_os(EXPECTED).is_none(), "a device is expected: {error}");
            println!("left out: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).clone()
}

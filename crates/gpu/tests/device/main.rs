//! What a device computes, against the library's doubles on the processor.
//!
//! Where no device is found the tests pass over, unless `ROBOT_DYNAMICS_DEVICE` says that one is expected, as
//! `cargo xtask test gpu` does. If it says `cuda`, that is what they run on.
#![cfg(feature = "wgpu")]

mod bad_states;
mod bounds;
mod doubles;
mod errors;
mod functions;
mod limits;
mod robots;
mod rollouts;
mod values;

use std::sync::OnceLock;

use gpu::{Device, DeviceError, Limits};

/// What the environment says of the device that is expected.
const EXPECTED: &str = "ROBOT_DYNAMICS_DEVICE";

/// Whether the tests run on a device by CUDA, which has doubles.
fn is_cuda() -> bool {
    std::env::var_os(EXPECTED).is_some_and(|name| name == "cuda")
}

/// A device of which so much is taken.
fn open_with(limits: Limits) -> Result<Device, DeviceError> {
    if !is_cuda() {
        return Device::open_with(limits);
    }
    #[cfg(feature = "cuda")]
    return Device::open_cuda(0, limits);
    #[cfg(not(feature = "cuda"))]
    panic!("these tests were compiled without the feature `cuda`");
}

/// The first device; none where there is none and none is expected.
fn device() -> Option<Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match open_with(Limits::default()) {
        Ok(device) => {
            println!("on {}", device.name());
            Some(device)
        }
        Err(error) => {
            assert!(std::env::var_os(EXPECTED).is_none(), "a device is expected: {error}");
            println!("passed over: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).clone()
}

//! What a device computes, against the library's doubles on the processor.
//!
//! Where no device is found the tests pass over, unless `ROBOT_DYNAMICS_DEVICE` says that one is expected, as
//! `cargo xtask test gpu` does.
#![cfg(feature = "wgpu")]

mod bad_states;
mod bounds;
mod errors;
mod functions;
mod limits;
mod robots;
mod rollouts;
mod values;

use std::sync::OnceLock;

use gpu::Device;

/// The first device; none where there is none and none is expected.
fn device() -> Option<Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match Device::open() {
        Ok(device) => {
            println!("on {}", device.name());
            Some(device)
        }
        Err(error) => {
            assert!(std::env::var_os("ROBOT_DYNAMICS_DEVICE").is_none(), "a device is expected: {error}");
            println!("passed over: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).clone()
}

//! The texts of errors.

use std::fmt::Write;

use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::DeviceError;

#[test]
fn errors() {
    let device = || "llvmpipe, vulkan".to_owned();
    let errors = [
        DeviceError::NoDevice { cause: "no adapter".into() },
        DeviceError::NoCuda { cause: "device 0: invalid ordinal".into() },
        DeviceError::Closed { device: device(), cause: "too many buffers".into() },
        DeviceError::NoDoubles { device: device() },
        DeviceError::Refused {
            device: device(),
            function: "gravity".into(),
            robot: "arm".into(),
            cause: "line 3".into(),
        },
        DeviceError::NotCompiled { function: "bias".into(), compiled: "gravity, mass_matrix".into() },
        DeviceError::NoPointers { device: device() },
        DeviceError::Tables { function: "bias".into(), cause: "v has 3 numbers, expected 4".into() },
        DeviceError::TooLarge { device: device(), function: "mass_matrix".into(), bytes: 196, most: 100 },
        DeviceError::Failed { device: device(), cause: "out of memory".into() },
        DeviceError::NoStep { integrator: Integrator::VariationalMidpoint },
        DeviceError::Policy,
        DeviceError::Dissipation { robot: "arm".into() },
    ];
    let mut text = String::new();
    for error in errors {
        let _ = writeln!(text, "{error}");
    }
    insta::assert_snapshot!(text);
}

//! What can go wrong on a device.

use dynamics::Integrator;
use generate::GenerateError;
use multibody::batch::{BadStates, RolloutError};
use thiserror::Error;

/// What can go wrong on a device.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no device that wgpu finds.
    #[error(
        "no device to compute on: {cause}; install a driver with Vulkan (on Debian that of the graphics card, or \
         mesa-vulkan-drivers, which computes on the processor), or run where there is Metal or DirectX 12"
    )]
    NoDevice {
        /// What was found.
        cause: String,
    },
    /// There is no device that CUDA finds.
    #[error(
        "no CUDA device: {cause}; it takes an NVIDIA card, its driver (libcuda) and the run-time compiler of the CUDA \
         toolkit (libnvrtc) where the system looks for libraries"
    )]
    NoCuda {
        /// What is missing.
        cause: String,
    },
    /// The device does not open with what is asked for.
    #[error("`{device}` does not open: {cause}")]
    Closed {
        /// The device.
        device: String,
        /// What it says.
        cause: String,
    },
    /// The robot's code cannot be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The device has no doubles.
    #[error("`{device}` computes in single precision alone: compile for f32, or open a CUDA device")]
    NoDoubles {
        /// The device.
        device: String,
    },
    /// The device's compiler refuses the code.
    #[error("`{device}` does not compile `{function}` of robot `{robot}`: {cause}")]
    Refused {
        /// The device.
        device: String,
        /// The function.
        function: String,
        /// The robot.
        robot: String,
        /// What the compiler says.
        cause: String,
    },
    /// A function that was not compiled.
    #[error(
        "`{function}` is not among the functions compiled for this device: {compiled}; name it to `Device::compile`"
    )]
    NotCompiled {
        /// The one asked for.
        function: String,
        /// Those that were.
        compiled: String,
    },
    /// One state's numbers are more than the device takes.
    #[error("one state of `{function}` has {bytes} bytes in a table, `{device}` takes {most}")]
    TooLarge {
        /// The device.
        device: String,
        /// The function.
        function: String,
        /// Bytes of one state in the widest table.
        bytes: usize,
        /// What the device takes.
        most: usize,
    },
    /// The device has no memory left, or lost what it had.
    #[error("`{device}` fails: {cause}")]
    Failed {
        /// The device.
        device: String,
        /// What it says.
        cause: String,
    },
    /// Some states of a batch have no valid result; those of all others are valid.
    #[error(
        "{0}; on a device an angle beyond the range of its sine, 8192 rad in f32 and 1e5 rad in f64, counts as such"
    )]
    BadStates(#[from] BadStates),
    /// Some states have not come to the end of a rollout.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// A row of the table of integrators whose steps are not generated.
    #[error(
        "steps of {integrator} are not generated; a rollout on a device moves by semi-implicit-euler or rk4"
    )]
    NoStep {
        /// The one asked for.
        integrator: Integrator,
    },
    /// A feedback law in Rust.
    #[error(
        "a policy computes on the processor, and a rollout stays on the device: give torques of each step, or roll out \
         with `multibody::batch`"
    )]
    Policy,
    /// A rollout without the damping and friction that the robot has.
    #[error(
        "robot `{robot}` has damping or friction, which steps on a device always have: roll out with dissipation, or \
         compile the robot from a description without them"
    )]
    Dissipation {
        /// The robot.
        robot: String,
    },
}

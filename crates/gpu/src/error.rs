//! Errors of computations on a device.

use robot_dynamics::batch::{BadStates, RolloutError};
use robot_dynamics::simulation::Integrator;
use robot_dynamics::{Classified, ErrorKind};
use robot_dynamics_generate::GenerateError;
use thiserror::Error;

/// The error of opening a device, of compiling a robot for it, and of each computation on it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// wgpu finds no device.
    #[error(
        "no device found: {cause}; install a driver with Vulkan (on Debian that of the graphics card, or \
         mesa-vulkan-drivers, which computes on the CPU), or use a system with Metal or DirectX 12"
    )]
    NoDevice {
        /// The message of wgpu.
        cause: String,
    },
    /// CUDA finds no device.
    #[error(
        "no CUDA device: {cause}; CUDA needs an NVIDIA card, its driver (libcuda) and the run-time compiler NVRTC \
         (libnvrtc of the CUDA toolkit, or of NVIDIA's wheel nvidia-cuda-nvrtc)"
    )]
    NoCuda {
        /// The missing component.
        cause: String,
    },
    /// The device cannot be opened.
    #[error("cannot open `{device}`: {cause}")]
    Closed {
        /// The device.
        device: String,
        /// Its message.
        cause: String,
    },
    /// The robot's code cannot be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The device does not support double precision.
    #[error("`{device}` supports only single precision: compile for f32, or open a CUDA device")]
    NoDoubles {
        /// The device.
        device: String,
    },
    /// The device's compiler rejects the code.
    #[error("`{device}` cannot compile `{function}` of robot `{robot}`: {cause}")]
    Refused {
        /// The device.
        device: String,
        /// The function.
        function: String,
        /// The robot.
        robot: String,
        /// The message of the compiler.
        cause: String,
    },
    /// The function was not compiled.
    #[error(
        "`{function}` is not among the functions compiled for this device: {compiled}; pass it to `Device::compile`"
    )]
    NotCompiled {
        /// The requested one.
        function: String,
        /// The compiled functions.
        compiled: String,
    },
    /// The device does not compute on memory of the caller.
    #[error("`{device}` does not compute on memory of the caller: open a CUDA device")]
    NoPointers {
        /// The device.
        device: String,
    },
    /// A table in memory of the caller does not fit the function.
    #[error("`{function}`: {cause}")]
    Tables {
        /// The function.
        function: String,
        /// The table, and what it must be.
        cause: String,
    },
    /// One state is larger than the largest table of the device.
    #[error("one state of `{function}` needs a table of {bytes} bytes, but `{device}` supports {most}")]
    TooLarge {
        /// The device.
        device: String,
        /// The function.
        function: String,
        /// Bytes of one state in the widest table.
        bytes: usize,
        /// The limit of the device.
        most: usize,
    },
    /// The device has no memory left, or was lost.
    #[error("`{device}` failed: {cause}")]
    Failed {
        /// The device.
        device: String,
        /// Its message.
        cause: String,
    },
    /// Some states of a batch have no valid result; those of all others are valid.
    #[error(
        "{0}; on a device this includes states with an angle beyond the range of its sine, 8192 rad in f32 and 1e5 rad in f64"
    )]
    BadStates(#[from] BadStates),
    /// Some states have not reached the end of a rollout.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// Steps of the integrator are not generated.
    #[error(
        "a rollout on a device does not support the integrator {integrator}; use semi-implicit-euler or rk4"
    )]
    NoStep {
        /// The requested one.
        integrator: Integrator,
    },
    /// The torques are a feedback law in Rust.
    #[error(
        "a rollout on a device does not support a policy, which runs on the CPU: pass the torques of each step, or use \
         `robot_dynamics::batch`"
    )]
    Policy,
    /// The rollout excludes the damping and friction of the robot.
    #[error(
        "robot `{robot}` has damping or friction, which steps on a device always include: enable dissipation, or \
         compile the robot from a description without them"
    )]
    Dissipation {
        /// The robot.
        robot: String,
    },
}

impl Classified for DeviceError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Generate(error) => error.kind(),
            Self::BadStates(error) => error.kind(),
            Self::Rollout(error) => error.kind(),
            Self::NoDevice { .. }
            | Self::NoCuda { .. }
            | Self::Closed { .. }
            | Self::Refused { .. }
            | Self::Failed { .. } => ErrorKind::System,
            Self::NotCompiled { .. } => ErrorKind::UnknownName,
            Self::Tables { .. } => ErrorKind::InvalidInput,
            Self::NoDoubles { .. }
            | Self::NoPointers { .. }
            | Self::TooLarge { .. }
            | Self::NoStep { .. }
            | Self::Policy
            | Self::Dissipation { .. } => ErrorKind::Unsupported,
        }
    }
}

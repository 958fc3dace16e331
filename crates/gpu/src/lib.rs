//! Batches of robot dynamics on a graphics processor, with one thread for each state.
//!
//! The crate `generate` writes a robot's equations as straight-line code. A device compiles that code and
//! runs it on many states. Tables and errors are those of [`robot_dynamics::batch`], which computes the same
//! on the CPU's cores.
//!
//! | device | opened by | feature | numbers | tested on |
//! | --- | --- | --- | --- | --- |
//! | with Vulkan, Metal or DirectX 12 | `Device::open` | `wgpu`, on by default | `f32` | Mesa's lavapipe, a Vulkan driver for the CPU, and an NVIDIA H100 |
//! | NVIDIA's, by CUDA and its run-time compiler | `Device::open_cuda` | `cuda` | `f32`, `f64` | H100 |
//!
//! ```
//! # std::env::set_current_dir("../..")?;
//! use robot_dynamics_gpu::{Device, Function};
//! let model = robot_dynamics::load("robots/panda.urdf")?.model;
//! # let Ok(device) = Device::open() else { return Ok(()) }; // no device
//! # /*
//! let device = Device::open()?; // its error says what to install
//! # */
//! let mut pandas = device.compile::<f32>(&model, &[Function::InverseDynamics])?;
//! let q = vec![0.5; 100_000 * model.nq()];
//! let (v, a) = (vec![0.0; 100_000 * model.nv()], vec![0.0; 100_000 * model.nv()]);
//! let mut tau = v.clone();
//! pandas.inverse_dynamics(&q, &v, &a, &mut tau)?; // torques that hold each one still
//! assert!(tau[1].abs() > 10.0 && tau[..7] == tau[99_999 * 7..]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The accuracy of singles: errors are some hundred roundings, 6e-8 each, of the largest intermediate number,
//! and κ(M) times that where M is inverted. A device may fuse products with sums, and its quotients and roots
//! may have errors of 2.5 units in the last place.

#[cfg(not(any(feature = "wgpu", feature = "cuda")))]
compile_error!("no backend is enabled: enable the feature `wgpu` or `cuda`");

// Errors,
mod error;

// numbers and robots,
mod float;
mod robot;

// devices,
mod backend;
mod limits;

// data on a device,
mod device_array;
#[cfg(feature = "cuda")]
mod pointer_calls;

// functions and rollouts on any device,
mod compilation;
mod machine;
mod rollout;

// the same on arrays of the device,
mod array_calls;
mod step_tables;

// on memory of the caller,
#[cfg(feature = "cuda")]
mod caller_memory;

// and the public interface.
mod batches;
mod device;

#[cfg(feature = "cuda")]
pub use backend::cuda::{CallerStream, DevicePointer};
pub use batches::Batches;
#[cfg(feature = "cuda")]
pub use device::Device;
pub use device_array::DeviceArray;
pub use error::DeviceError;
pub use float::DeviceFloat;
pub use limits::Limits;
#[cfg(feature = "cuda")]
pub use pointer_calls::{DeviceRollout, TableOrder};
pub use robot_dynamics::batch::{
    BadStates, Rollout, RolloutError, RolloutObserver, RolloutProgress, RolloutStates, Torques,
};
pub use robot_dynamics_generate::Function;

/// The examples of the README.
#[cfg(all(doctest, feature = "wgpu"))]
#[doc = include_str!("../README.md")]
struct Readme;

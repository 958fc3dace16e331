//! Batches of robot dynamics on a graphics processor: a thread a state.
//!
//! The crate `generate` writes a robot's equations as straight-line code; here a device compiles that code and runs it on many
//! states. Tables and errors are those of [`multibody::batch`], which computes the same on the processor's cores.
//!
//! | device | opened by | feature | numbers | tried |
//! | --- | --- | --- | --- | --- |
//! | with Vulkan, Metal or DirectX 12 | `Device::open` | `wgpu`, on by default | `f32` | on Mesa's lavapipe, a Vulkan of the processor's, and on an NVIDIA H100 |
//! | NVIDIA's, by CUDA and its run-time compiler | `Device::open_cuda` | `cuda` | `f32`, `f64` | on an H100 |
//!
//! ```
//! # std::env::set_current_dir("../..")?;
//! use gpu::{Device, Function};
//! let model = robot_dynamics::load("robots/panda.urdf")?.model;
//! # let Ok(device) = Device::open() else { return Ok(()) }; // none here
//! # /*
//! let device = Device::open()?; // its error says what to install
//! # */
//! let mut pandas = device.compile::<f32>(&model, &[Function::InverseDynamics])?;
//! let q = vec![0.5; 100_000 * model.nq()];
//! let (v, a) = (vec![0.0; 100_000 * model.nv()], vec![0.0; 100_000 * model.nv()]);
//! let mut tau = v.clone();
//! pandas.inverse_dynamics(&q, &v, &a, &mut tau)?; // what holds each one still
//! assert!(tau[1].abs() > 10.0 && tau[..7] == tau[99_999 * 7..]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What to expect of singles: results are off by some hundred roundings of 6e-8 of the largest number on the way, and κ(M) times that
//! where M is inverted. A device may fuse products with sums, and divide and take roots with an error of 2.5 units in the last place.

#[cfg(not(any(feature = "wgpu", feature = "cuda")))]
compile_error!("there is no way to a device: turn on the feature `wgpu` or `cuda`");

// What goes wrong,
mod error;

// what is computed with, and of which robot,
mod float;
mod robot;

// what a device can,
mod backend;

// functions and rollouts on any,
mod machine;
mod rollout;

// and what a caller sees.
mod batches;
mod device;

pub use batches::Batches;
pub use device::{Device, Limits};
pub use error::DeviceError;
pub use float::DeviceFloat;
pub use generate::Function;
pub use multibody::batch::{BadStates, Rollout, RolloutError, RolloutProgress, Torques};

/// The examples of the README.
#[cfg(all(doctest, feature = "wgpu"))]
#[doc = include_str!("../README.md")]
struct Readme;

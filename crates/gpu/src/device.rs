//! Devices, and how much of one is taken.

use std::sync::Arc;

use generate::Function;
use multibody::Model;

use crate::machine::Machine;
use crate::{Batches, DeviceError, DeviceFloat};

/// How much of a device is taken, if less than it has: batches beyond are computed in several launches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of the largest table.
    pub table_bytes: Option<u64>,
    /// States of one launch.
    pub launch_states: Option<usize>,
}

impl Limits {
    /// With tables of so many bytes at most.
    ///
    /// ```
    /// assert_eq!(gpu::Limits::default().with_table_bytes(1 << 20).table_bytes, Some(1 << 20));
    /// ```
    pub const fn with_table_bytes(self, bytes: u64) -> Self {
        Self { table_bytes: Some(bytes), ..self }
    }

    /// With launches of so many states at most: a multiple of 64 by wgpu, rounded down.
    ///
    /// ```
    /// assert_eq!(gpu::Limits::default().with_launch_states(640).launch_states, Some(640));
    /// ```
    pub const fn with_launch_states(self, states: usize) -> Self {
        Self { launch_states: Some(states), ..self }
    }
}

/// A device that computes batches.
#[derive(Clone)]
pub struct Device(Kind);

#[derive(Clone)]
enum Kind {
    #[cfg(feature = "wgpu")]
    Wgpu(Arc<crate::backend::wgpu::Wgpu>),
    #[cfg(feature = "cuda")]
    Cuda(Arc<crate::backend::cuda::Cuda>),
}

/// Does the same with any device.
macro_rules! with {
    ($device:expr, $backend:ident => $result:expr) => {
        match $device.0 {
            #[cfg(feature = "wgpu")]
            Kind::Wgpu(ref $backend) => $result,
            #[cfg(feature = "cuda")]
            Kind::Cuda(ref $backend) => $result,
        }
    };
}

impl Device {
    /// The first device with Vulkan, Metal or DirectX 12, a graphics processor where there is a choice. It computes in `f32`.
    ///
    /// The environment variables of the driver hold, as Vulkan's `VK_DRIVER_FILES`.
    ///
    /// ```
    /// match gpu::Device::open() {
    ///     Ok(device) => println!("{}", device.name()),
    ///     Err(error) => assert!(error.to_string().contains("install a driver")), // or `Closed`, by one that is there
    /// }
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::NoDevice`] where there is none, with what to install; [`DeviceError::Closed`] where it is refused.
    #[cfg(feature = "wgpu")]
    pub fn open() -> Result<Self, DeviceError> {
        Self::open_with(Limits::default())
    }

    /// As [`Device::open`], within these limits.
    ///
    /// # Errors
    /// As [`Device::open`].
    #[cfg(feature = "wgpu")]
    pub fn open_with(limits: Limits) -> Result<Self, DeviceError> {
        Ok(Self(Kind::Wgpu(Arc::new(crate::backend::wgpu::Wgpu::open(limits)?))))
    }

    /// A CUDA device by its number, within these limits. It computes in `f32` and `f64`.
    ///
    /// ```
    /// # use gpu::{Device, Limits};
    /// if let Err(error) = Device::open_cuda(0, Limits::default()) {
    ///     assert!(error.to_string().starts_with("no CUDA device: "));
    /// }
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::NoCuda`] where card, driver or run-time compiler is missing.
    #[cfg(feature = "cuda")]
    pub fn open_cuda(ordinal: usize, limits: Limits) -> Result<Self, DeviceError> {
        Ok(Self(Kind::Cuda(Arc::new(crate::backend::cuda::Cuda::open(ordinal, limits)?))))
    }

    /// Its name and what drives it.
    pub fn name(&self) -> &str {
        use crate::backend::Backend;
        with!(self, backend => backend.name())
    }

    /// One robot's functions, generated, compiled and ready for batches. Steps of integrators are what [`Batches::rollout`] needs.
    ///
    /// Code without loops is long: a step of seven joints compiles in a tenth of a second, one of forty in seconds, slopes of the
    /// latter in minutes. Some drivers do their part when a function is first called.
    ///
    /// ```
    /// use gpu::{Device, Function};
    /// use multibody::{Model, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?; // any robot, mostly from robot_dynamics::load
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // none here
    /// let mut pendulums = device.compile::<f32>(&model, &[Function::Gravity])?;
    /// let (q, mut g) = (vec![0.0; 100_000], vec![0.0; 100_000]);
    /// pendulums.gravity(&q, &mut g)?;
    /// assert!(g.iter().all(|g| (g + 9.81).abs() < 1e-5)); // −m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::Generate`]: no such frame, a singular mass matrix, a robot without joints; [`DeviceError::NoDoubles`];
    /// [`DeviceError::Refused`] with the function's name where the device's compiler refuses it.
    pub fn compile<T: DeviceFloat>(
        &self,
        model: &Model,
        functions: &[Function],
    ) -> Result<Batches<T>, DeviceError> {
        with!(self, backend => {
            Ok(Batches::new(Box::new(Machine::new(Arc::clone(backend), model, functions)?)))
        })
    }
}

impl core::fmt::Debug for Device {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Device").field(&self.name()).finish()
    }
}

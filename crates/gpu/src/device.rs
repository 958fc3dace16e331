//! Devices.

use std::sync::Arc;

use robot_dynamics::model::Model;
use robot_dynamics_generate::Function;

use crate::backend::Backend;
use crate::machine::Machine;
use crate::{Batches, DeviceArray, DeviceError, DeviceFloat, Limits};

/// A device that computes batches.
#[derive(Clone)]
pub struct Device(AnyBackend);

#[derive(Clone)]
enum AnyBackend {
    #[cfg(feature = "wgpu")]
    Wgpu(Arc<crate::backend::wgpu::Wgpu>),
    #[cfg(feature = "cuda")]
    Cuda(Arc<crate::backend::cuda::Cuda>),
}

/// Evaluates an expression for any backend.
macro_rules! with {
    ($device:expr, $backend:ident => $result:expr) => {
        match $device.0 {
            #[cfg(feature = "wgpu")]
            AnyBackend::Wgpu(ref $backend) => $result,
            #[cfg(feature = "cuda")]
            AnyBackend::Cuda(ref $backend) => $result,
        }
    };
}

impl Device {
    /// Opens the first device with Vulkan, Metal or DirectX 12, preferably a graphics processor. It computes
    /// in `f32`.
    ///
    /// The driver's environment variables apply, Vulkan's `VK_DRIVER_FILES` for example.
    ///
    /// ```
    /// match robot_dynamics_gpu::Device::open() {
    ///     Ok(device) => println!("{}", device.name()),
    ///     Err(error) => println!("{error}"), // it says what to install
    /// }
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::NoDevice`], with what to install; [`DeviceError::Closed`] if the device cannot be
    /// opened.
    #[cfg(feature = "wgpu")]
    pub fn open() -> Result<Self, DeviceError> {
        Self::open_with(Limits::default())
    }

    /// Opens the device of [`Device::open`] with these limits.
    ///
    /// # Errors
    /// As [`Device::open`].
    #[cfg(feature = "wgpu")]
    pub fn open_with(limits: Limits) -> Result<Self, DeviceError> {
        Ok(Self(AnyBackend::Wgpu(Arc::new(crate::backend::wgpu::Wgpu::open(limits)?))))
    }

    /// Opens a CUDA device by its number, with these limits. It computes in `f32` and `f64`.
    ///
    /// ```
    /// # use robot_dynamics_gpu::{Device, Limits};
    /// match Device::open_cuda(0, Limits::default()) {
    ///     Ok(device) => println!("{}", device.name()),
    ///     Err(error) => assert!(matches!(error, robot_dynamics_gpu::DeviceError::NoCuda { .. })),
    /// }
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::NoCuda`] if the card, the driver or the run-time compiler is missing.
    #[cfg(feature = "cuda")]
    pub fn open_cuda(ordinal: usize, limits: Limits) -> Result<Self, DeviceError> {
        Ok(Self(AnyBackend::Cuda(Arc::new(crate::backend::cuda::Cuda::open(ordinal, limits, None)?))))
    }

    /// Opens a CUDA device with the library of the run-time compiler NVRTC at this path.
    ///
    /// [`Device::open_cuda`] takes the path of the environment variable `ROBOT_DYNAMICS_NVRTC`, or searches
    /// for libraries of CUDA 13 to 11.2.
    ///
    /// ```
    /// # use robot_dynamics_gpu::{Device, Limits};
    /// let none = Device::open_cuda_with_compiler(0, Limits::default(), "no-such-library.so");
    /// assert!(none.is_err());
    /// ```
    ///
    /// # Errors
    /// As [`Device::open_cuda`].
    #[cfg(feature = "cuda")]
    pub fn open_cuda_with_compiler(
        ordinal: usize,
        limits: Limits,
        compiler: impl AsRef<std::path::Path>,
    ) -> Result<Self, DeviceError> {
        let cuda = crate::backend::cuda::Cuda::open(ordinal, limits, Some(compiler.as_ref()))?;
        Ok(Self(AnyBackend::Cuda(Arc::new(cuda))))
    }

    /// Its name, and the interface that drives it.
    pub fn name(&self) -> &str {
        with!(self, backend => backend.name())
    }

    /// Generates and compiles one robot's functions for batches. [`Batches::rollout`] needs steps of
    /// integrators.
    ///
    /// Code without loops is long. A step of seven joints compiles in a tenth of a second, one of forty in
    /// seconds, its derivatives in minutes. Some drivers compile at the first call of a function.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_gpu::{Device, Function};
    /// let model = Model::new(pendulum(2.0, 0.5))?; // any robot, mostly from robot_dynamics::load
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // no device
    /// let mut pendulums = device.compile::<f32>(&model, &[Function::Gravity])?;
    /// let (q, mut g) = (vec![0.0; 100_000], vec![0.0; 100_000]);
    /// pendulums.gravity(&q, &mut g)?;
    /// assert!(g.iter().all(|g| (g + 9.81).abs() < 1e-5)); // −m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::Generate`] for a missing frame, a singular mass matrix, or a robot without joints;
    /// [`DeviceError::NoDoubles`]; [`DeviceError::Refused`] if the device's compiler fails.
    pub fn compile<T: DeviceFloat>(
        &self,
        model: &Model,
        functions: &[Function],
    ) -> Result<Batches<T>, DeviceError> {
        with!(self, backend => {
            Ok(Batches::new(Box::new(Machine::new(Arc::clone(backend), model, functions)?)))
        })
    }

    /// Copies numbers to new memory of the device.
    ///
    /// ```
    /// # use robot_dynamics_gpu::Device;
    /// # let Ok(device) = Device::open() else { return Ok(()) }; // no device
    /// let (array, mut back) = (device.array(&[1.0_f32, 2.0])?, [0.0; 2]);
    /// array.read(&mut back)?;
    /// assert_eq!(back, [1.0, 2.0]);
    /// # Ok::<(), robot_dynamics_gpu::DeviceError>(())
    /// ```
    ///
    /// # Errors
    /// [`DeviceError::Failed`] if the device has no memory left, or was lost.
    pub fn array<T: DeviceFloat>(&self, numbers: &[T]) -> Result<DeviceArray<T>, DeviceError> {
        with!(self, backend => DeviceArray::new(backend, numbers))
    }
}

impl core::fmt::Debug for Device {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Device").field(&self.name()).finish()
    }
}

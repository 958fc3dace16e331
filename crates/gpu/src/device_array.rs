//! Numbers in the memory of a device.

use core::any::Any;
use core::marker::PhantomData;
use std::sync::Arc;

use crate::backend::Backend;
use crate::{DeviceError, DeviceFloat};

/// A buffer of any backend.
type AnyBuffer = dyn Any + Send + Sync;

/// The memory of a device, whichever its backend is.
trait Memory: Send + Sync {
    fn name(&self) -> &str;

    fn write(&self, buffer: &AnyBuffer, bytes: &[u8]) -> Result<(), DeviceError>;

    fn read(&self, buffer: &AnyBuffer, bytes: &mut [u8]) -> Result<(), DeviceError>;
}

impl<B: Backend> Memory for B {
    fn name(&self) -> &str {
        Backend::name(self)
    }

    fn write(&self, buffer: &AnyBuffer, bytes: &[u8]) -> Result<(), DeviceError> {
        Backend::write(self, of_backend::<B>(buffer), bytes)
    }

    fn read(&self, buffer: &AnyBuffer, bytes: &mut [u8]) -> Result<(), DeviceError> {
        Backend::read(self, of_backend::<B>(buffer), bytes)
    }
}

/// The buffer of this backend.
fn of_backend<B: Backend>(buffer: &AnyBuffer) -> &B::Buffer {
    buffer.downcast_ref().expect("the device of an array made its buffer")
}

/// Numbers in the memory of a device; [`Device::array`](crate::Device::array) makes it.
pub struct DeviceArray<T> {
    memory: Arc<dyn Memory>,
    buffer: Box<AnyBuffer>,
    len: usize,
    of: PhantomData<fn(T) -> T>,
}

impl<T: DeviceFloat> DeviceArray<T> {
    /// Copies numbers to new memory.
    pub(crate) fn new<B: Backend>(backend: &Arc<B>, numbers: &[T]) -> Result<Self, DeviceError> {
        // Buffers must not be empty.
        let buffer = backend.allocate(size_of_val(numbers).max(size_of::<T>()))?;
        let memory: Arc<dyn Memory> = Arc::<B>::clone(backend);
        let mut array = Self { memory, buffer: Box::new(buffer), len: numbers.len(), of: PhantomData };
        array.write(numbers)?;
        Ok(array)
    }

    /// The count of numbers.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the array is empty.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The name of the device.
    pub fn device(&self) -> &str {
        self.memory.name()
    }

    /// Copies all numbers from the host.
    ///
    /// # Errors
    /// [`DeviceError::Failed`].
    ///
    /// # Panics
    /// If the lengths differ.
    #[track_caller]
    pub fn write(&mut self, numbers: &[T]) -> Result<(), DeviceError> {
        assert!(numbers.len() == self.len, "{} numbers for an array of {}", numbers.len(), self.len);
        if numbers.is_empty() {
            return Ok(());
        }
        self.memory.write(&*self.buffer, bytemuck::cast_slice(numbers))
    }

    /// Copies all numbers to the host, after all computations that write them.
    ///
    /// # Errors
    /// [`DeviceError::Failed`].
    ///
    /// # Panics
    /// If the lengths differ.
    #[track_caller]
    pub fn read(&self, numbers: &mut [T]) -> Result<(), DeviceError> {
        assert!(numbers.len() == self.len, "{} numbers of an array of {}", numbers.len(), self.len);
        if numbers.is_empty() {
            return Ok(());
        }
        self.memory.read(&*self.buffer, bytemuck::cast_slice_mut(numbers))
    }

    /// The buffer, if the array is on this device.
    pub(crate) fn buffer_of<B: Backend>(&self, backend: &Arc<B>) -> Option<&B::Buffer> {
        let is_here = Arc::as_ptr(&self.memory).addr() == Arc::as_ptr(backend).addr();
        self.buffer.downcast_ref().filter(|_| is_here)
    }
}

impl<T> core::fmt::Debug for DeviceArray<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DeviceArray")
            .field("device", &self.memory.name())
            .field("len", &self.len)
            .finish_non_exhaustive()
    }
}

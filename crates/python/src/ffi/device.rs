//! Memory and streams of CUDA by their numbers, and any number of numpy arrays as slices.

use pyo3::prelude::*;
use robot_dynamics_gpu::{CallerStream, DevicePointer};

use super::{Array, ArrayNumber};

/// An address on the device, and the count of numbers there.
pub(crate) type RawPointer = (u64, usize);

/// Several of them.
pub(crate) type RawPointers = Vec<RawPointer>;

/// Memory of arrays of other libraries.
pub(crate) fn pointers(raw: &[RawPointer]) -> Vec<DevicePointer> {
    // SAFETY: `robot_dynamics.gpu` alone calls with addresses. It takes them from arrays of the device that
    // the functions were compiled for, with their sizes and types. Its caller holds these arrays. As with
    // every library of arrays, memory that is freed is used again only in the order of the stream.
    raw.iter().map(|&(address, numbers)| unsafe { DevicePointer::new(address, numbers) }).collect()
}

/// A stream of another library.
pub(crate) fn caller_stream(handle: u64) -> CallerStream {
    // SAFETY: `robot_dynamics.gpu` alone calls with handles. It takes them from the current stream of a
    // library on this device, or from an object that its caller holds.
    unsafe { CallerStream::from_handle(handle) }
}

/// The slices of arrays to read, and those of arrays to write.
pub(crate) type SliceTables<'a, T> = (Vec<&'a [T]>, Vec<&'a mut [T]>);

/// The numbers of arrays, some to read and some to write. `None` if an array is not a slice of T, or if one
/// to write is read-only or overlaps another.
pub(crate) fn slice_tables<'a, T: ArrayNumber>(
    read: &'a [Bound<'_, PyAny>],
    written: &'a [Bound<'_, PyAny>],
) -> Option<SliceTables<'a, T>> {
    let arrays = |objects: &'a [Bound<'_, PyAny>]| objects.iter().map(Array::of).collect::<Option<Vec<_>>>();
    let (read, written) = (arrays(read)?, arrays(written)?);
    super::are_slices::<T>(&read, &written).then(|| {
        // SAFETY: as in `slices`.
        unsafe {
            (
                read.iter().map(|array| array.shared::<T>()).collect(),
                written.iter().map(|array| array.exclusive::<T>()).collect(),
            )
        }
    })
}

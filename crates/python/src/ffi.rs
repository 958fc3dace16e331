//! numpy's memory as slices. Only this module of the crate has unsafe code.
//!
//! Arrays are read and written in place. The rule is numpy's own: while a call runs, no other thread may
//! write to an array that it reads or writes, nor resize it. An overlap between arrays that one call reads
//! and writes is found, and the call writes into new arrays instead.

#![allow(unsafe_code)]

pub(crate) mod device;
pub(crate) mod handlers;
pub(crate) mod xla;

use numpy::npyffi::{
    _PyArray_GET_ITEM_DATA, _PyDataType_GET_ITEM_DATA, NPY_ARRAY_ALIGNED, NPY_ARRAY_C_CONTIGUOUS,
    NPY_ARRAY_WRITEABLE, NPY_TYPES, PyArray_Check,
};
use pyo3::prelude::*;
use robot_dynamics::batch::BatchFloat;

use crate::results::{MOST_OPERANDS, MOST_RESULTS};

/// The type of an array's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    F64,
    F32,
    Other,
}

/// A number that arrays hold.
pub(crate) trait ArrayNumber: BatchFloat + numpy::Element {
    const KIND: Kind;
    fn of(x: f64) -> Self;
    fn double(self) -> f64;
}

impl ArrayNumber for f64 {
    const KIND: Kind = Kind::F64;
    fn of(x: f64) -> Self {
        x
    }
    fn double(self) -> f64 {
        self
    }
}

impl ArrayNumber for f32 {
    const KIND: Kind = Kind::F32;
    #[allow(clippy::cast_possible_truncation)] // the numbers asked for are of this type
    fn of(x: f64) -> Self {
        x as f32
    }
    fn double(self) -> f64 {
        f64::from(self)
    }
}

/// An array as its header describes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Array<'a> {
    pub(crate) shape: &'a [usize],
    pub(crate) kind: Kind,
    /// C-contiguous, aligned and in the machine's byte order: its memory is a slice.
    pub(crate) is_plain: bool,
    pub(crate) is_writeable: bool,
    data: *mut u8,
    len: usize,
}

/// The other byte order, as numpy writes it.
const SWAPPED: u8 = if cfg!(target_endian = "little") { b'>' } else { b'<' };

/// The flags of an array whose memory is a slice.
const PLAIN: i32 = NPY_ARRAY_C_CONTIGUOUS | NPY_ARRAY_ALIGNED;

impl<'a> Array<'a> {
    /// No array: nothing to read or to write.
    pub(crate) const NONE: Self = Self {
        shape: &[0],
        kind: Kind::Other,
        is_plain: false,
        is_writeable: true,
        data: core::ptr::null_mut(),
        len: 0,
    };

    /// The header of an object that is a numpy array.
    #[inline]
    pub(crate) fn of(object: &'a Bound<'_, PyAny>) -> Option<Self> {
        // SAFETY: the thread is attached to Python, as it has a `Bound`. While that is borrowed, the object
        // and the memory that it points at are valid. The header is read only after the check of the type;
        // numpy guarantees its layout across versions. A shape has `nd` lengths that are not negative.
        unsafe {
            if PyArray_Check(object.py(), object.as_ptr()) == 0 {
                return None;
            }
            let header = &*_PyArray_GET_ITEM_DATA(object.as_ptr().cast());
            let dtype = &*_PyDataType_GET_ITEM_DATA(header.descr);
            let shape: &[usize] = match usize::try_from(header.nd) {
                Ok(nd) if nd > 0 => core::slice::from_raw_parts(header.dimensions.cast(), nd),
                _ => &[],
            };
            let kind = if dtype.type_num == NPY_TYPES::NPY_DOUBLE as i32 {
                Kind::F64
            } else if dtype.type_num == NPY_TYPES::NPY_FLOAT as i32 {
                Kind::F32
            } else {
                Kind::Other
            };
            Some(Self {
                shape,
                kind,
                is_plain: header.flags & PLAIN == PLAIN && dtype.byteorder.to_ne_bytes() != [SWAPPED],
                is_writeable: header.flags & NPY_ARRAY_WRITEABLE != 0,
                data: header.data.cast(),
                len: shape.iter().product(),
            })
        }
    }

    fn is_slice_of<T: ArrayNumber>(&self) -> bool {
        self.len == 0 || (self.is_plain && self.kind == T::KIND)
    }

    /// The addresses of a plain array's numbers.
    fn addresses<T>(&self) -> core::ops::Range<usize> {
        let start = self.data.addr();
        start..start + self.len * size_of::<T>()
    }
}

/// The slices that a call reads and writes.
pub(crate) type Slices<'a, T> = ([&'a [T]; MOST_OPERANDS], [&'a mut [T]; MOST_RESULTS]);

/// The arrays' numbers, some to read and some to write. `None` if an array is not a slice of T, or if one to
/// write is read-only or overlaps another.
#[inline]
pub(crate) fn slices<'a, T: ArrayNumber>(
    read: &[Array<'a>; MOST_OPERANDS],
    written: &[Array<'a>; MOST_RESULTS],
) -> Option<Slices<'a, T>> {
    are_slices::<T>(read, written).then(|| {
        // SAFETY: each array is a slice of this type, and a written one overlaps nothing else here.
        unsafe {
            (
                read.each_ref().map(|array| array.shared::<T>()),
                written.each_ref().map(|array| array.exclusive::<T>()),
            )
        }
    })
}

/// Whether all arrays are slices of T, and those to write are writeable and overlap no other.
fn are_slices<T: ArrayNumber>(read: &[Array<'_>], written: &[Array<'_>]) -> bool {
    if !read.iter().chain(written).all(Array::is_slice_of::<T>)
        || !written.iter().all(|array| array.is_writeable)
    {
        return false;
    }
    // An empty array overlaps nothing.
    written.iter().enumerate().filter(|(_, array)| array.len > 0).all(|(k, array)| {
        let own = array.addresses::<T>();
        let mut others = read.iter().chain(&written[..k]).map(Array::addresses::<T>);
        !others.any(|other| own.start < other.end && other.start < own.end)
    })
}

impl<'a> Array<'a> {
    /// Its numbers.
    ///
    /// # Safety
    /// The array is a slice of T.
    unsafe fn shared<T>(&self) -> &'a [T] {
        // SAFETY: the array is contiguous, aligned and of this type, so its memory is `len` numbers; the
        // pointer of an empty array is not used. The memory is valid as long as the `Bound` that the array
        // was read from.
        match self.len {
            0 => &[],
            len => unsafe { core::slice::from_raw_parts(self.data.cast::<T>().cast_const(), len) },
        }
    }

    /// Its numbers, to write.
    ///
    /// # Safety
    /// The array is a slice of T, and no other slice overlaps it; other threads keep to the rule above.
    unsafe fn exclusive<T>(&self) -> &'a mut [T] {
        // SAFETY: as in `shared`.
        match self.len {
            0 => &mut [],
            len => unsafe { core::slice::from_raw_parts_mut(self.data.cast::<T>(), len) },
        }
    }
}

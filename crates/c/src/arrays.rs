//! Arrays and texts of C as slices and strings.

use std::ffi::{CStr, CString, c_char};

use crate::failure::Failure;

/// The most arrays of one call.
const MOST_ARRAYS: usize = 8;

/// The arrays of one call, to find outputs that overlap other arrays.
#[derive(Default)]
pub(crate) struct Arrays {
    used: [Range; MOST_ARRAYS],
    count: usize,
}

/// The bytes of an array.
#[derive(Clone, Copy, Default)]
struct Range {
    start: usize,
    end: usize,
    is_output: bool,
}

impl Arrays {
    /// An input of any length.
    ///
    /// # Safety
    /// The pointer is null or valid for reads of `len` values that no other thread writes.
    pub(crate) unsafe fn any<'a, T>(
        &mut self,
        name: &str,
        pointer: *const T,
        len: usize,
    ) -> Result<&'a [T], Failure> {
        if len == 0 {
            return Ok(&[]);
        }
        check_pointer(name, pointer, len)?;
        self.enter(name, pointer as usize, len * size_of::<T>(), false)?;
        Ok(std::slice::from_raw_parts(pointer, len))
    }

    /// An input of a known length.
    ///
    /// # Safety
    /// As [`any`](Self::any).
    pub(crate) unsafe fn input<'a, T>(
        &mut self,
        name: &str,
        pointer: *const T,
        len: usize,
        expected: usize,
    ) -> Result<&'a [T], Failure> {
        check_length(name, len, expected)?;
        self.any(name, pointer, len)
    }

    /// An output of a known length.
    ///
    /// # Safety
    /// The pointer is null or valid for writes of `len` values that no other thread uses.
    pub(crate) unsafe fn output<'a, T>(
        &mut self,
        name: &str,
        pointer: *mut T,
        len: usize,
        expected: usize,
    ) -> Result<&'a mut [T], Failure> {
        check_length(name, len, expected)?;
        if len == 0 {
            return Ok(&mut []);
        }
        check_pointer(name, pointer, len)?;
        self.enter(name, pointer as usize, len * size_of::<T>(), true)?;
        Ok(std::slice::from_raw_parts_mut(pointer, len))
    }

    /// A single output beside arrays.
    ///
    /// # Safety
    /// As [`output`](Self::output), for one value.
    pub(crate) unsafe fn result<'a, T>(&mut self, name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
        check_pointer(name, pointer, 1)?;
        self.enter(name, pointer as usize, size_of::<T>(), true)?;
        Ok(&mut *pointer)
    }

    /// A single output that may be absent.
    ///
    /// # Safety
    /// As [`result`](Self::result).
    pub(crate) unsafe fn optional_result<'a, T>(
        &mut self,
        name: &str,
        pointer: *mut T,
    ) -> Result<Option<&'a mut T>, Failure> {
        if pointer.is_null() { Ok(None) } else { self.result(name, pointer).map(Some) }
    }

    /// Records an array, and refuses an output that overlaps another array.
    #[inline]
    fn enter(&mut self, name: &str, start: usize, bytes: usize, is_output: bool) -> Result<(), Failure> {
        let range = Range { start, end: start + bytes, is_output };
        let overlaps =
            |other: &Range| (is_output || other.is_output) && start < other.end && other.start < range.end;
        if self.used[..self.count].iter().any(overlaps) {
            return Err(Failure::invalid(format!(
                "{name} overlaps another array of the call; copy one of them"
            )));
        }
        let Some(free) = self.used.get_mut(self.count) else {
            return Err(Failure::invalid("the call has too many arrays"));
        };
        *free = range;
        self.count += 1;
        Ok(())
    }
}

#[inline]
fn check_length(name: &str, len: usize, expected: usize) -> Result<(), Failure> {
    if len == expected {
        return Ok(());
    }
    Err(wrong_length(name, len, expected))
}

#[cold]
fn wrong_length(name: &str, len: usize, expected: usize) -> Failure {
    Failure::invalid(format!("{name} has {len} entries, but {expected} are needed"))
}

/// Refuses null, unaligned and overlong arrays.
fn check_pointer<T>(name: &str, pointer: *const T, len: usize) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::invalid(format!("{name} is null")));
    }
    if !pointer.is_aligned() {
        return Err(Failure::invalid(format!("{name} is not aligned to {} bytes", align_of::<T>())));
    }
    let most = isize::MAX as usize / size_of::<T>();
    if len > most || (pointer as usize).checked_add(len * size_of::<T>()).is_none() {
        return Err(Failure::invalid(format!("{name} has {len} entries, more than memory has")));
    }
    Ok(())
}

/// A text.
///
/// # Safety
/// The pointer is null or points to bytes that end with a zero.
pub(crate) unsafe fn text<'a>(name: &str, pointer: *const c_char) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::invalid(format!("{name} is null")));
    }
    CStr::from_ptr(pointer).to_str().map_err(|_| Failure::invalid(format!("{name} is not encoded in UTF-8")))
}

/// A text that may be absent.
///
/// # Safety
/// As [`text`].
pub(crate) unsafe fn optional_text<'a>(
    name: &str,
    pointer: *const c_char,
) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() { Ok(None) } else { text(name, pointer).map(Some) }
}

/// A single output.
///
/// # Safety
/// The pointer is null or valid for a write.
pub(crate) unsafe fn result<'a, T>(name: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    check_pointer(name, pointer, 1)?;
    Ok(&mut *pointer)
}

/// A structure of options, or the default of null.
///
/// # Safety
/// The pointer is null or valid for a read.
pub(crate) unsafe fn options<T: Copy + Default>(name: &str, pointer: *const T) -> Result<T, Failure> {
    if pointer.is_null() {
        return Ok(T::default());
    }
    check_pointer(name, pointer, 1)?;
    Ok(*pointer)
}

/// A text for C. Zero bytes become spaces.
pub(crate) fn c_text(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().map(|byte| if byte == 0 { b' ' } else { byte }).collect();
    CString::new(bytes).unwrap_or_default()
}

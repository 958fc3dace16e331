//! Calls with their errors: the text of the last error, the names of statuses, and the version.

use std::cell::UnsafeCell;
use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::Status;
use crate::failure::Failure;

/// The version of the package, major · 10000 + minor · 100 + patch.
pub const RD_VERSION: u32 = 100;

/// The version of this interface. Programs of another version are not compatible with the library.
pub const RD_ABI_VERSION: u32 = 0;

/// The size of the text of an error in bytes, with its final zero. Longer texts are cut.
const MESSAGE_SIZE: usize = 8192;

struct Message(UnsafeCell<[u8; MESSAGE_SIZE]>);

thread_local! {
    static MESSAGE: Message = const { Message(UnsafeCell::new([0; MESSAGE_SIZE])) };
}

/// The version of the library: compare it with `RD_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn rd_version() -> u32 {
    RD_VERSION
}

/// The version of the library's interface: it must equal `RD_ABI_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn rd_abi_version() -> u32 {
    RD_ABI_VERSION
}

/// The text of the last error of the calling thread; empty if there was none. It is valid until the next call
/// of the same thread that fails. It never returns null.
#[unsafe(no_mangle)]
pub extern "C" fn rd_error_message() -> *const c_char {
    MESSAGE.with(|message| message.0.get().cast::<c_char>().cast_const())
}

/// The name of a status, such as `invalid input`; `unknown status` for other numbers. It never returns null.
#[unsafe(no_mangle)]
pub extern "C" fn rd_status_name(status: i32) -> *const c_char {
    let name = match status {
        0 => c"ok",
        1 => c"file",
        2 => c"description",
        3 => c"unknown name",
        4 => c"invalid input",
        5 => c"singular",
        6 => c"constraint",
        7 => c"diverged",
        8 => c"not converged",
        9 => c"infeasible",
        10 => c"unsupported",
        11 => c"callback",
        12 => c"interrupted",
        13 => c"system",
        14 => c"invalid handle",
        15 => c"in use",
        16 => c"panic",
        _ => c"unknown status",
    };
    name.as_ptr()
}

/// Runs a call and records its error.
pub(crate) fn call(work: impl FnOnce() -> Result<(), Failure>) -> Status {
    let failure = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(failure)) => failure,
        Err(payload) => Failure::panic(&*payload),
    };
    record(&failure.message);
    failure.status
}

/// Runs a query and returns its value, or `otherwise` with a recorded error.
pub(crate) fn query<T>(otherwise: T, work: impl FnOnce() -> Result<T, Failure>) -> T {
    let mut answer = otherwise;
    call(|| {
        answer = work()?;
        Ok(())
    });
    answer
}

/// Stores the text of an error. A text that is too long is cut at a character and ends with `...`.
#[cold]
fn record(message: &str) {
    const END: &[u8] = b"...";
    let whole = message.len() < MESSAGE_SIZE;
    let mut length = if whole { message.len() } else { MESSAGE_SIZE - 1 - END.len() };
    while !message.is_char_boundary(length) {
        length -= 1;
    }
    MESSAGE.with(|own| {
        // SAFETY: the cell belongs to this thread, and no reference to its bytes exists.
        let bytes = unsafe { &mut *own.0.get() };
        let end = if whole { &[][..] } else { END };
        bytes[..length].copy_from_slice(&message.as_bytes()[..length]);
        bytes[length..length + end.len()].copy_from_slice(end);
        // A zero byte inside would hide the rest.
        bytes[..length].iter_mut().filter(|byte| **byte == 0).for_each(|byte| *byte = b' ');
        bytes[length + end.len()] = 0;
    });
}

//! XLA's typed foreign functions: its C structs, and the door from a call frame to slices.
//!
//! The structs are those of `xla/ffi/api/c_api.h` (API 0.x, `OpenXLA`, which jaxlib brings as a file), written down field by
//! field; XLA adds fields at the ends alone, and says in `struct_size` how many it has. Their sizes are checked below.

use core::ffi::{CStr, c_char, c_int, c_void};
use core::marker::PhantomData;
use core::ptr::{NonNull, null_mut};
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use super::{Kind, Number};

/// The version of the calls that the fields below are of, and the least that XLA still takes (found with jaxlib 0.10, whose own
/// is 0.3, and which refuses 0.0).
const API_MAJOR: c_int = 0;
const API_MINOR: c_int = 1;

/// `XLA_FFI_Extension_Metadata`, `XLA_FFI_ExecutionStage_EXECUTE`.
const METADATA: c_int = 1;
const EXECUTE: c_int = 3;

/// `XLA_FFI_ArgType_BUFFER` and `XLA_FFI_RetType_BUFFER`; `XLA_FFI_AttrType_SCALAR` and `…_STRING`.
const BUFFER: c_int = 1;
const SCALAR: c_int = 3;
const STRING: c_int = 4;

/// `XLA_FFI_DataType_PRED`, `…_S64`, `…_U64`, `…_F32`, `…_F64`.
const PRED: c_int = 1;
const S64: c_int = 5;
const U64: c_int = 9;
const F32: c_int = 11;
const F64: c_int = 12;

/// `XLA_FFI_Error_Code_INVALID_ARGUMENT`, `…_INTERNAL`.
const INVALID_ARGUMENT: c_int = 3;
const INTERNAL: c_int = 13;

/// `XLA_FFI_Extension_Base`.
#[repr(C)]
struct Extension {
    struct_size: usize,
    kind: c_int,
    next: *mut Extension,
}

/// `XLA_FFI_Api_Version`.
#[repr(C)]
struct ApiVersion {
    struct_size: usize,
    extension: *mut Extension,
    major: c_int,
    minor: c_int,
}

/// `XLA_FFI_Metadata`, with the last field of API 0.1; later ones have more.
#[repr(C)]
struct Metadata {
    struct_size: usize,
    version: ApiVersion,
    traits: u32,
}

/// `XLA_FFI_Metadata_Extension`.
#[repr(C)]
struct MetadataExtension {
    base: Extension,
    metadata: *mut Metadata,
}

/// `XLA_FFI_Error_Create_Args`.
#[repr(C)]
struct ErrorArguments {
    struct_size: usize,
    extension: *mut Extension,
    message: *const c_char,
    code: c_int,
}

/// `XLA_FFI_Error`: XLA's own.
#[repr(C)]
pub(crate) struct Failure {
    _opaque: [u8; 0],
}

/// `XLA_FFI_Api`, as far as it is used.
#[repr(C)]
struct Api {
    struct_size: usize,
    extension: *mut Extension,
    version: ApiVersion,
    internal: *const c_void,
    create_error: Option<unsafe extern "C" fn(*mut ErrorArguments) -> *mut Failure>,
}

/// `XLA_FFI_Buffer`.
#[repr(C)]
struct RawBuffer {
    struct_size: usize,
    extension: *mut Extension,
    dtype: c_int,
    data: *mut c_void,
    rank: i64,
    dims: *const i64,
}

/// `XLA_FFI_ByteSpan`.
#[repr(C)]
struct ByteSpan {
    start: *const c_char,
    len: usize,
}

/// `XLA_FFI_Scalar`.
#[repr(C)]
struct ScalarValue {
    dtype: c_int,
    value: *const c_void,
}

/// `XLA_FFI_Args` and `XLA_FFI_Rets`, which are alike.
#[repr(C)]
struct Buffers {
    struct_size: usize,
    extension: *mut Extension,
    count: i64,
    kinds: *const c_int,
    buffers: *const *const RawBuffer,
}

/// `XLA_FFI_Attrs`.
#[repr(C)]
struct Attributes {
    struct_size: usize,
    extension: *mut Extension,
    count: i64,
    kinds: *const c_int,
    names: *const *const ByteSpan,
    values: *const *const c_void,
}

/// `XLA_FFI_CallFrame`, without the last field, `future`, of calls that return before they are done.
#[repr(C)]
pub(crate) struct CallFrame {
    struct_size: usize,
    extension: *mut Extension,
    api: *const Api,
    context: *mut c_void,
    stage: c_int,
    arguments: Buffers,
    results: Buffers,
    attributes: Attributes,
}

// The sizes that a C compiler finds, for 64 bits.
#[cfg(target_pointer_width = "64")]
const _: () = {
    assert!(size_of::<Extension>() == 24);
    assert!(size_of::<ApiVersion>() == 24);
    assert!(core::mem::offset_of!(Metadata, version) == 8);
    assert!(core::mem::offset_of!(Metadata, traits) == 32);
    assert!(size_of::<MetadataExtension>() == 32);
    assert!(size_of::<ErrorArguments>() == 32);
    assert!(core::mem::offset_of!(ErrorArguments, code) == 24);
    assert!(core::mem::offset_of!(Api, create_error) == 48);
    assert!(size_of::<RawBuffer>() == 48);
    assert!(core::mem::offset_of!(RawBuffer, data) == 24);
    assert!(size_of::<ByteSpan>() == 16);
    assert!(size_of::<ScalarValue>() == 16);
    assert!(size_of::<Buffers>() == 40);
    assert!(size_of::<Attributes>() == 48);
    assert!(core::mem::offset_of!(CallFrame, stage) == 32);
    assert!(core::mem::offset_of!(CallFrame, arguments) == 40);
    assert!(core::mem::offset_of!(CallFrame, results) == 80);
    assert!(core::mem::offset_of!(CallFrame, attributes) == 120);
    assert!(size_of::<CallFrame>() == 168);
};

/// What a call gives to read and to write.
#[derive(Debug)]
pub(crate) struct XlaCall<'a> {
    frame: PhantomData<&'a CallFrame>,
    attributes: Vec<(&'a [u8], Attribute<'a>)>,
    arguments: Vec<Buffer<'a>>,
    results: Vec<Buffer<'a>>,
}

/// An attribute's value.
#[derive(Clone, Copy, Debug)]
enum Attribute<'a> {
    Text(&'a [u8]),
    Whole(u64),
    Number(f64),
    Truth(bool),
    Other,
}

/// A buffer's shape and where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Buffer<'a> {
    pub(crate) dims: &'a [i64],
    pub(crate) kind: Kind,
    data: *mut c_void,
    len: usize,
}

impl<'a> XlaCall<'a> {
    /// An attribute that is a text.
    pub(crate) fn text(&self, name: &str) -> Result<&'a str, String> {
        match self.attribute(name) {
            Some(Attribute::Text(text)) => core::str::from_utf8(text).map_err(|error| error.to_string()),
            _ => Err(format!("the call has no text `{name}`")),
        }
    }

    /// An attribute that is a whole number.
    pub(crate) fn whole(&self, name: &str) -> Result<u64, String> {
        match self.attribute(name) {
            Some(Attribute::Whole(number)) => Ok(number),
            _ => Err(format!("the call has no whole number `{name}`")),
        }
    }

    /// An attribute that is a float64.
    pub(crate) fn number(&self, name: &str) -> Result<f64, String> {
        match self.attribute(name) {
            Some(Attribute::Number(number)) => Ok(number),
            _ => Err(format!("the call has no number `{name}`")),
        }
    }

    /// An attribute that is true or false.
    pub(crate) fn truth(&self, name: &str) -> Result<bool, String> {
        match self.attribute(name) {
            Some(Attribute::Truth(truth)) => Ok(truth),
            _ => Err(format!("the call has no truth value `{name}`")),
        }
    }

    fn attribute(&self, name: &str) -> Option<Attribute<'a>> {
        self.attributes.iter().find(|(own, _)| *own == name.as_bytes()).map(|(_, value)| *value)
    }

    /// What is read.
    pub(crate) fn arguments(&self) -> &[Buffer<'a>] {
        &self.arguments
    }

    /// What is written.
    pub(crate) fn results(&self) -> &[Buffer<'a>] {
        &self.results
    }

    /// The numbers, to read and to write; none where one is of another type. They are taken out once.
    #[allow(clippy::type_complexity)] // two lists
    pub(crate) fn take<T: Number>(&mut self) -> Option<(Vec<&'a [T]>, Vec<&'a mut [T]>)> {
        let fits = |buffer: &Buffer<'_>| {
            buffer.kind == T::KIND && (buffer.len == 0 || buffer.data.cast::<T>().is_aligned())
        };
        if !self.arguments.iter().chain(&self.results).all(fits) {
            return None;
        }
        let (arguments, results) = (core::mem::take(&mut self.arguments), core::mem::take(&mut self.results));
        // SAFETY: XLA gives each buffer with room for as many numbers of its type as its dimensions say, which lie there until
        // the call returns; those of results are the call's alone, as no alias was asked for. Aligned, and looked at above. An
        // empty one is nowhere. As the lists are taken out, no second slice of a result is made.
        unsafe {
            let read = |buffer: Buffer<'a>| match buffer.len {
                0 => &[][..],
                len => core::slice::from_raw_parts(buffer.data.cast::<T>().cast_const(), len),
            };
            let write = |buffer: Buffer<'a>| match buffer.len {
                0 => &mut [][..],
                len => core::slice::from_raw_parts_mut(buffer.data.cast::<T>(), len),
            };
            Some((arguments.into_iter().map(read).collect(), results.into_iter().map(write).collect()))
        }
    }
}

/// A slice of what C says are so many.
///
/// # Safety
/// They are there, for as long as 'a.
unsafe fn listed<'a, T>(start: *const T, count: i64) -> &'a [T] {
    match usize::try_from(count) {
        // SAFETY: the caller's word.
        Ok(count) if count > 0 && !start.is_null() => unsafe { core::slice::from_raw_parts(start, count) },
        _ => &[],
    }
}

/// The buffers of a list; an error where one is none.
///
/// # Safety
/// The list is XLA's and lives for 'a.
unsafe fn buffers_of<'a>(list: &Buffers) -> Result<Vec<Buffer<'a>>, String> {
    // SAFETY: both lists have `count` entries, each entry of kind `BUFFER` points at one; its dimensions are `rank` many.
    unsafe {
        let (kinds, buffers) = (listed(list.kinds, list.count), listed(list.buffers, list.count));
        kinds
            .iter()
            .zip(buffers)
            .map(|(kind, buffer)| {
                if *kind != BUFFER {
                    return Err("an argument is no array".to_owned());
                }
                let raw: &RawBuffer = &**buffer;
                let dims: &[i64] = listed(raw.dims, raw.rank);
                let kind = match raw.dtype {
                    F64 => Kind::F64,
                    F32 => Kind::F32,
                    _ => Kind::Other,
                };
                let len = dims.iter().map(|&length| usize::try_from(length).unwrap_or(0)).product();
                Ok(Buffer { dims, kind, data: raw.data, len })
            })
            .collect()
    }
}

/// The call of a frame.
///
/// # Safety
/// The frame is XLA's, in the stage of execution, and lives for 'a.
unsafe fn call_of<'a>(frame: &'a CallFrame) -> Result<XlaCall<'a>, String> {
    // SAFETY: the lists of attributes have `count` entries; a value is what its kind says, and lives as the frame does.
    unsafe {
        let list = &frame.attributes;
        let kinds = listed(list.kinds, list.count);
        let (names, values) = (listed(list.names, list.count), listed(list.values, list.count));
        let bytes = |span: &ByteSpan| -> &'a [u8] {
            listed(span.start.cast::<u8>(), i64::try_from(span.len).unwrap_or(0))
        };
        let attributes = kinds
            .iter()
            .zip(names.iter().zip(values))
            .map(|(kind, (name, value))| {
                let value = match *kind {
                    STRING => Attribute::Text(bytes(&*value.cast::<ByteSpan>())),
                    SCALAR => {
                        let scalar = &*value.cast::<ScalarValue>();
                        match scalar.dtype {
                            U64 | S64 => Attribute::Whole(scalar.value.cast::<u64>().read_unaligned()),
                            F64 => Attribute::Number(scalar.value.cast::<f64>().read_unaligned()),
                            PRED => Attribute::Truth(scalar.value.cast::<u8>().read() != 0),
                            _ => Attribute::Other,
                        }
                    }
                    _ => Attribute::Other,
                };
                (bytes(&**name), value)
            })
            .collect();
        Ok(XlaCall {
            frame: PhantomData,
            attributes,
            arguments: buffers_of(&frame.arguments)?,
            results: buffers_of(&frame.results)?,
        })
    }
}

/// What a handler does: reads and writes the call's arrays, or says what is wrong.
pub(crate) type Work = fn(XlaCall<'_>) -> Result<(), String>;

/// Answers a question for metadata, or does the work and turns its failure into XLA's.
///
/// # Safety
/// The frame is one that XLA calls a handler with.
unsafe fn handle(frame: *mut CallFrame, work: Work) -> *mut Failure {
    // SAFETY: XLA's frame and what it points at live until the handler returns, and nobody else writes there. An extension of
    // kind `METADATA` is a `MetadataExtension`, whose metadata has at least the fields above.
    unsafe {
        let frame = &*frame;
        if let Some(extension) = frame.extension.as_ref()
            && extension.kind == METADATA
        {
            let metadata = &mut *(*frame.extension.cast::<MetadataExtension>()).metadata;
            metadata.version.major = API_MAJOR;
            metadata.version.minor = API_MINOR;
            metadata.traits = 0;
            return null_mut();
        }
        if frame.stage != EXECUTE {
            return null_mut();
        }
        // A panic must not pass through C++. What it may leave half done is scratch and the results, which fail with it.
        let done = catch_unwind(AssertUnwindSafe(|| work(call_of(frame)?)));
        let (message, code) = match done {
            Ok(Ok(())) => return null_mut(),
            Ok(Err(message)) => (message, INVALID_ARGUMENT),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
                (format!("robot_dynamics: internal error: {text}"), INTERNAL)
            }
        };
        let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
        let mut arguments = ErrorArguments {
            struct_size: size_of::<ErrorArguments>(),
            extension: null_mut(),
            message: message.as_ptr(),
            code,
        };
        match frame.api.as_ref().and_then(|api| api.create_error) {
            Some(create) => create(&raw mut arguments),
            None => std::process::abort(),
        }
    }
}

/// A handler as XLA calls it.
pub(crate) type Handler = unsafe extern "C" fn(*mut CallFrame) -> *mut Failure;

/// A C function of each piece of work.
macro_rules! handlers {
    ($($name:ident: $work:path;)*) => {
        /// The handlers by the names of their targets.
        pub(crate) const HANDLERS: &[(&str, Handler)] = &[$((stringify!($name), $name)),*];
        $(
            unsafe extern "C" fn $name(frame: *mut CallFrame) -> *mut Failure {
                // SAFETY: only XLA has the pointer, see `capsule`.
                unsafe { handle(frame, $work) }
            }
        )*
    };
}

handlers! {
    robot_dynamics_row: crate::xla::row;
    robot_dynamics_rollout: crate::xla::rollout;
    robot_dynamics_rollout_tangent: crate::xla::rollout_tangent;
    robot_dynamics_rollout_pullback: crate::xla::rollout_pullback;
}

/// The name of capsules with a handler, by which XLA knows them.
const CAPSULE: &CStr = c"xla._CUSTOM_CALL_TARGET";

/// A handler as Python hands it to XLA.
pub(crate) fn capsule(py: Python<'_>, handler: Handler) -> PyResult<Bound<'_, PyCapsule>> {
    let pointer = NonNull::new(handler as *mut c_void);
    let pointer = pointer.ok_or_else(|| pyo3::exceptions::PyRuntimeError::new_err("no handler"))?;
    // SAFETY: the pointer is that of a function, which is there as long as the process; whoever takes it out of a capsule of
    // this name calls it as XLA calls handlers.
    unsafe { PyCapsule::new_with_pointer(py, pointer, CAPSULE) }
}

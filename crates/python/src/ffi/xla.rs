//! XLA's typed foreign functions: the arrays of a call frame as slices.

mod layout;

use core::ffi::{CStr, c_void};
use core::ptr::{NonNull, null_mut};
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use self::layout::{
    API_MAJOR, API_MINOR, Api, BUFFER, Buffers, ByteSpan, DestroyArguments, EXECUTE, ErrorArguments, F32,
    F64, INTERNAL, INVALID_ARGUMENT, METADATA, MetadataExtension, PRED, RawBuffer, S64, SCALAR, STRING,
    ScalarValue, StreamArguments, U64,
};
use super::device::RawPointer;
use super::{ArrayNumber, Kind};

pub(crate) use self::layout::{CallFrame, Failure};

/// The attributes of a call, and its arrays to read and to write.
#[derive(Debug)]
pub(crate) struct XlaCall<'a> {
    frame: &'a CallFrame,
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

    /// Whether its last array is the robot's parameters.
    pub(crate) fn has_parameters(&self) -> bool {
        self.truth("parameters").unwrap_or(false)
    }

    fn attribute(&self, name: &str) -> Option<Attribute<'a>> {
        self.attributes.iter().find(|(own, _)| *own == name.as_bytes()).map(|(_, value)| *value)
    }

    /// The arrays to read.
    pub(crate) fn arguments(&self) -> &[Buffer<'a>] {
        &self.arguments
    }

    /// The arrays to write.
    pub(crate) fn results(&self) -> &[Buffer<'a>] {
        &self.results
    }

    /// The memory of the arrays on a device, to read and to write.
    pub(crate) fn device_memory(&self) -> (Vec<RawPointer>, Vec<RawPointer>) {
        let of = |buffers: &[Buffer<'_>]| {
            buffers.iter().map(|buffer| (buffer.data.addr() as u64, buffer.len)).collect()
        };
        (of(&self.arguments), of(&self.results))
    }

    /// The device's stream that the call belongs to.
    pub(crate) fn device_stream(&self) -> Result<u64, String> {
        let mut arguments = StreamArguments {
            struct_size: size_of::<StreamArguments>(),
            extension: null_mut(),
            context: self.frame.context,
            stream: null_mut(),
        };
        // SAFETY: XLA's table of functions is valid during the call, and `struct_size` says how many it has.
        // XLA fills in the stream, or returns an error, which is destroyed once.
        unsafe {
            let api = self.frame.api.as_ref().filter(|api| api.struct_size >= size_of::<Api>());
            let get = api.and_then(|api| api.stream).ok_or("this version of XLA does not give its stream")?;
            let error = get(&raw mut arguments);
            if error.is_null() {
                return Ok(arguments.stream.addr() as u64);
            }
            if let Some(destroy) = api.and_then(|api| api.destroy_error) {
                let struct_size = size_of::<DestroyArguments>();
                let mut destroyed = DestroyArguments { struct_size, extension: null_mut(), error };
                destroy(&raw mut destroyed);
            }
            Err("the call is not one of a CUDA device".into())
        }
    }

    /// Takes out the arrays' numbers, to read and to write; `None` if an array has another type. A second
    /// call returns empty lists.
    #[allow(clippy::type_complexity)] // two lists
    pub(crate) fn take<T: ArrayNumber>(&mut self) -> Option<(Vec<&'a [T]>, Vec<&'a mut [T]>)> {
        let fits = |buffer: &Buffer<'_>| {
            buffer.kind == T::KIND && (buffer.len == 0 || buffer.data.cast::<T>().is_aligned())
        };
        if !self.arguments.iter().chain(&self.results).all(fits) {
            return None;
        }
        let (arguments, results) = (core::mem::take(&mut self.arguments), core::mem::take(&mut self.results));
        // SAFETY: each buffer of XLA's has as many numbers of its type as its dimensions say. They are valid
        // until the call returns. Only this call uses those of results, as no alias was requested. Type and
        // alignment were checked above. The pointer of an empty buffer is not used. As the lists are taken
        // out, no second slice of a result is made.
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

/// The slice of `count` entries at a C pointer.
///
/// # Safety
/// The entries are valid for 'a.
unsafe fn listed<'a, T>(start: *const T, count: i64) -> &'a [T] {
    match usize::try_from(count) {
        // SAFETY: the caller guarantees it.
        Ok(count) if count > 0 && !start.is_null() => unsafe { core::slice::from_raw_parts(start, count) },
        _ => &[],
    }
}

/// The buffers of a list; an error if one is missing.
///
/// # Safety
/// The list is XLA's and valid for 'a.
unsafe fn buffers_of<'a>(list: &Buffers) -> Result<Vec<Buffer<'a>>, String> {
    // SAFETY: both lists have `count` entries. Each entry of kind `BUFFER` points at a buffer, which has
    // `rank` dimensions.
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
/// The frame is XLA's, in the stage of execution, and valid for 'a.
unsafe fn call_of<'a>(frame: &'a CallFrame) -> Result<XlaCall<'a>, String> {
    // SAFETY: the lists of attributes have `count` entries. A value has the type that its kind says, and is
    // valid as long as the frame.
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
            frame,
            attributes,
            arguments: buffers_of(&frame.arguments)?,
            results: buffers_of(&frame.results)?,
        })
    }
}

/// The work of a handler: it reads and writes the call's arrays, or returns the reason of a failure.
pub(crate) type HandlerFunction = fn(XlaCall<'_>) -> Result<(), String>;

/// Answers a question for metadata, or does the work and turns its failure into XLA's.
///
/// # Safety
/// The frame is one that XLA calls a handler with.
pub(super) unsafe fn handle(frame: *mut CallFrame, work: HandlerFunction) -> *mut Failure {
    // SAFETY: XLA's frame and the memory that it points at are valid until the handler returns, and nobody
    // else writes there. An extension of kind `METADATA` is a `MetadataExtension`, whose metadata has at
    // least the fields above.
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
        // A panic must not pass through C++. It can leave only scratch memory and the results incomplete, and
        // then the call fails.
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

/// The name that XLA requires of capsules with a handler.
const CAPSULE: &CStr = c"xla._CUSTOM_CALL_TARGET";

/// The capsule with a handler that Python passes to XLA.
pub(crate) fn capsule(py: Python<'_>, handler: Handler) -> PyResult<Bound<'_, PyCapsule>> {
    let pointer = NonNull::new(handler as *mut c_void);
    let pointer = pointer.ok_or_else(|| pyo3::exceptions::PyRuntimeError::new_err("no handler"))?;
    // SAFETY: the pointer is that of a function, which exists as long as the process. Code that takes it out
    // of a capsule of this name calls it as XLA calls handlers.
    unsafe { PyCapsule::new_with_pointer(py, pointer, CAPSULE) }
}

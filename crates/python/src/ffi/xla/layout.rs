//! The C structs of XLA's typed foreign calls, of `xla/ffi/api/c_api.h` (`OpenXLA`; jaxlib brings the file),
//! field by field.
//!
//! XLA adds fields at the ends alone, and says in `struct_size` how many it has. The sizes are checked where
//! they are declared.

use core::ffi::{c_char, c_int, c_void};

/// The version of the calls that the fields below belong to. It is the lowest that XLA accepts (found with
/// jaxlib 0.10, whose own is 0.3, and which refuses 0.0).
pub(super) const API_MAJOR: c_int = 0;
pub(super) const API_MINOR: c_int = 1;

/// `XLA_FFI_Extension_Metadata`, `XLA_FFI_ExecutionStage_EXECUTE`.
pub(super) const METADATA: c_int = 1;
pub(super) const EXECUTE: c_int = 3;

/// `XLA_FFI_ArgType_BUFFER` and `XLA_FFI_RetType_BUFFER`; `XLA_FFI_AttrType_SCALAR` and `…_STRING`.
pub(super) const BUFFER: c_int = 1;
pub(super) const SCALAR: c_int = 3;
pub(super) const STRING: c_int = 4;

/// `XLA_FFI_DataType_PRED`, `…_S64`, `…_U64`, `…_F32`, `…_F64`.
pub(super) const PRED: c_int = 1;
pub(super) const S64: c_int = 5;
pub(super) const U64: c_int = 9;
pub(super) const F32: c_int = 11;
pub(super) const F64: c_int = 12;

/// `XLA_FFI_Error_Code_INVALID_ARGUMENT`, `…_INTERNAL`.
pub(super) const INVALID_ARGUMENT: c_int = 3;
pub(super) const INTERNAL: c_int = 13;

/// `XLA_FFI_Extension_Base`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Extension {
    pub(super) struct_size: usize,
    pub(super) kind: c_int,
    pub(super) next: *mut Extension,
}

/// `XLA_FFI_Api_Version`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct ApiVersion {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) major: c_int,
    pub(super) minor: c_int,
}

/// `XLA_FFI_Metadata`, with the last field of API 0.1; later ones have more.
#[repr(C)]
pub(super) struct Metadata {
    pub(super) struct_size: usize,
    pub(super) version: ApiVersion,
    pub(super) traits: u32,
}

/// `XLA_FFI_Metadata_Extension`.
#[repr(C)]
pub(super) struct MetadataExtension {
    pub(super) base: Extension,
    pub(super) metadata: *mut Metadata,
}

/// `XLA_FFI_Error_Create_Args`.
#[repr(C)]
pub(super) struct ErrorArguments {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) message: *const c_char,
    pub(super) code: c_int,
}

/// `XLA_FFI_Error`: XLA's own.
#[repr(C)]
pub(crate) struct Failure {
    pub(super) _opaque: [u8; 0],
}

/// `XLA_FFI_Api`, as far as it is used.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Api {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) version: ApiVersion,
    pub(super) internal: *const c_void,
    pub(super) create_error: Option<unsafe extern "C" fn(*mut ErrorArguments) -> *mut Failure>,
    pub(super) error_message: *const c_void,
    pub(super) destroy_error: Option<unsafe extern "C" fn(*mut DestroyArguments)>,
    pub(super) register: *const c_void,
    pub(super) stream: Option<unsafe extern "C" fn(*mut StreamArguments) -> *mut Failure>,
}

/// `XLA_FFI_Error_Destroy_Args`.
#[repr(C)]
pub(super) struct DestroyArguments {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) error: *mut Failure,
}

/// `XLA_FFI_Stream_Get_Args`.
#[repr(C)]
pub(super) struct StreamArguments {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) context: *mut c_void,
    pub(super) stream: *mut c_void,
}

/// `XLA_FFI_Buffer`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct RawBuffer {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) dtype: c_int,
    pub(super) data: *mut c_void,
    pub(super) rank: i64,
    pub(super) dims: *const i64,
}

/// `XLA_FFI_ByteSpan`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct ByteSpan {
    pub(super) start: *const c_char,
    pub(super) len: usize,
}

/// `XLA_FFI_Scalar`.
#[repr(C)]
pub(super) struct ScalarValue {
    pub(super) dtype: c_int,
    pub(super) value: *const c_void,
}

/// `XLA_FFI_Args` and `XLA_FFI_Rets`, which are alike.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Buffers {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) count: i64,
    pub(super) kinds: *const c_int,
    pub(super) buffers: *const *const RawBuffer,
}

/// `XLA_FFI_Attrs`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Attributes {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) count: i64,
    pub(super) kinds: *const c_int,
    pub(super) names: *const *const ByteSpan,
    pub(super) values: *const *const c_void,
}

/// `XLA_FFI_CallFrame`, without the last field, `future`, of calls that return before they are done.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct CallFrame {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) api: *const Api,
    pub(super) context: *mut c_void,
    pub(super) stage: c_int,
    pub(super) arguments: Buffers,
    pub(super) results: Buffers,
    pub(super) attributes: Attributes,
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
    assert!(core::mem::offset_of!(Api, stream) == 80);
    assert!(size_of::<DestroyArguments>() == 24);
    assert!(size_of::<StreamArguments>() == 32);
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

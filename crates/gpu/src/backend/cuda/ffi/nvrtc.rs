//! NVRTC, NVIDIA's run-time compiler: its library and the functions that are called.

use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr::{null, null_mut};
use std::ffi::{CString, OsStr};

use libloading::Library;

/// A program of NVRTC.
type Program = *mut c_void;

/// NVRTC's code for success.
const SUCCESS: c_int = 0;

type ReadSize = unsafe extern "C" fn(Program, *mut usize) -> c_int;
type ReadBytes = unsafe extern "C" fn(Program, *mut c_char) -> c_int;
type CreateProgram = unsafe extern "C" fn(
    *mut Program,
    *const c_char,
    *const c_char,
    c_int,
    *const *const c_char,
    *const *const c_char,
) -> c_int;

/// A text of bytes that NVRTC returns: the function for its size, and that for the bytes.
#[derive(Clone, Copy)]
struct Output {
    size: ReadSize,
    read: ReadBytes,
}

/// The code that a compilation returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Image {
    /// Code for any card, which the driver compiles.
    Ptx,
    /// Machine code of one architecture.
    Cubin,
}

/// The run-time compiler.
pub(in super::super) struct Nvrtc {
    create: CreateProgram,
    compile: unsafe extern "C" fn(Program, c_int, *const *const c_char) -> c_int,
    destroy: unsafe extern "C" fn(*mut Program) -> c_int,
    error_text: unsafe extern "C" fn(c_int) -> *const c_char,
    ptx: Output,
    cubin: Output,
    log: Output,
    /// Major and minor version.
    version: [c_int; 2],
    /// Compute capabilities, 90 for 9.0, for which it writes machine code.
    architectures: Vec<c_int>,
    /// Keeps the functions above loaded.
    _library: Library,
}

/// A program that is destroyed when it is dropped.
struct OwnedProgram<'a> {
    compiler: &'a Nvrtc,
    program: Program,
}

impl Drop for OwnedProgram<'_> {
    fn drop(&mut self) {
        // SAFETY: the program was created by this library and is destroyed once.
        unsafe { (self.compiler.destroy)(&raw mut self.program) };
    }
}

impl Nvrtc {
    /// Loads the library of this name or path.
    pub(in super::super) fn load(name: &OsStr) -> Result<Self, String> {
        let message = |error: libloading::Error| format!("{}: {error}", name.to_string_lossy());
        // SAFETY: the library is NVRTC by its name or by the caller's word. Its start-up code is trusted, as
        // for every library that is linked. The types of its functions are those of `nvrtc.h`, the same from
        // CUDA 11.2 to 13, and `_library` keeps them loaded.
        unsafe {
            let library = Library::new(name).map_err(message)?;
            let output = |size: &CStr, read: &CStr| -> Result<Output, libloading::Error> {
                Ok(Output { size: *library.get(size)?, read: *library.get(read)? })
            };
            let ptx = output(c"nvrtcGetPTXSize", c"nvrtcGetPTX").map_err(message)?;
            let cubin = output(c"nvrtcGetCUBINSize", c"nvrtcGetCUBIN").map_err(message)?;
            let log = output(c"nvrtcGetProgramLogSize", c"nvrtcGetProgramLog").map_err(message)?;
            let version: unsafe extern "C" fn(*mut c_int, *mut c_int) -> c_int =
                *library.get(c"nvrtcVersion").map_err(message)?;
            let count: unsafe extern "C" fn(*mut c_int) -> c_int =
                *library.get(c"nvrtcGetNumSupportedArchs").map_err(message)?;
            let list: unsafe extern "C" fn(*mut c_int) -> c_int =
                *library.get(c"nvrtcGetSupportedArchs").map_err(message)?;
            let (mut major, mut minor, mut most) = (0, 0, 0);
            let mut done = version(&raw mut major, &raw mut minor) == SUCCESS;
            done &= count(&raw mut most) == SUCCESS;
            let mut architectures = vec![0; usize::try_from(most).unwrap_or(0)];
            done &= list(architectures.as_mut_ptr()) == SUCCESS;
            if !done {
                return Err(format!("{} does not tell its version", name.to_string_lossy()));
            }
            Ok(Self {
                create: *library.get(c"nvrtcCreateProgram").map_err(message)?,
                compile: *library.get(c"nvrtcCompileProgram").map_err(message)?,
                destroy: *library.get(c"nvrtcDestroyProgram").map_err(message)?,
                error_text: *library.get(c"nvrtcGetErrorString").map_err(message)?,
                ptx,
                cubin,
                log,
                version: [major, minor],
                architectures,
                _library: library,
            })
        }
    }

    pub(in super::super) fn version(&self) -> [i32; 2] {
        self.version
    }

    pub(in super::super) fn architectures(&self) -> &[i32] {
        &self.architectures
    }

    /// Compiles a text with these options; the error is the compiler's log.
    pub(in super::super) fn compile(
        &self,
        text: &str,
        options: &[String],
        image: Image,
    ) -> Result<Vec<u8>, String> {
        let as_c = |text: &str| CString::new(text).map_err(|error| error.to_string());
        let (source, name) = (as_c(text)?, c"robot.cu");
        let options = options.iter().map(|option| as_c(option)).collect::<Result<Vec<_>, _>>()?;
        let options: Vec<*const c_char> = options.iter().map(|option| option.as_ptr()).collect();
        let count = c_int::try_from(options.len()).map_err(|error| error.to_string())?;
        let mut program = null_mut();
        // SAFETY: the texts and the list of options end as C expects and outlive the calls. No headers are
        // passed, so the lists of headers may be null. `OwnedProgram` destroys the program once.
        unsafe {
            let created = (self.create)(&raw mut program, source.as_ptr(), name.as_ptr(), 0, null(), null());
            if created != SUCCESS {
                return Err(self.message(created));
            }
            let owned = OwnedProgram { compiler: self, program };
            let compiled = (self.compile)(owned.program, count, options.as_ptr());
            if compiled != SUCCESS {
                let log = owned.read(self.log).unwrap_or_default();
                let log = String::from_utf8_lossy(&log).trim_end_matches('\0').trim().to_owned();
                return Err(if log.is_empty() { self.message(compiled) } else { log });
            }
            owned.read(if image == Image::Cubin { self.cubin } else { self.ptx })
        }
    }

    /// The text of an error code.
    fn message(&self, code: c_int) -> String {
        // SAFETY: the function returns a text that exists as long as the library.
        let text = unsafe { CStr::from_ptr((self.error_text)(code)) };
        text.to_string_lossy().into_owned()
    }
}

impl OwnedProgram<'_> {
    /// The bytes of an output of the program.
    fn read(&self, output: Output) -> Result<Vec<u8>, String> {
        let mut size = 0;
        // SAFETY: the program exists, and the second function writes as many bytes as the first one returns.
        unsafe {
            let mut code = (output.size)(self.program, &raw mut size);
            let mut bytes = vec![0_u8; size];
            if code == SUCCESS {
                code = (output.read)(self.program, bytes.as_mut_ptr().cast());
            }
            if code == SUCCESS { Ok(bytes) } else { Err(self.compiler.message(code)) }
        }
    }
}

//! Memory that holds machine code, and the call into it. All unsafe code of this crate is in this file.
//!
//! A page is written first and made executable then. It is never writable and executable at once; on macOS on
//! ARM this holds for each thread. [`Code::new`](crate::Code::new) made the code. It is a function of the
//! System V convention with two pointers, which
//! - reads and writes the tables of the first pointer within the lengths that are checked here before each
//!   call,
//! - reads and writes the scratch memory of the second within a length that is checked here,
//! - reads constants behind its instructions,
//! - and returns, with the registers that the convention preserves unchanged.
#![allow(unsafe_code)]

use memmap2::{Mmap, MmapMut};

use crate::code::MAX_TABLES;

/// The type of the code as a function.
#[cfg(target_arch = "x86_64")]
type Function = unsafe extern "sysv64" fn(tables: *const *mut (), scratch: *mut ());
#[cfg(not(target_arch = "x86_64"))]
type Function = unsafe extern "C" fn(tables: *const *mut (), scratch: *mut ());

/// Executable memory with the code of one kernel.
#[derive(Debug)]
pub(crate) struct Page {
    memory: CodeMemory,
}

/// Memory with finished code, read-only from then on.
#[derive(Debug)]
enum CodeMemory {
    /// Mapped memory, made executable after it was written.
    Mapped(Mmap),
    #[cfg(all(target_os = "macos", target_arch = "aarch64"))]
    Jit(jit::JitMemory),
}

impl CodeMemory {
    /// Memory with this code.
    fn new(code: &[u8]) -> std::io::Result<Self> {
        // Hardened programs with the JIT entitlement may map code only this way. Where the system refuses it,
        // the other way may be allowed.
        #[cfg(all(target_os = "macos", target_arch = "aarch64"))]
        if let Ok(memory) = jit::JitMemory::new(code) {
            return Ok(Self::Jit(memory));
        }
        let mut memory = MmapMut::map_anon(code.len())?;
        memory.copy_from_slice(code);
        let memory = memory.make_exec()?;
        clear_instruction_cache(&memory);
        Ok(Self::Mapped(memory))
    }

    #[inline]
    fn start(&self) -> *const u8 {
        match self {
            Self::Mapped(memory) => memory.as_ptr(),
            #[cfg(all(target_os = "macos", target_arch = "aarch64"))]
            Self::Jit(memory) => memory.start(),
        }
    }
}

/// The size of a table that the code accesses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Table {
    /// Numbers of one state.
    pub(crate) width: usize,
    /// Numbers that the code accesses in one run.
    pub(crate) reach: usize,
}

/// The bounds of the code's accesses from each of its pointers.
#[derive(Clone, Debug)]
pub(crate) struct AccessBounds {
    /// First the arguments, then the results.
    tables: [Table; MAX_TABLES],
    inputs: usize,
    count: usize,
    scratch: usize,
}

impl AccessBounds {
    /// # Panics
    /// If there are more tables than a kernel supports, which is checked when the code is made.
    pub(crate) fn new(inputs: &[Table], outputs: &[Table], scratch: usize) -> Self {
        let mut tables = [Table::default(); MAX_TABLES];
        let count = inputs.len() + outputs.len();
        tables[..inputs.len()].copy_from_slice(inputs);
        tables[inputs.len()..count].copy_from_slice(outputs);
        Self { tables, inputs: inputs.len(), count, scratch }
    }

    #[inline]
    pub(crate) fn inputs(&self) -> &[Table] {
        &self.tables[..self.inputs]
    }

    #[inline]
    pub(crate) fn outputs(&self) -> &[Table] {
        &self.tables[self.inputs..self.count]
    }

    #[inline]
    pub(crate) fn tables(&self) -> &[Table] {
        &self.tables[..self.count]
    }
}

impl Page {
    /// Writes code into new memory and makes that executable.
    pub(crate) fn new(code: &[u8]) -> std::io::Result<Self> {
        Ok(Self { memory: CodeMemory::new(code)? })
    }

    #[inline]
    fn function(&self) -> Function {
        // SAFETY: the memory holds a whole function of this type, made by this crate for the instructions of
        // this processor. The pointer is called only while `self` is borrowed.
        unsafe { core::mem::transmute(self.memory.start()) }
    }

    /// Runs the code once if each slice has exactly the length that the code accesses, and the scratch memory
    /// at least that length. Returns whether it ran.
    #[inline]
    #[must_use]
    pub(crate) fn run<T>(
        &self,
        reach: &AccessBounds,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        scratch: &mut [T],
    ) -> bool {
        let mut pointers = [core::ptr::null_mut::<()>(); MAX_TABLES];
        let mut is_whole = inputs.len() == reach.inputs
            && outputs.len() == reach.count - reach.inputs
            && scratch.len() >= reach.scratch;
        for ((pointer, input), table) in pointers.iter_mut().zip(inputs).zip(reach.inputs()) {
            is_whole &= input.len() == table.reach;
            *pointer = input.as_ptr().cast_mut().cast();
        }
        for ((pointer, output), table) in
            pointers[reach.inputs..].iter_mut().zip(outputs.iter_mut()).zip(reach.outputs())
        {
            is_whole &= output.len() == table.reach;
            *pointer = output.as_mut_ptr().cast();
        }
        if is_whole {
            // SAFETY: the code accesses only the numbers behind its pointers that were checked above. Outputs
            // and scratch memory are borrowed exclusively, so that they overlap neither each other nor an
            // input.
            unsafe { self.function()(pointers.as_ptr(), scratch.as_mut_ptr().cast()) };
        }
        is_whole
    }

    /// Runs the code for blocks of `rows` rows from the beginning of each table. After each block it calls
    /// `after` with the scratch memory and the number of the block.
    ///
    /// # Panics
    /// If a slice is shorter than the code accesses, or the number of slices is wrong.
    pub(crate) fn run_blocks<T>(
        &self,
        reach: &AccessBounds,
        (blocks, rows): (usize, usize),
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        scratch: &mut [T],
        mut after: impl FnMut(&[T], usize),
    ) {
        let Some(last) = blocks.checked_sub(1) else { return };
        assert!(
            inputs.len() == reach.inputs
                && outputs.len() == reach.count - reach.inputs
                && scratch.len() >= reach.scratch,
            "the code has other tables"
        );
        // The distance from a block to the next, in numbers, if the last block is within the slice.
        let step = |length: usize, table: &Table| {
            let step = rows.checked_mul(table.width)?;
            let end = last.checked_mul(step)?.checked_add(table.reach)?;
            (length >= end).then_some(step)
        };
        let mut pointers = [core::ptr::null_mut::<T>(); MAX_TABLES];
        let mut steps = [0; MAX_TABLES];
        let (of_inputs, of_outputs) = pointers.split_at_mut(reach.inputs);
        let (input_steps, output_steps) = steps.split_at_mut(reach.inputs);
        for (k, (input, table)) in inputs.iter().zip(reach.inputs()).enumerate() {
            of_inputs[k] = input.as_ptr().cast_mut();
            input_steps[k] = step(input.len(), table).expect("the code reaches beyond an argument");
        }
        for (k, (output, table)) in outputs.iter_mut().zip(reach.outputs()).enumerate() {
            of_outputs[k] = output.as_mut_ptr();
            output_steps[k] = step(output.len(), table).expect("the code reaches beyond a result");
        }
        for block in 0..blocks {
            // SAFETY: the code accesses only the numbers behind its pointers that were checked above, as no
            // block is beyond the last. Outputs and scratch memory are borrowed exclusively, so that they
            // overlap neither each other nor an input.
            unsafe { self.function()(pointers.as_ptr().cast(), scratch.as_mut_ptr().cast()) };
            after(scratch, block);
            for (pointer, &step) in pointers[..reach.count].iter_mut().zip(&steps) {
                // Behind the last block it is not dereferenced.
                *pointer = pointer.wrapping_add(step);
            }
        }
    }
}

/// Memory for code on macOS on ARM (Apple, *Porting just-in-time compilers to Apple silicon*). A thread may
/// either write all such memory of its process or execute it; by default it may execute.
#[cfg(all(target_os = "macos", target_arch = "aarch64"))]
mod jit {
    use core::ffi::{c_int, c_void};
    use core::ptr::NonNull;

    /// `PROT_READ | PROT_WRITE | PROT_EXEC` of `sys/mman.h`.
    const ALL: c_int = 0x1 | 0x2 | 0x4;
    /// `MAP_PRIVATE | MAP_ANON | MAP_JIT`.
    const OF_CODE: c_int = 0x0002 | 0x1000 | 0x0800;
    /// `MAP_FAILED`.
    const FAILED: usize = usize::MAX;

    unsafe extern "C" {
        fn mmap(
            at: *mut c_void,
            len: usize,
            protection: c_int,
            flags: c_int,
            file: c_int,
            offset: i64,
        ) -> *mut c_void;
        fn munmap(start: *mut c_void, len: usize) -> c_int;
        fn pthread_jit_write_protect_np(enabled: c_int);
    }

    /// JIT memory with the code of one kernel.
    #[derive(Debug)]
    pub(super) struct JitMemory {
        start: NonNull<u8>,
        len: usize,
    }

    // SAFETY: the memory is not written after `new` has returned, and it belongs to the process, not to a
    // thread.
    unsafe impl Send for JitMemory {}
    // SAFETY: as above.
    unsafe impl Sync for JitMemory {}

    impl JitMemory {
        /// Memory with this code.
        pub(super) fn new(code: &[u8]) -> std::io::Result<Self> {
            let len = code.len();
            // SAFETY: the system maps new memory, which overlaps no other.
            let start = unsafe { mmap(core::ptr::null_mut(), len, ALL, OF_CODE, -1, 0) };
            let start = NonNull::new(start.cast::<u8>()).filter(|start| start.addr().get() != FAILED);
            let Some(start) = start else { return Err(std::io::Error::last_os_error()) };
            // SAFETY: the memory is as long as the code, and there is no other pointer to it. In between,
            // this thread executes no code in such memory: it only copies, which calls nothing and cannot
            // panic. Other threads continue to execute theirs.
            unsafe {
                pthread_jit_write_protect_np(0);
                core::ptr::copy_nonoverlapping(code.as_ptr(), start.as_ptr(), len);
                pthread_jit_write_protect_np(1);
            }
            // SAFETY: the memory is fully written and not written again.
            super::clear_instruction_cache(unsafe { core::slice::from_raw_parts(start.as_ptr(), len) });
            Ok(Self { start, len })
        }

        #[inline]
        pub(super) fn start(&self) -> *const u8 {
            self.start.as_ptr()
        }
    }

    impl Drop for JitMemory {
        fn drop(&mut self) {
            // SAFETY: the memory was mapped with this length, and code in it runs only while `self` is
            // borrowed.
            unsafe { munmap(self.start.as_ptr().cast(), self.len) };
        }
    }
}

/// On x86-64, instruction fetch is coherent with writes.
#[cfg(not(target_arch = "aarch64"))]
fn clear_instruction_cache(_: &[u8]) {}

/// Makes written instructions visible to instruction fetch, which may have cached this memory before.
#[cfg(all(target_arch = "aarch64", target_vendor = "apple"))]
fn clear_instruction_cache(memory: &[u8]) {
    unsafe extern "C" {
        fn sys_icache_invalidate(start: *const core::ffi::c_void, length: usize);
    }
    // SAFETY: a function of the system's library, which changes no readable memory.
    unsafe { sys_icache_invalidate(memory.as_ptr().cast(), memory.len()) };
}

/// Makes written instructions visible to instruction fetch, which may have cached this memory before.
#[cfg(all(target_arch = "aarch64", windows))]
fn clear_instruction_cache(memory: &[u8]) {
    use core::ffi::c_void;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetCurrentProcess() -> *mut c_void;
        fn FlushInstructionCache(process: *mut c_void, start: *const c_void, length: usize) -> i32;
    }
    // SAFETY: functions of the system's library, which change no readable memory.
    unsafe { FlushInstructionCache(GetCurrentProcess(), memory.as_ptr().cast(), memory.len()) };
}

/// Makes written instructions visible to instruction fetch, which may have cached this memory before (Arm
/// Architecture Reference Manual, section B2.4.4).
#[cfg(all(target_arch = "aarch64", not(target_vendor = "apple"), not(windows)))]
fn clear_instruction_cache(memory: &[u8]) {
    use core::arch::asm;

    /// The shortest cache line of any such processor.
    const LINE: usize = 16;
    // SAFETY: the addresses are in readable memory; cleaning the data cache and invalidating the instruction
    // cache change no number.
    unsafe {
        for line in memory.chunks(LINE) {
            asm!("dc cvau, {}", in(reg) line.as_ptr(), options(nostack, preserves_flags));
        }
        asm!("dsb ish", options(nostack, preserves_flags));
        for line in memory.chunks(LINE) {
            asm!("ic ivau, {}", in(reg) line.as_ptr(), options(nostack, preserves_flags));
        }
        asm!("dsb ish", "isb", options(nostack, preserves_flags));
    }
}

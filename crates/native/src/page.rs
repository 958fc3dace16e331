//! Memory that holds machine code, and the call into it. All unsafe code of this crate is in this file.
//!
//! A page is written first and made executable then; it is never both at once. The code was made by [`Code::new`](crate::Code::new): it is
//! a function of the System V convention, of two pointers, that
//! - reads and writes the tables of the first pointer within the lengths that are checked here before each call,
//! - reads and writes the scratch memory of the second within a length that is checked here,
//! - reads constants behind itself,
//! - and returns, with the registers that the convention preserves as they were.
#![allow(unsafe_code)]

use memmap2::{Mmap, MmapMut};

use crate::code::MOST_TABLES;

/// The code as a function.
#[cfg(target_arch = "x86_64")]
type Function = unsafe extern "sysv64" fn(tables: *const *mut (), scratch: *mut ());
#[cfg(not(target_arch = "x86_64"))]
type Function = unsafe extern "C" fn(tables: *const *mut (), scratch: *mut ());

/// Executable memory with the code of one kernel.
#[derive(Debug)]
pub(crate) struct Page {
    memory: Mmap,
}

/// A table of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    /// Numbers of one state.
    pub(crate) width: usize,
    /// Numbers that the code reads or writes in one run.
    pub(crate) reach: usize,
}

/// How far the code reaches from each of its pointers.
#[derive(Clone, Debug)]
pub(crate) struct Reach {
    pub(crate) inputs: Vec<Table>,
    pub(crate) outputs: Vec<Table>,
    pub(crate) scratch: usize,
}

impl Page {
    /// Writes code into memory of its own and makes that executable.
    pub(crate) fn new(code: &[u8]) -> std::io::Result<Self> {
        let mut memory = MmapMut::map_anon(code.len())?;
        memory.copy_from_slice(code);
        let memory = memory.make_exec()?;
        clear_instruction_cache(&memory);
        Ok(Self { memory })
    }

    /// Runs the code once, from this row of its tables on.
    ///
    /// # Panics
    /// If a slice is shorter than the code reaches, or there are other numbers of slices.
    #[inline]
    pub(crate) fn run<T>(
        &self,
        reach: &Reach,
        row: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        scratch: &mut [T],
    ) {
        assert!(
            inputs.len() == reach.inputs.len()
                && outputs.len() == reach.outputs.len()
                && inputs.len() + outputs.len() <= MOST_TABLES
                && scratch.len() >= reach.scratch,
            "the code has other tables"
        );
        // Numbers before a row, if the slice holds as much as the code reaches from there on.
        let begin = |length: usize, table: Table| {
            let begin = row.checked_mul(table.width)?;
            (length.checked_sub(begin)? >= table.reach).then_some(begin)
        };
        let mut tables = [core::ptr::null_mut::<()>(); MOST_TABLES];
        let (of_inputs, of_outputs) = tables.split_at_mut(inputs.len());
        for ((pointer, input), &table) in of_inputs.iter_mut().zip(inputs).zip(&reach.inputs) {
            let begin = begin(input.len(), table).expect("the code reaches beyond an argument");
            *pointer = input[begin..].as_ptr().cast_mut().cast();
        }
        for ((pointer, output), &table) in of_outputs.iter_mut().zip(outputs).zip(&reach.outputs) {
            let begin = begin(output.len(), table).expect("the code reaches beyond a result");
            *pointer = output[begin..].as_mut_ptr().cast();
        }
        // SAFETY: the memory holds a whole function of this type, made by this crate for the instructions of this processor, and lives as
        // long as `self`.
        let function: Function = unsafe { core::mem::transmute(self.memory.as_ptr()) };
        // SAFETY: from its pointers on the code reads and writes as much as was checked above. Outputs and scratch memory are borrowed
        // exclusively, so that they overlap neither each other nor an input.
        unsafe { function(tables.as_ptr(), scratch.as_mut_ptr().cast()) };
    }
}

/// Instructions of x86-64 are read as they were written.
#[cfg(not(target_arch = "aarch64"))]
fn clear_instruction_cache(_: &[u8]) {}

/// Makes written instructions visible to the core that reads instructions, which may have read this memory before (Arm Architecture
/// Reference Manual, section B2.4.4).
#[cfg(target_arch = "aarch64")]
fn clear_instruction_cache(memory: &[u8]) {
    use core::arch::asm;

    /// The shortest line of any such processor.
    const LINE: usize = 16;
    // SAFETY: the addresses are of memory that can be read; cleaning the data cache and invalidating the instruction cache change no number.
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

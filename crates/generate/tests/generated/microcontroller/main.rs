//! A program for a Cortex-M4 with a floating-point unit. It runs generated code, compares bits, and counts
//! instructions and the stack.
//!
//! It has no dependencies: the vector table, semihosting (access to the debugger) and SysTick (the clock) are
//! defined here. The test writes `cases.rs`: tables, and a call of `run` for each function.
#![no_std]
#![no_main]

use core::arch::{asm, global_asm};
use core::fmt::{self, Write};
use core::hint::black_box;
use core::ptr::{read_volatile, write_volatile};

mod robot {
    include!("src/robot.rs");
}

// The processor reads the initial stack pointer and the reset vector from address 0. The floating-point unit
// must be enabled (CPACR).
global_asm!(
    ".section .vectors, \"a\"",
    ".word STACK_TOP",
    ".word start",
    ".rept 14",
    ".word fault",
    ".endr",
    ".text",
    ".thumb_func",
    ".global start",
    "start:",
    "ldr r0, =0xe000ed88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xf00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bl main",
    ".thumb_func",
    "fault:",
    "bl failed",
);

/// A request to the debugger, here the emulator.
fn semihosting(operation: u32, argument: *const u32) {
    // SAFETY: the emulator reads the memory that `argument` points to, and writes none.
    unsafe { asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument) };
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            semihosting(3, &u32::from(byte)); // SYS_WRITEC
        }
        Ok(())
    }
}

fn exit(status: u32) -> ! {
    semihosting(0x20, [0x20026, status].as_ptr()); // SYS_EXIT_EXTENDED
    loop {}
}

#[unsafe(no_mangle)]
extern "C" fn failed() -> ! {
    let _ = writeln!(Console, "fault");
    exit(2)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}");
    exit(1)
}

/// Ticks of the clock during `work`; it counts down from 2²⁴ - 1.
fn ticks(work: impl FnOnce()) -> u32 {
    const CONTROL: *mut u32 = 0xe000_e010 as *mut u32;
    const MOST: u32 = 0xff_ffff;
    // SAFETY: the registers of SysTick, which nothing else uses.
    unsafe {
        write_volatile(CONTROL.add(1), MOST);
        write_volatile(CONTROL.add(2), 0);
        write_volatile(CONTROL, 5);
        // The counter starts at 0 and is reloaded one tick later.
        while read_volatile(CONTROL.add(2)) == 0 {}
        let before = read_volatile(CONTROL.add(2));
        work();
        let after = read_volatile(CONTROL.add(2));
        assert!(read_volatile(CONTROL) & 0x1_0000 == 0, "the clock has run out");
        before - after
    }
}

/// Instructions per thousand ticks, measured with a loop of two instructions.
fn instructions_per_thousand_ticks() -> u32 {
    const TURNS: u32 = 2_000_000;
    // SAFETY: the loop decrements a register.
    let ticks = ticks(|| unsafe { asm!("2:", "subs {0}, #1", "bne 2b", inout(reg) TURNS => _) });
    (u64::from(2 * TURNS) * 1000 / u64::from(ticks)) as u32
}

/// Bytes of the stack that `work` writes.
#[inline(never)]
fn stack(work: impl FnOnce()) -> usize {
    const PAINT: u32 = 0xa5a5_a5a5;
    const DEPTH: usize = 0x8000;
    let here: usize;
    // SAFETY: the instruction reads the stack pointer.
    unsafe { asm!("mov {}, sp", out(reg) here) };
    let lowest = here - 4 * DEPTH;
    // SAFETY: the memory below the stack pointer is unused, and there are 4 MiB of it.
    unsafe {
        (0..DEPTH).for_each(|k| write_volatile((lowest as *mut u32).add(k), PAINT));
        work();
        let untouched = (0..DEPTH).find(|&k| read_volatile((lowest as *const u32).add(k)) != PAINT);
        4 * (DEPTH - untouched.unwrap_or(DEPTH))
    }
}

const CALLS: u32 = 100;

/// Compares a function's results with the library's bits, state by state, and prints the cost of a call.
fn run<const N: usize>(name: &str, expected: &[[u32; N]], call: impl Fn(usize, &mut [f32; N])) {
    let mut out = [0.0; N];
    let mut bits = 0;
    for (state, expected) in expected.iter().enumerate() {
        call(state, &mut out);
        for (k, (x, &y)) in out.iter().zip(expected).enumerate() {
            assert!(x.to_bits() == y, "{name}, state {state}, number {k}: {:08x}, not {y:08x}", x.to_bits());
            bits += 32;
        }
    }
    let bytes = stack(|| call(black_box(0), black_box(&mut out)));
    let ticks = ticks(|| (0..CALLS).for_each(|_| call(black_box(0), black_box(&mut out))));
    let instructions = u64::from(ticks) * u64::from(instructions_per_thousand_ticks()) / 1000 / u64::from(CALLS);
    let _ = writeln!(Console, "{name}: {bits} bits, {instructions} instructions, {bytes} bytes of stack");
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    cases();
    exit(0)
}

include!("cases.rs");

//! A process that is a copy of another one calls the kernels that it has from that. This test is alone in its process.
#![cfg(unix)]
#![allow(unsafe_code)] // `fork` and what belongs to it

use expression::{Arithmetic, Traced, trace};
use native::{Kernel, Width, best_instructions};
use number::Scalar;

/// x times a factor.
fn kernel(factor: f64) -> Option<Kernel<f64>> {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * Traced::from_f64(factor)]]);
    Kernel::compile(&graph, &results, &[1], arithmetic, best_instructions(), Width::One).ok()
}

fn multiplies(kernel: &Kernel<f64>, factor: f64) -> bool {
    let mut scratch = vec![0.0; kernel.scratch_len()];
    (0..1000).all(|k| {
        let (x, mut y) = (f64::from(k), [0.0]);
        kernel.call(&[&[x]], &mut [&mut y], &mut scratch).is_ok() && y[0] == x * factor
    })
}

/// What the child does; it drops the kernel as well.
fn child(kernel: Kernel<f64>) -> bool {
    let of_parent = multiplies(&kernel, 3.0);
    drop(kernel);
    of_parent && self::kernel(5.0).is_some_and(|own| multiplies(&own, 5.0))
}

/// A child after `fork` calls a kernel of its parent, compiles one of its own, and takes nothing from its parent by dropping.
#[test]
fn a_forked_child_calls_the_kernels_of_its_parent() {
    let Some(kernel) = kernel(3.0) else {
        return println!("left out: there is no encoder for this processor");
    };
    // SAFETY: the child calls functions of this crate and of the allocator alone, which the system's library keeps usable after `fork`; it
    // ends without returning.
    let process = unsafe { libc::fork() };
    if process == 0 {
        let code = i32::from(!child(kernel));
        // SAFETY: ends this process without running anything of the parent's.
        unsafe { libc::_exit(code) };
    }
    assert!(process > 0, "{}", std::io::Error::last_os_error());
    let mut status = 0;
    // SAFETY: the status is a number of this function.
    let waited = unsafe { libc::waitpid(process, &raw mut status, 0) };
    assert_eq!(waited, process);
    assert!(libc::WIFEXITED(status) && libc::WEXITSTATUS(status) == 0, "the child ended with {status:#x}");
    assert!(multiplies(&kernel, 3.0));
}

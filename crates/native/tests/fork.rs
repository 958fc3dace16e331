//! A forked process calls the kernels of its parent. This test runs alone in its process.
#![cfg(unix)]
#![allow(unsafe_code)] // `fork` and what belongs to it

use robot_dynamics_expression::{Arithmetic, Traced, trace};
use robot_dynamics_native::{Kernel, Width, best_instructions};
use robot_dynamics_number::Scalar;

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

/// The computation of the child, which drops the kernel as well.
fn child(kernel: Kernel<f64>) -> bool {
    let of_parent = multiplies(&kernel, 3.0);
    drop(kernel);
    of_parent && self::kernel(5.0).is_some_and(|own| multiplies(&own, 5.0))
}

/// A forked child calls a kernel of its parent and compiles one of its own. Dropping a kernel in the child
/// leaves the parent's intact.
#[test]
fn a_forked_child_calls_the_kernels_of_its_parent() {
    let Some(kernel) = kernel(3.0) else {
        return println!("left out: there is no encoder for this processor");
    };
    // SAFETY: the child calls only functions of this crate and of the allocator, which the system's library
    // keeps usable after `fork`; it ends without returning.
    let process = unsafe { libc::fork() };
    if process == 0 {
        let code = i32::from(!child(kernel));
        // SAFETY: ends this process without running handlers of the parent.
        unsafe { libc::_exit(code) };
    }
    assert!(process > 0, "{}", std::io::Error::last_os_error());
    let mut status = 0;
    // SAFETY: the status is a local variable.
    let waited = unsafe { libc::waitpid(process, &raw mut status, 0) };
    assert_eq!(waited, process);
    assert!(libc::WIFEXITED(status) && libc::WEXITSTATUS(status) == 0, "the child ended with {status:#x}");
    assert!(multiplies(&kernel, 3.0));
}

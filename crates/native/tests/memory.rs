//! The memory of dropped kernels. This test runs alone in its process, because other tests map executable
//! memory as well.
#![cfg(target_os = "linux")]

use robot_dynamics_expression::{Arithmetic, trace};
use robot_dynamics_native::{Kernel, Width, best_instructions};

/// Bytes of executable memory that belongs to no file.
fn executable_bytes() -> usize {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let size = |line: &str| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let (begin, end) = fields[0].split_once('-')?;
        let is_ours = fields[1].starts_with("r-x") && fields.len() == 5;
        let [begin, end] = [begin, end].map(|text| usize::from_str_radix(text, 16).unwrap());
        is_ours.then_some(end - begin)
    };
    maps.lines().filter_map(size).sum()
}

/// Bytes of resident memory of the process.
fn resident_bytes() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let kilobytes: usize = line.trim().trim_end_matches(" kB").parse().unwrap();
    kilobytes << 10
}

fn kernel(width: Width) -> Option<Kernel<f64>> {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] + x[0][0]]]);
    Kernel::compile(&graph, &results, &[1], arithmetic, best_instructions(), width).ok()
}

/// Makes a kernel, calls it, and drops it.
fn make_and_drop(number: usize) {
    let width = if number.is_multiple_of(2) { Width::One } else { Width::Lanes };
    let Some(kernel) = kernel(width) else { return };
    let (x, mut y, mut scratch) = (number as f64, [0.0; 3], vec![0.0; kernel.scratch_len()]);
    let is_finite = kernel.call_rows(3, &[&[x, 1.0, 2.0]], &mut [&mut y], &mut scratch, |_| {});
    assert!(is_finite && y == [2.0 * x, 2.0, 4.0]);
}

/// Dropping a kernel releases its memory. Ten thousand kernels would take 40 MB.
#[test]
fn dropped_kernels_leave_no_memory() {
    let before = executable_bytes();
    let kept: Vec<Kernel<f64>> = (0..500).map_while(|_| kernel(Width::One)).collect();
    // Under an emulator, the maps are those of the emulator.
    let is_shown = executable_bytes() >= before + (500 << 12);
    if kept.is_empty() || !is_shown {
        return println!("left out: the system does not show executable memory");
    }
    drop(kept);
    // After the first kernels the allocator has reserved its memory.
    (0..1000).for_each(make_and_drop);
    let resident = resident_bytes();
    (0..10_000).for_each(make_and_drop);
    assert!(executable_bytes() < before + (1 << 20));
    assert!(resident_bytes() < resident + (4 << 20), "{resident}, then {}", resident_bytes());
}

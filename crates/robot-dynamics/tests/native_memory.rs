//! The memory of models that are loaded, called and dropped. This test is alone in its process, because
//! others allocate memory, too.
#![cfg(all(feature = "native", target_os = "linux"))]
#![allow(missing_docs)]

use robot_dynamics::algorithms::{inverse_dynamics, mass_matrix};
use robot_dynamics::load;
use robot_dynamics::model::Workspace;

/// The resident memory of the process in bytes.
fn resident_bytes() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").expect("the kernel's file");
    let line =
        status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line of resident memory");
    let kilobytes: usize = line.trim().trim_end_matches(" kB").parse().expect("a count");
    kilobytes << 10
}

/// Loads a robot, calls it so that machine code is compiled, and drops it. Returns the number of functions
/// with machine code.
fn load_and_drop() -> usize {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    let model = load(file).expect("a robot").model;
    let w = &mut Workspace::new(&model);
    let (mut tau, mut mass) = ([0.0; 2], [0.0; 4]);
    inverse_dynamics(&model, w, &[0.3, 0.4], &[0.0; 2], &[1.0, 2.0], &mut tau);
    mass_matrix(&model, w, &[0.3, 0.4], &mut mass);
    assert!(tau[0] > 0.0 && mass[0] > mass[3] && mass[3] > 0.0);
    model.native().functions.iter().filter(|used| used.route.is_ok()).count()
}

/// The kernels of ten thousand models would take 80 MB of pages if they were not released.
#[test]
fn dropped_models_leave_no_memory() {
    // After the first models the allocator keeps the memory that it needs later.
    let compiled: usize = (0..1000).map(|_| load_and_drop()).sum();
    let before = resident_bytes();
    (0..10_000).for_each(|_| assert_eq!(load_and_drop(), compiled / 1000));
    let after = resident_bytes();
    assert!(after < before + (8 << 20), "{before} bytes, then {after}");
}

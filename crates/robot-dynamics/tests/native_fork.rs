//! A forked process can call robots that its parent loaded. This test is alone in its process.
#![cfg(all(feature = "native", unix))]
#![allow(missing_docs)]
#![allow(unsafe_code)] // `fork` and what belongs to it

use robot_dynamics::algorithms::{gravity, inverse_dynamics, mass_matrix};
use robot_dynamics::load;
use robot_dynamics::model::{Model, Workspace};

fn loaded() -> Model {
    load(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf")).expect("a robot").model
}

/// Forces by machine code that the parent compiled, and M and g, which the child compiles.
fn compute(model: &Model, with_matrices: bool) -> Vec<f64> {
    let (nv, w) = (model.nv(), &mut Workspace::new(model));
    let numbers = |first: f64| (0..nv).map(|k| first + 0.1 * k as f64).collect::<Vec<f64>>();
    let (q, v, a) = (numbers(0.2), numbers(-0.3), numbers(0.4));
    let (mut tau, mut g, mut mass) = (vec![0.0; nv], vec![0.0; nv], vec![0.0; nv * nv]);
    inverse_dynamics(model, w, &q, &v, &a, &mut tau);
    if with_matrices {
        gravity(model, w, &q, &mut g);
        mass_matrix(model, w, &q, &mut mass);
    }
    [tau, g, mass].concat()
}

#[test]
fn a_forked_child_calls_the_robot_of_its_parent() {
    let model = loaded();
    // The expected numbers come from another copy of the robot, which is compiled in the parent.
    let (in_parent, expected) = (compute(&model, false), compute(&loaded(), true));
    // SAFETY: no other thread of this process holds the lock of the allocator; the child only calls the
    // library, and exits without returning.
    let process = unsafe { libc::fork() };
    if process == 0 {
        let is_same = compute(&model, true) == expected;
        drop(model);
        // SAFETY: ends this process without running any code of the parent.
        unsafe { libc::_exit(i32::from(!is_same)) };
    }
    assert!(process > 0, "{}", std::io::Error::last_os_error());
    let mut status = 0;
    // SAFETY: the status is a local number of this function.
    let waited = unsafe { libc::waitpid(process, &raw mut status, 0) };
    assert_eq!(waited, process);
    assert!(libc::WIFEXITED(status) && libc::WEXITSTATUS(status) == 0, "the child ended with {status:#x}");
    assert_eq!(compute(&model, false), in_parent);
    assert_eq!(compute(&model, true), expected);
}

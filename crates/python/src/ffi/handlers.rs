//! The C functions that XLA calls.

use super::xla::{CallFrame, Failure, Handler, handle};

/// A C function of each piece of work.
macro_rules! handlers {
    ($($name:ident: $work:path;)*) => {
        /// The handlers by the names of their targets.
        pub(crate) const HANDLERS: &[(&str, Handler)] = &[$((stringify!($name), $name)),*];
        $(
            unsafe extern "C" fn $name(frame: *mut CallFrame) -> *mut Failure {
                // SAFETY: only XLA has the pointer, see `capsule`.
                unsafe { handle(frame, $work) }
            }
        )*
    };
}

handlers! {
    robot_dynamics_cpu_function: crate::device::cpu_call;
    robot_dynamics_cuda_function: crate::device::cuda_call;
    robot_dynamics_row: crate::xla::row;
    robot_dynamics_rollout: crate::xla::rollout;
    robot_dynamics_rollout_tangent: crate::xla::rollout_tangent;
    robot_dynamics_rollout_pullback: crate::xla::rollout_pullback;
}

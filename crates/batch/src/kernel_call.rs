//! Calls of a recursion from a batch's kernel.

use robot_dynamics_core::workspace::compiled_once::{TreeKernel, run};
use robot_dynamics_core::workspace::tree::{TreeMemory, TreeStorage};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::dispatch::{Call, Hardware, Kernel};

/// Runs a kernel from another one as a function call, so that a common part of several kernels is compiled
/// once.
#[inline(always)]
pub(super) fn call<H: Hardware, N: Scalar, K: TreeKernel<N>>(tree: &mut TreeMemory<N>, kernel: K) {
    if const { N::IS_FLOAT } {
        run(tree, kernel);
    } else {
        H::call(KernelWithMemory { tree, kernel });
    }
}

/// A kernel and its memory.
struct KernelWithMemory<'a, N: Scalar, K> {
    tree: &'a mut TreeMemory<N>,
    kernel: K,
}

impl<N: Scalar, K: Kernel<TreeStorage, N>> Call for KernelWithMemory<'_, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<N, H>(self.tree);
    }
}

//! A recursion within a batch's kernel.

use number::Scalar;
use number::dispatch::{Call, Hardware, Kernel};

use crate::scratch::compiled_once::{CompiledKernel, OverNumber, run};
use crate::scratch::tree::TreeMemory;

/// Runs a kernel within another one, as a call: what several kernels begin with is compiled once for all of them.
#[inline(always)]
pub(super) fn call<H: Hardware, N: Scalar, K: CompiledKernel<N>>(tree: &mut TreeMemory<N>, kernel: K) {
    if const { N::IS_FLOAT } {
        run(tree, kernel);
    } else {
        H::call(OnMemory { tree, kernel });
    }
}

/// A kernel and the memory it runs on.
struct OnMemory<'a, N: Scalar, K> {
    tree: &'a mut TreeMemory<N>,
    kernel: K,
}

impl<N: Scalar, K: Kernel<OverNumber, N>> Call for OnMemory<'_, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<N, H>(self.tree);
    }
}

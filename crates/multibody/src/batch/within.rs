//! A recursion within a batch's kernel.

use number::Scalar;
use number::dispatch::{Call, Hardware, Kernel};

use crate::Workspace;
use crate::scratch::compiled_once::{CompiledKernel, OverNumber, run};

/// Runs a kernel within another one, as a call: what several kernels begin with is compiled once for all of them.
#[inline(always)]
pub(super) fn call<H: Hardware, N: Scalar, K: CompiledKernel<N>>(workspace: &mut Workspace<N>, kernel: K) {
    if const { N::IS_FLOAT } {
        run(workspace, kernel);
    } else {
        H::call(OnWorkspace { workspace, kernel });
    }
}

/// A kernel and the workspace it runs on.
struct OnWorkspace<'a, N: Scalar, K> {
    workspace: &'a mut Workspace<N>,
    kernel: K,
}

impl<N: Scalar, K: Kernel<OverNumber, N>> Call for OnWorkspace<'_, N, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<N, H>(self.workspace);
    }
}

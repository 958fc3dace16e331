"""PyTorch: the dynamics as differentiable functions of tensors.

Tensors are on the CPU, float64 or float32, and may have any leading dimensions, which broadcast as everywhere in this
package. Gradients are vector-Jacobian products in O(n), without a Jacobian or M; `torch.func.vmap` and `torch.func.grad`
work. A gradient by q is by its nq numbers; of a quaternion it is that of a function that depends on its direction alone,
so an optimiser's step has to be normalised (`Robot.normalize`). Second derivatives are refused.

    import torch
    import robot_dynamics as rd
    from robot_dynamics.torch import inverse_dynamics

    robot = rd.example("panda")
    q = torch.zeros(1000, 7, dtype=torch.float64, requires_grad=True)
    rest = torch.zeros(7, dtype=torch.float64)
    effort = inverse_dynamics(robot, q, rest, rest).square().sum()
    effort.backward()                       # q.grad (1000, 7): where to bend to hold less
"""

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import torch

    from robot_dynamics.robot import Robot


def inverse_dynamics(robot: "Robot", q: "torch.Tensor", v: "torch.Tensor", a: "torch.Tensor") -> "torch.Tensor":
    """τ = M(q) a + C(q, v) v + g(q), (..., nv) [N·m or N], differentiable by q, v and a.

    q (..., nq), v (..., nv), a (..., nv). Raises what `Robot.inverse_dynamics` does.
    """
    forces: torch.Tensor = _functions()[0].apply(robot, q, v, a)
    return forces


def forward_dynamics(robot: "Robot", q: "torch.Tensor", v: "torch.Tensor", tau: "torch.Tensor") -> "torch.Tensor":
    """a = M⁻¹(τ − C v − g), (..., nv) [rad/s² or m/s²], differentiable by q, v and τ.

    q (..., nq), v (..., nv), tau (..., nv) [N·m or N]. Raises what `Robot.forward_dynamics` does.
    """
    acceleration: torch.Tensor = _functions()[1].apply(robot, q, v, tau)
    return acceleration


@cache
def _functions() -> tuple[Any, Any]:
    """The two as classes of torch, made when they are first needed: this package does not depend on it."""
    try:
        import torch
    except ImportError as error:
        raise ImportError("robot_dynamics.torch needs PyTorch: pip install torch") from error

    class Pullback(torch.autograd.Function):
        """Gradients of a solution as a function of their own, for `vmap`."""

        @staticmethod
        def forward(robot: Any, solution: str, q: Any, v: Any, x: Any, cotangent: Any) -> Any:
            state = [_array(each) for each in (q, v, x, cotangent)]
            by_q, by_v, by_x = getattr(robot, f"{solution}_pullback")(*state)
            by_q = robot.cotangent_to_coordinates(state[0], by_q)
            gradients = (torch.as_tensor(each) for each in (by_q, by_v, by_x))
            # What went with a whole batch has the sum.
            return tuple(own.sum_to_size(of.shape) for own, of in zip(gradients, (q, v, x), strict=True))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.solution = inputs[1]

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise RuntimeError(f"{ctx.solution}: its second derivatives are not known here, only the first")

        @staticmethod
        def vmap(info: Any, dims: Any, robot: Any, solution: str, *state: Any) -> Any:
            aligned = _aligned(state, dims[2:], info.batch_size)
            gradients = Pullback.apply(robot, solution, *(tensor for tensor, _ in aligned))
            own = tuple(each.reshape(shape) for each, (_, shape) in zip(gradients, aligned, strict=False))
            return own, (0, 0, 0)

    def differentiable(solution: str) -> Any:
        class Solution(torch.autograd.Function):
            @staticmethod
            def forward(robot: Any, q: Any, v: Any, x: Any) -> Any:
                return torch.as_tensor(getattr(robot, solution)(*map(_array, (q, v, x))))

            @staticmethod
            def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
                ctx.robot = inputs[0]
                ctx.save_for_backward(*inputs[1:])

            @staticmethod
            def backward(ctx: Any, cotangent: Any) -> Any:
                return None, *Pullback.apply(ctx.robot, solution, *ctx.saved_tensors, cotangent)

            @staticmethod
            def vmap(info: Any, dims: Any, robot: Any, *state: Any) -> Any:
                aligned = _aligned(state, dims[1:], info.batch_size)
                return Solution.apply(robot, *(tensor for tensor, _ in aligned)), 0

        return Solution

    return differentiable("inverse_dynamics"), differentiable("forward_dynamics")


def _array(tensor: Any) -> np.ndarray[Any, Any]:
    """The numbers of a tensor, where they lie."""
    if not hasattr(tensor, "detach"):
        raise TypeError(f"expected a tensor, found {type(tensor).__name__}; torch.as_tensor makes one of an array")
    if tensor.device.type != "cpu":
        raise TypeError(f"the tensor is on {tensor.device}, this package computes on the CPU: give it tensor.cpu()")
    return np.asarray(tensor.detach())


def _aligned(state: Any, dims: Any, size: int) -> list[tuple[Any, tuple[int, ...]]]:
    """Each tensor with the mapped axis first and as many others as the rest have, and its shape without these."""
    moved = [
        tensor.unsqueeze(0).expand(size, *tensor.shape) if axis is None else tensor.movedim(axis, 0)
        for tensor, axis in zip(state, dims, strict=True)
    ]
    most = max(tensor.ndim for tensor in moved)
    ones = [(1,) * (most - tensor.ndim) for tensor in moved]
    return [
        (tensor.reshape(size, *one, *tensor.shape[1:]), tuple(tensor.shape))
        for tensor, one in zip(moved, ones, strict=True)
    ]

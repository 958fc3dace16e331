"""PyTorch: the dynamics as differentiable functions of tensors.

Tensors are on the CPU, float64 or float32, and may have any leading dimensions, which broadcast as everywhere
in this package. Gradients are vector-Jacobian products in O(n), without a Jacobian or M; `torch.func.vmap`
and `torch.func.grad` work. A gradient by q is by its nq numbers; of a quaternion it is that of a function
that depends on its direction alone, so an optimiser's step has to be normalised (`Robot.normalize`). Second
derivatives are refused. Results of an invalid state (not finite, a quaternion not of unit length, a singular
M) are NaN, and those of the other states are right; so it is for parameters that are not finite.

    import torch
    import robot_dynamics as rd
    from robot_dynamics.torch import inverse_dynamics

    robot = rd.example("panda")
    q = torch.zeros(1000, 7, dtype=torch.float64, requires_grad=True)
    rest = torch.zeros(7, dtype=torch.float64)
    effort = inverse_dynamics(robot, q, rest, rest).square().sum()
    effort.backward()                       # q.grad (1000, 7): where to bend to hold less

`step` and `rollout` move states, with gradients by the start and by the torques. All four take `parameters`,
with gradients: `Robot.parameters()`, the robot's inertias, armatures, damping, friction, springs and gravity.
Friction's sign is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from robot_dynamics.errors import BadStatesError, SimulationError, SingularMassError, StateError
from robot_dynamics.motion import disabled_effects

if TYPE_CHECKING:
    import torch

    from robot_dynamics.robot import Robot


def inverse_dynamics(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor,
    a: torch.Tensor,
    *,
    parameters: torch.Tensor | None = None,
) -> torch.Tensor:
    """τ = M(q) a + C(q, v) v + g(q), (..., nv) [N·m or N], differentiable by q, v, a and parameters.

    q (..., nq), v (..., nv), a (..., nv). `parameters` (n,) are those of the robot that is computed, as
    `Robot.parameters()` lists them: `robot` gives the geometry.
    """
    forces: torch.Tensor = _functions()[0].apply(robot, q, v, a, parameters)
    return forces


def forward_dynamics(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor,
    tau: torch.Tensor,
    *,
    parameters: torch.Tensor | None = None,
) -> torch.Tensor:
    """a = M⁻¹(τ − C v − g), (..., nv) [rad/s² or m/s²], differentiable by q, v, τ and parameters.

    q (..., nq), v (..., nv), tau (..., nv) [N·m or N], `parameters` as for `inverse_dynamics`.
    """
    acceleration: torch.Tensor = _functions()[1].apply(robot, q, v, tau, parameters)
    return acceleration


class Rollout(NamedTuple):
    """The motions of many states."""

    q: torch.Tensor
    """Where they end, (..., nq)."""
    v: torch.Tensor
    """(..., nv)"""
    q_trajectory: torch.Tensor
    """The states after each `stride` steps, (..., samples, nq)."""
    v_trajectory: torch.Tensor
    """(..., samples, nv)"""


def rollout(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor | None = None,
    tau: torch.Tensor | None = None,
    *,
    steps: int,
    dt: float = 1e-3,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    parameters: torch.Tensor | None = None,
) -> Rollout:
    """`Robot.rollout` of tensors, differentiable by q, v, tau and parameters.

    q (..., nq), v (..., nv) or none for 0, tau (..., nv) held over all steps or (..., steps, nv), with one
    dimension more than the states. `parameters` (n,) are those of the robot to move, as `Robot.parameters()`
    lists them: `robot` gives the geometry. The way back computes the states again from √steps checkpoints, in
    O(n) a step. Effects act as in `Robot.rollout_pullback`; those without gradients are left out or refused.
    """
    _check_torch()
    import torch

    lead = torch.broadcast_shapes(q.shape[:-1], () if v is None else v.shape[:-1])
    v = q.new_zeros(robot.nv) if v is None else v
    own = 1
    if tau is not None:
        own = 2 if tau.ndim > len(lead) + 1 else 1
        if own == 2 and tau.shape[-2] != steps:
            raise ValueError(f"tau has shape {tuple(tau.shape)}: its last axis but one must have steps = {steps}")
        lead = torch.broadcast_shapes(lead, tau.shape[:-own])
        tau = tau.broadcast_to(*lead, *tau.shape[-own:])
    off = disabled_effects(without, dissipation, stops=True)
    how = {"steps": steps, "dt": dt, "integrator": integrator, "stride": stride}
    how |= {"conservative": conservative, "without": off}
    robot._differentiable_row(dt=dt, integrator=integrator, conservative=conservative, without=off)  # or an error
    q, v = q.broadcast_to(*lead, q.shape[-1]), v.broadcast_to(*lead, v.shape[-1])
    return Rollout(*_motions()[0].apply(robot, how, q, v, tau, parameters))


def step(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor,
    tau: torch.Tensor | None = None,
    *,
    dt: float,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    parameters: torch.Tensor | None = None,
) -> tuple[torch.Tensor, torch.Tensor]:
    """q and v after one step of `dt` seconds, differentiable by q, v, tau and parameters; as `rollout` of
    one step.

    q (..., nq), v (..., nv), tau (..., nv).
    """
    _check_torch()
    import torch

    if tau is not None:
        q = q.broadcast_to(*torch.broadcast_shapes(q.shape[:-1], tau.shape[:-1]), q.shape[-1])
    how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without}
    end = rollout(robot, q, v, tau, steps=1, dt=dt, dissipation=dissipation, parameters=parameters, **how)
    return end.q, end.v


def _check_torch() -> None:
    """This package does not depend on torch, which is a gigabyte; whoever calls this module needs it."""
    try:
        import torch  # noqa: F401
    except ImportError as error:
        raise ImportError("robot_dynamics.torch needs PyTorch: pip install torch") from error


_ONE_ROBOT = "parameters are mapped over: one robot moves all states; loop over robots"


@lru_cache(maxsize=8)
def _with_parameters(robot: Robot, numbers: bytes) -> Robot:
    return robot.with_parameters(np.frombuffer(numbers), as_written=True)


def _of(robot: Robot, parameters: Any) -> Robot:
    """The robot with these parameters, if any."""
    if parameters is None:
        return robot
    if parameters.ndim != 1:
        raise ValueError(_ONE_ROBOT)
    return _with_parameters(robot, _array(parameters).astype(np.float64).tobytes())


Arrays: TypeAlias = tuple[Any, ...]


def _computed(robot: Robot, name: str, own: Any, /, *given: Any, **options: Any) -> Arrays:
    """The results of a method of the robot, or of one with `own` parameters; NaN in the rows of invalid
    states."""
    if own is not None and not np.isfinite(_array(own)).all():
        return tuple(x if x is None else np.full_like(x, np.nan) for x in _computed(robot, name, None, *given, **options))
    method = getattr(_of(robot, own), name)
    try:
        return _parts(method(*given, **options))
    except BadStatesError as error:
        return _parts(error.result)
    except (SimulationError, SingularMassError, StateError):
        # One state; as a batch of one it has a row.
        batch = [_lifted(x) for x in given]
        named = {key: _lifted(x) for key, x in options.items()}
        try:
            found = method(*batch, **named)
        except BadStatesError as error:
            found = error.result
        return tuple(x if x is None else x[0] for x in _parts(found))


def _lifted(x: Any) -> Any:
    return x[np.newaxis] if isinstance(x, np.ndarray) else x


def _parts(found: Any) -> Arrays:
    """The arrays of a result."""
    if isinstance(found, np.ndarray):
        return (found,)
    return tuple(found) if isinstance(found, tuple) else (found.q, found.v, found.q_trajectory, found.v_trajectory)


@cache
def _motions() -> tuple[Any, Any]:
    """Rollouts and their gradients as classes of torch."""
    _check_torch()
    import torch


    class Pullback(torch.autograd.Function):
        """Gradients by the start, the torques and the parameters, those of each state; empty for what is not
        there."""

        @staticmethod
        def forward(
            robot: Any, how: Any, by_parameters: bool, q: Any, v: Any, tau: Any, parameters: Any, *rest: Any
        ) -> Any:
            start, speed, q_end, q_way, *cotangents = (_array(each) for each in (q, v, *rest))
            by_end, by_end_velocity, by_way, by_way_velocity = cotangents
            (by_position,) = _computed(robot, "cotangent_from_coordinates", None, q_end, by_end)
            given = {"by_position": by_position, "by_velocity": by_end_velocity}
            if how["stride"]:
                (by_way,) = _computed(robot, "cotangent_from_coordinates", None, q_way, by_way)
                given |= {"by_position_trajectory": by_way, "by_velocity_trajectory": by_way_velocity}
            forces = None if tau is None else _array(tau)
            options = {"parameters": by_parameters, **given, **how}
            by_start, *rest_of = _computed(robot, "rollout_pullback", parameters, start, speed, forces, **options)
            (by_q,) = _computed(robot, "cotangent_to_coordinates", None, start, by_start)
            results = (by_q, *rest_of)
            nothing = q.new_zeros((*q.shape[:-1], 0))
            return tuple(nothing.clone() if each is None else torch.as_tensor(each) for each in results)

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise RuntimeError("rollout: its second derivatives are not known here, only the first")

        @staticmethod
        def vmap(info: Any, dims: Any, robot: Any, how: Any, by_parameters: bool, *given: Any) -> Any:
            return Pullback.apply(robot, how, by_parameters, *_in_front(given, dims[3:], info.batch_size)), (0, 0, 0, 0)

    class Motion(torch.autograd.Function):
        @staticmethod
        def forward(robot: Any, how: Any, q: Any, v: Any, tau: Any, parameters: Any) -> Any:
            state: list[Any] = [None if each is None else _array(each) for each in (q, v, tau)]
            return tuple(map(torch.as_tensor, _computed(robot, "rollout", parameters, *state, **how)))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.robot, ctx.how, q, v, tau, parameters = inputs
            ctx.has = (tau is not None, parameters is not None)
            ctx.save_for_backward(*(each for each in (q, v, tau, parameters, output[0], output[2]) if each is not None))

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            q, v, *rest = ctx.saved_tensors
            tau = rest.pop(0) if ctx.has[0] else None
            parameters = rest.pop(0) if ctx.has[1] else None
            by_parameters = ctx.needs_input_grad[5]
            found = Pullback.apply(ctx.robot, ctx.how, by_parameters, q, v, tau, parameters, *rest, *cotangents)
            by_q, by_v, by_tau, by_each = found
            # One robot moves all states.
            own = None
            if parameters is not None and by_parameters:
                own = by_each.reshape(-1, by_each.shape[-1]).sum(dim=0).to(parameters.dtype)
            return None, None, by_q, by_v, by_tau if ctx.has[0] else None, own

        @staticmethod
        def vmap(info: Any, dims: Any, robot: Any, how: Any, *given: Any) -> Any:
            return Motion.apply(robot, how, *_in_front(given, dims[2:], info.batch_size)), (0, 0, 0, 0)

    return Motion, Pullback


def _refuse_mapped(axis: int | None) -> None:
    if axis is not None:
        raise ValueError(_ONE_ROBOT)


def _in_front(given: Any, dims: Any, size: int) -> list[Any]:
    """q, v, tau, parameters and more, all but the parameters with the mapped axis first."""
    _refuse_mapped(dims[3])
    return [
        each
        if each is None or k == 3
        else each.unsqueeze(0).expand(size, *each.shape)
        if axis is None
        else each.movedim(axis, 0)
        for k, (each, axis) in enumerate(zip(given, dims, strict=True))
    ]


@cache
def _functions() -> tuple[Any, Any]:
    """The two as classes of torch, made when they are first needed."""
    _check_torch()
    import torch


    class Pullback(torch.autograd.Function):
        """Gradients of a solution as a function of their own, for `vmap`."""

        @staticmethod
        def forward(
            robot: Any, solution: str, by_parameters: bool, parameters: Any, q: Any, v: Any, x: Any, cotangent: Any
        ) -> Any:
            state = [_array(each) for each in (q, v, x, cotangent)]
            pullback = f"{solution}_pullback_with_parameters" if by_parameters else f"{solution}_pullback"
            by_q, by_v, by_x, *rest = _computed(robot, pullback, parameters, *state)
            (by_q,) = _computed(robot, "cotangent_to_coordinates", None, state[0], by_q)
            gradients = (torch.as_tensor(each) for each in (by_q, by_v, by_x))
            # What went with a whole batch has the sum.
            own = [own.sum_to_size(of.shape) for own, of in zip(gradients, (q, v, x), strict=True)]
            # Of each state: the mapped ones want theirs apart.
            return *own, torch.as_tensor(rest[0]) if rest else q.new_zeros((*by_q.shape[:-1], 0))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.solution = inputs[1]

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise RuntimeError(f"{ctx.solution}: its second derivatives are not known here, only the first")

        @staticmethod
        def vmap(
            info: Any, dims: Any, robot: Any, solution: str, by_parameters: bool, parameters: Any, *state: Any
        ) -> Any:
            _refuse_mapped(dims[3])
            aligned = _aligned(state, dims[4:], info.batch_size)
            found = Pullback.apply(robot, solution, by_parameters, parameters, *(tensor for tensor, _ in aligned))
            own = tuple(each.reshape(shape) for each, (_, shape) in zip(found[:3], aligned, strict=False))
            return (*own, found[3]), (0, 0, 0, 0)

    def differentiable(solution: str) -> Any:
        class Solution(torch.autograd.Function):
            @staticmethod
            def forward(robot: Any, q: Any, v: Any, x: Any, parameters: Any) -> Any:
                return torch.as_tensor(_computed(robot, solution, parameters, *map(_array, (q, v, x)))[0])

            @staticmethod
            def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
                ctx.robot, *state, parameters = inputs
                ctx.save_for_backward(*state, *([] if parameters is None else [parameters]))

            @staticmethod
            def backward(ctx: Any, cotangent: Any) -> Any:
                q, v, x, *rest = ctx.saved_tensors
                parameters, wanted = rest[0] if rest else None, ctx.needs_input_grad[4]
                *own, by_each = Pullback.apply(ctx.robot, solution, wanted, parameters, q, v, x, cotangent)
                if parameters is None or not wanted:
                    return None, *own, None
                # One robot is of all states.
                return None, *own, by_each.reshape(-1, by_each.shape[-1]).sum(dim=0).to(parameters.dtype)

            @staticmethod
            def vmap(info: Any, dims: Any, robot: Any, q: Any, v: Any, x: Any, parameters: Any) -> Any:
                _refuse_mapped(dims[4])
                aligned = _aligned((q, v, x), dims[1:4], info.batch_size)
                return Solution.apply(robot, *(tensor for tensor, _ in aligned), parameters), 0

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
    """Each tensor with the mapped axis first and as many others as the rest have, and its shape without
    these."""
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

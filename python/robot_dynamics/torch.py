"""PyTorch: the dynamics as differentiable functions of tensors.

Tensors are on the CPU, float64 or float32. Their leading dimensions broadcast as everywhere in this package.

Gradients are vector-Jacobian products in O(n), without a Jacobian or M. `torch.func.vmap` and
`torch.func.grad` work. Second derivatives raise an error. A gradient by q has its nq numbers. The functions
depend on the direction of a quaternion only, so an optimiser must normalise q after its step
(`Robot.normalize`).

Results are NaN for an invalid state (not finite, a quaternion not of unit length, a singular M) and for
parameters that are not finite. Results of the other states are valid.

    import torch
    import robot_dynamics as rd
    from robot_dynamics.torch import inverse_dynamics

    robot = rd.example("panda")
    q = torch.zeros(1000, 7, dtype=torch.float64, requires_grad=True)
    rest = torch.zeros(7, dtype=torch.float64)
    effort = inverse_dynamics(robot, q, rest, rest).square().sum()
    effort.backward()                       # q.grad (1000, 7)

`step` and `rollout` integrate states, with gradients by the initial state and the torques. All four functions
take `parameters` with gradients, in the order of `Robot.parameters()`: inertias, armatures, damping,
friction, springs and gravity. The sign of friction is held.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from robot_dynamics import defaults
from robot_dynamics.motion import disabled_effects
from robot_dynamics.pullbacks import CONTACT_METHODS
from robot_dynamics.rollout_gradients import Arrays, compute, rollout_gradients

if TYPE_CHECKING:
    import torch

    from robot_dynamics.ground import AnyGround
    from robot_dynamics.robot import Robot


def inverse_dynamics(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor,
    a: torch.Tensor,
    *,
    parameters: torch.Tensor | None = None,
) -> torch.Tensor:
    """Inverse dynamics τ = M(q) a + C(q, v) v + g(q), differentiable by q, v, a and parameters.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : torch.Tensor, shape (..., nq)
        Configuration.
    v : torch.Tensor, shape (..., nv)
        Velocity [rad/s or m/s].
    a : torch.Tensor, shape (..., nv)
        Acceleration [rad/s² or m/s²].
    parameters : torch.Tensor, shape (n,), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.

    Returns
    -------
    torch.Tensor, shape (..., nv)
        Torques τ [N·m or N]; NaN for invalid states.

    Raises
    ------
    ImportError
        PyTorch is missing.
    TypeError
        An argument is not a tensor on the CPU.
    """
    forces: torch.Tensor = _dynamics_functions()[0].apply(robot, q, v, a, parameters)
    return forces


def forward_dynamics(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor,
    tau: torch.Tensor,
    *,
    parameters: torch.Tensor | None = None,
) -> torch.Tensor:
    """Forward dynamics a = M⁻¹(τ − C v − g), differentiable by q, v, τ and parameters.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : torch.Tensor, shape (..., nq)
        Configuration.
    v : torch.Tensor, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : torch.Tensor, shape (..., nv)
        Torques [N·m or N].
    parameters : torch.Tensor, shape (n,), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.

    Returns
    -------
    torch.Tensor, shape (..., nv)
        Acceleration a [rad/s² or m/s²]; NaN for invalid states and singular M.

    Raises
    ------
    ImportError
        PyTorch is missing.
    TypeError
        An argument is not a tensor on the CPU.
    """
    acceleration: torch.Tensor = _dynamics_functions()[1].apply(robot, q, v, tau, parameters)
    return acceleration


class Rollout(NamedTuple):
    """Motions of many states."""

    q: torch.Tensor
    """Final configurations (..., nq)."""
    v: torch.Tensor
    """Final velocities (..., nv) [rad/s or m/s]."""
    q_trajectory: torch.Tensor
    """Configurations after each `stride` steps (..., samples, nq)."""
    v_trajectory: torch.Tensor
    """Velocities after each `stride` steps (..., samples, nv) [rad/s or m/s]."""


def rollout(
    robot: Robot,
    q: torch.Tensor,
    v: torch.Tensor | None = None,
    tau: torch.Tensor | None = None,
    *,
    steps: int,
    dt: float = defaults.DT,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    parameters: torch.Tensor | None = None,
    ground: AnyGround | None = None,
) -> Rollout:
    """`Robot.rollout`, differentiable by q, v, tau and parameters.

    The backward pass computes the states again from √steps checkpoints, in O(n) a step. The sign of friction
    is held. The effects act as in `Robot.rollout_pullback`: those without gradients are left out or raise an
    error.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : torch.Tensor, shape (..., nq)
        Initial configurations.
    v : torch.Tensor, shape (..., nv), optional
        Initial velocities [rad/s or m/s]; default: 0.
    tau : torch.Tensor, shape (..., nv) or (..., steps, nv), optional
        Torques [N·m or N], held over all steps or given for each step; default: 0. With one dimension more
        than the states, they are given for each step.
    steps : int
        Number of steps.
    dt : float
        Step size [s].
    integrator : str
        Explicit method, ``"implicit"`` or ``"mujoco"``; see `Robot.rollout_pullback`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `Robot.simulate`.
    dissipation : bool
        Whether damping and friction act.
    stride : int
        Number of steps between samples of the trajectory; 0 for no trajectory.
    parameters : torch.Tensor, shape (n,), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.
        Methods with contact have no gradient by them.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `Robot.simulate`.

    Returns
    -------
    Rollout
        Final states and trajectories; NaN for invalid states.

    Raises
    ------
    ImportError
        PyTorch is missing.
    TypeError
        An argument is not a tensor on the CPU.
    SimulationError
        The integrator or the step is invalid, or the integrator has no gradients.
    ValueError
        An effect has no gradients, or `tau` does not have `steps` rows.
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
    if integrator in CONTACT_METHODS:
        how["ground"] = ground
    elif ground is not None:
        raise ValueError(f"integrator={integrator!r} has no contact: a ground needs integrator='implicit'")
    else:
        # This raises an error for effects without gradients.
        robot._differentiable_row(dt=dt, integrator=integrator, conservative=conservative, without=off)
    q, v = q.broadcast_to(*lead, q.shape[-1]), v.broadcast_to(*lead, v.shape[-1])
    return Rollout(*_rollout_functions()[0].apply(robot, how, q, v, tau, parameters))


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
    ground: AnyGround | None = None,
) -> tuple[torch.Tensor, torch.Tensor]:
    """One step, differentiable by q, v, tau and parameters; see `rollout`.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : torch.Tensor, shape (..., nq)
        Configuration.
    v : torch.Tensor, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : torch.Tensor, shape (..., nv), optional
        Torques [N·m or N]; default: 0.
    dt : float
        Step size [s].
    integrator : str
        Explicit method, ``"implicit"`` or ``"mujoco"``; see `Robot.rollout_pullback`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `Robot.simulate`.
    dissipation : bool
        Whether damping and friction act.
    parameters : torch.Tensor, shape (n,), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.
        Methods with contact have no gradient by them.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `Robot.simulate`.

    Returns
    -------
    q : torch.Tensor, shape (..., nq)
        Configuration after the step.
    v : torch.Tensor, shape (..., nv)
        Velocity after the step [rad/s or m/s].

    Raises
    ------
    ImportError
        PyTorch is missing.
    TypeError
        An argument is not a tensor on the CPU.
    SimulationError
        The integrator or the step is invalid, or the integrator has no gradients.
    ValueError
        An effect has no gradients.
    """
    _check_torch()
    import torch

    if tau is not None:
        q = q.broadcast_to(*torch.broadcast_shapes(q.shape[:-1], tau.shape[:-1]), q.shape[-1])
    how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without}
    how["ground"] = ground
    end = rollout(robot, q, v, tau, steps=1, dt=dt, dissipation=dissipation, parameters=parameters, **how)
    return end.q, end.v


def _check_torch() -> None:
    """Import torch, which is too large to be a dependency of this package."""
    try:
        import torch  # noqa: F401
    except ImportError as error:
        raise ImportError("robot_dynamics.torch needs PyTorch: pip install torch") from error


_ONE_ROBOT = "parameters are mapped over, but all states share one robot: loop over robots"


@lru_cache(maxsize=8)
def _with_parameters(robot: Robot, numbers: bytes) -> Robot:
    return robot.with_parameters(np.frombuffer(numbers), as_written=True)


def _changed_robot(robot: Robot, parameters: Any) -> Robot:
    """Robot with these parameters, if there are any."""
    if parameters is None:
        return robot
    if parameters.ndim != 1:
        raise ValueError(_ONE_ROBOT)
    return _with_parameters(robot, _array(parameters).astype(np.float64).tobytes())


def _with_own(robot: Robot, own: Any, results: Callable[[Robot], Arrays]) -> Arrays:
    """Results of the robot with `own` parameters, if there are any; NaN if these are not finite."""
    if own is not None and not np.isfinite(_array(own)).all():
        return tuple(x if x is None else np.full_like(x, np.nan) for x in results(robot))
    return results(_changed_robot(robot, own))


def _compute(robot: Robot, name: str, own: Any, /, *given: Any, **options: Any) -> Arrays:
    """Results of a method of the robot, or of one with `own` parameters; NaN in the rows of invalid states.
    """
    return _with_own(robot, own, lambda changed: compute(changed, name, *given, **options))


@cache
def _rollout_functions() -> tuple[Any, Any]:
    """Rollouts and their gradients as classes of torch."""
    _check_torch()
    import torch


    class Pullback(torch.autograd.Function):
        """Gradients of each state by its start, torques and parameters; empty for absent arguments."""

        @staticmethod
        def forward(
            robot: Any, how: Any, by_parameters: bool, q: Any, v: Any, tau: Any, parameters: Any, *rest: Any
        ) -> Any:
            start, speed, *ends_and_cotangents = (_array(each) for each in (q, v, *rest))
            ends, cotangents = tuple(ends_and_cotangents[:2]), tuple(ends_and_cotangents[2:])
            state = (start, speed, None if tau is None else _array(tau))

            def gradients(changed: Any) -> Any:
                return rollout_gradients(changed, how, state, ends, cotangents, by_parameters=by_parameters)

            results = _with_own(robot, parameters, gradients)
            nothing = q.new_zeros((*q.shape[:-1], 0))
            return tuple(nothing.clone() if each is None else torch.as_tensor(each) for each in results)

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise RuntimeError("rollout: second derivatives are not available, only first ones")

        @staticmethod
        def vmap(info: Any, dims: Any, robot: Any, how: Any, by_parameters: bool, *given: Any) -> Any:
            return Pullback.apply(robot, how, by_parameters, *_batch_axis_first(given, dims[3:], info.batch_size)), (0, 0, 0, 0)

    class Motion(torch.autograd.Function):
        @staticmethod
        def forward(robot: Any, how: Any, q: Any, v: Any, tau: Any, parameters: Any) -> Any:
            state: list[Any] = [None if each is None else _array(each) for each in (q, v, tau)]
            return tuple(map(torch.as_tensor, _compute(robot, "rollout", parameters, *state, **how)))

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
            # All states share one robot.
            own = None
            if parameters is not None and by_parameters:
                own = by_each.reshape(-1, by_each.shape[-1]).sum(dim=0).to(parameters.dtype)
            return None, None, by_q, by_v, by_tau if ctx.has[0] else None, own

        @staticmethod
        def vmap(info: Any, dims: Any, robot: Any, how: Any, *given: Any) -> Any:
            return Motion.apply(robot, how, *_batch_axis_first(given, dims[2:], info.batch_size)), (0, 0, 0, 0)

    return Motion, Pullback


def _refuse_mapped(axis: int | None) -> None:
    if axis is not None:
        raise ValueError(_ONE_ROBOT)


def _batch_axis_first(given: Any, dims: Any, size: int) -> list[Any]:
    """q, v, tau, parameters and others, all but the parameters with the mapped axis first."""
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
def _dynamics_functions() -> tuple[Any, Any]:
    """Inverse and forward dynamics as classes of torch, created on first use."""
    _check_torch()
    import torch


    class Pullback(torch.autograd.Function):
        """Gradients of a solution as a separate function, for `vmap`."""

        @staticmethod
        def forward(
            robot: Any, solution: str, by_parameters: bool, parameters: Any, q: Any, v: Any, x: Any, cotangent: Any
        ) -> Any:
            state = [_array(each) for each in (q, v, x, cotangent)]
            pullback = f"{solution}_pullback_with_parameters" if by_parameters else f"{solution}_pullback"
            by_q, by_v, by_x, *rest = _compute(robot, pullback, parameters, *state)
            (by_q,) = _compute(robot, "cotangent_to_coordinates", None, state[0], by_q)
            gradients = (torch.as_tensor(each) for each in (by_q, by_v, by_x))
            # An argument that all states share gets the sum.
            own = [own.sum_to_size(of.shape) for own, of in zip(gradients, (q, v, x), strict=True)]
            # The gradient of each state, because mapped parameters need them separately.
            return *own, torch.as_tensor(rest[0]) if rest else q.new_zeros((*by_q.shape[:-1], 0))

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.solution = inputs[1]

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise RuntimeError(f"{ctx.solution}: second derivatives are not available, only first ones")

        @staticmethod
        def vmap(
            info: Any, dims: Any, robot: Any, solution: str, by_parameters: bool, parameters: Any, *state: Any
        ) -> Any:
            _refuse_mapped(dims[3])
            aligned = _align_axes(state, dims[4:], info.batch_size)
            found = Pullback.apply(robot, solution, by_parameters, parameters, *(tensor for tensor, _ in aligned))
            own = tuple(each.reshape(shape) for each, (_, shape) in zip(found[:3], aligned, strict=False))
            return (*own, found[3]), (0, 0, 0, 0)

    def differentiable(solution: str) -> Any:
        class Solution(torch.autograd.Function):
            @staticmethod
            def forward(robot: Any, q: Any, v: Any, x: Any, parameters: Any) -> Any:
                return torch.as_tensor(_compute(robot, solution, parameters, *map(_array, (q, v, x)))[0])

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
                # All states share one robot.
                return None, *own, by_each.reshape(-1, by_each.shape[-1]).sum(dim=0).to(parameters.dtype)

            @staticmethod
            def vmap(info: Any, dims: Any, robot: Any, q: Any, v: Any, x: Any, parameters: Any) -> Any:
                _refuse_mapped(dims[4])
                aligned = _align_axes((q, v, x), dims[1:4], info.batch_size)
                return Solution.apply(robot, *(tensor for tensor, _ in aligned), parameters), 0

        return Solution

    return differentiable("inverse_dynamics"), differentiable("forward_dynamics")


def _array(tensor: Any) -> np.ndarray[Any, Any]:
    """Array on the memory of a tensor."""
    if not hasattr(tensor, "detach"):
        raise TypeError(f"expected a tensor, found {type(tensor).__name__}; torch.as_tensor converts an array")
    if tensor.device.type != "cpu":
        raise TypeError(f"the tensor is on {tensor.device}, this package computes on the CPU: give it tensor.cpu()")
    return np.asarray(tensor.detach())


def _align_axes(state: Any, dims: Any, size: int) -> list[tuple[Any, tuple[int, ...]]]:
    """Tensors with the mapped axis first and equally many axes, and their shapes before the alignment."""
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

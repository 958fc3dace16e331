"""Gradients through time: what a change of a motion's end is worth, as what changes of its start and of its
forces are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.errors import BadStatesError, ShapeError
from robot_dynamics.motion import Course, effort_limits, switched_off
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class RolloutPullback(NamedTuple):
    """The gradient of a loss of motions, from its gradient by where they come."""

    by_position: NDArray[Any]
    """By the q at the start, along displacements q ⊕ δq (..., nv)."""
    by_velocity: NDArray[Any]
    """By the v at the start (..., nv)."""
    by_force: NDArray[Any] | None
    """By the torques, of their shape with the leading dimensions of the batch; None where there are none."""
    by_parameters: NDArray[Any] | None
    """By `Robot.parameters()`, of each state (..., parameters); None unless asked for."""


def limited(
    torques: NDArray[Any] | None, limits: NDArray[np.float64] | None
) -> tuple[NDArray[Any] | None, NDArray[np.bool_] | None]:
    """Torques cut off at the limits, and which of them are within; `None` where none is cut off."""
    if torques is None or limits is None:
        return torques, None
    effort = limits.astype(torques.dtype)
    within = np.abs(torques) <= effort
    return (torques, None) if within.all() else (np.clip(torques, -effort, effort), within)


def masked(gradient: RolloutPullback, within: NDArray[np.bool_] | None) -> RolloutPullback:
    """The gradient by torques before they were cut off."""
    if within is None or gradient.by_force is None:
        return gradient
    return gradient._replace(by_force=gradient.by_force * within)


def rollout_pullback(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    tau: Numbers | None = None,
    *,
    by_position: Numbers | None = None,
    by_velocity: Numbers | None = None,
    by_position_trajectory: Numbers | None = None,
    by_velocity_trajectory: Numbers | None = None,
    steps: int,
    step: float = 1e-3,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    spacing: int = 0,
    parameters: bool = False,
    threads: int | None = None,
) -> RolloutPullback:
    """The gradient of a loss of `rollout`, from its gradients by where the states come: reverse through
    time, O(n) a step.

    q (..., nq), v (..., nv), `tau` (..., nv) held or (..., steps, nv), and what follows `steps`: as given
    to `rollout`. `by_position` and `by_velocity` (..., nv) are the loss's gradients by the states at the
    end, `by_position_trajectory` and `by_velocity_trajectory` (..., samples, nv) those by the states
    after each `stride` steps; what is not given is 0. Those by positions are along displacements q ⊕ δq,
    see `cotangent_from_coordinates`. The states on the way are computed again from a checkpoint at every
    `spacing`-th step: 0 for √steps, the least memory, `steps` for keeping all. `parameters` asks for the
    gradient by `parameters()`, too.

    The motion is that of `rollout` with the same arguments. The effects of the file act, as everywhere.
    Two things differ as they have no gradients here, in `step_pullback` and in `robot_dynamics.jax` and
    `robot_dynamics.torch`: `integrator` is an explicit method, ``"rk4"`` unless given, and so position
    limits and contact are left out (``rd.Simulation(robot, integrator="rk4").left_out`` lists them);
    actuators, equalities and the springs of tendons and ball joints are refused by name, unless `without`
    leaves them out. Damping acts, friction's sign is held, and torques beyond the effort limits have the
    gradient 0.

    One state is computed in float64; SingularMassError where its M is singular.

    >>> robot = rd.example("two_r")
    >>> q, v, tau = [0.3, 1.2], [0.0, 0.0], np.zeros((100, 2))
    >>> gradient = robot.rollout_pullback(q, v, tau, by_velocity=[1.0, 0.0], steps=100, step=1e-3)
    >>> ahead = robot.rollout(q, v, tau + [0.0, 1e-6], steps=100, step=1e-3).v[0]
    >>> behind = robot.rollout(q, v, tau - [0.0, 1e-6], steps=100, step=1e-3).v[0]
    >>> bool(abs((ahead - behind) / 2e-6 - gradient.by_force[:, 1].sum()) < 1e-7)
    True
    """
    course = Course.of(robot, q, v, tau, steps)
    off = switched_off(without, dissipation, stops=True)
    torques, within = limited(course.tau, effort_limits(robot, conservative, off))
    lead, kind = course.q.shape[:-1], course.q.dtype

    def cotangent(name: str, given: Numbers | None, own: tuple[int, ...]) -> NDArray[Any]:
        array = np.zeros(own, kind) if given is None else np.asarray(given)
        try:
            return np.broadcast_to(array, (*lead, *own))
        except ValueError:
            message = f"{name} has shape {array.shape}, it must broadcast to {(*lead, *own)}"
            raise ShapeError(message) from None

    samples = steps // stride if stride > 0 else 0
    on_the_way = (by_position_trajectory, by_velocity_trajectory)
    if stride == 0 and any(each is not None for each in on_the_way):
        raise ValueError("gradients by a trajectory need the stride of its samples")
    trajectory = None
    if samples > 0:
        names = ("by_position_trajectory", "by_velocity_trajectory")
        trajectory = tuple(
            cotangent(name, given, (samples, robot.nv)) for name, given in zip(names, on_the_way, strict=True)
        )
    try:
        gradients = robot._rollout_pullback(
            course.q,
            course.v,
            torques,
            cotangent("by_position", by_position, (robot.nv,)),
            cotangent("by_velocity", by_velocity, (robot.nv,)),
            trajectory,
            each_step=course.each_step,
            step=step,
            steps=steps,
            integrator=integrator,
            conservative=conservative,
            without=off,
            stride=stride,
            spacing=spacing,
            parameters=parameters,
            threads=threads,
        )
    except BadStatesError as error:
        error.result = masked(RolloutPullback(*error.result), within)
        raise
    return masked(RolloutPullback(*gradients), within)


def step_pullback(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    by_position: Numbers | None = None,
    by_velocity: Numbers | None = None,
    step: float,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    parameters: bool = False,
    threads: int | None = None,
) -> RolloutPullback:
    """The gradient of a loss of one `step`, from its gradients by q and v after it: Aᵀ and Bᵀ of
    `linearize_step` times these, without the matrices, of one state or of many.

    q (..., nq), v (..., nv), tau (..., nv), `by_position` and `by_velocity` (..., nv); see
    `rollout_pullback`.

    >>> robot = rd.example("two_r")
    >>> q, v, tau = [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    >>> gradient = robot.step_pullback(q, v, tau, by_velocity=[1.0, 0.0], step=1e-3)
    >>> A, B = robot.linearize_step(q, v, tau, step=1e-3)
    >>> bool(np.allclose(gradient.by_position, A[2, :2])), bool(np.allclose(gradient.by_force, B[2]))
    (True, True)
    """
    if tau is not None:
        # Torques of one step: what they have beside nv is a batch.
        states, forces = np.asarray(q), np.asarray(tau)
        lead = np.broadcast_shapes(states.shape[:-1], np.shape(np.asarray(v))[:-1], forces.shape[:-1])
        q, tau = np.broadcast_to(states, (*lead, states.shape[-1])), forces
    return robot.rollout_pullback(
        q,
        v,
        tau,
        by_position=by_position,
        by_velocity=by_velocity,
        steps=1,
        step=step,
        integrator=integrator,
        conservative=conservative,
        without=without,
        dissipation=dissipation,
        parameters=parameters,
        threads=threads,
    )

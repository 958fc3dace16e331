"""Gradients through time: the gradient of a loss by the initial state and the torques of a rollout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import defaults
from robot_dynamics import ground as grounds
from robot_dynamics.errors import BadStatesError, ShapeError
from robot_dynamics.ground import AnyGround
from robot_dynamics.motion import RolloutInputs, disabled_effects, effort_limits
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


CONTACT_METHODS = ("implicit", "mujoco")
"""Methods with contact whose steps have gradients."""


class LinearizedSteps(NamedTuple):
    """How the steps of all states with contact, stops and friction were differentiated."""

    analytic: int
    """Number of steps with analytic derivatives."""
    at_transition: int
    """Number of those at a transition, such as from sticking to sliding. Their derivatives are one-sided."""
    differences: int
    """Number of steps whose derivatives are central differences."""
    reason: str | None
    """Reason for the differences of the first such step."""


class RolloutPullback(NamedTuple):
    """Gradient of a loss of motions, from its gradient by the final states and trajectories."""

    by_position: NDArray[Any]
    """Gradient by the initial q, along displacements q ⊕ δq (..., nv)."""
    by_velocity: NDArray[Any]
    """Gradient by the initial v (..., nv)."""
    by_force: NDArray[Any] | None
    """Gradient by the torques (..., nv) or (..., steps, nv), like `tau`; `None` without torques."""
    by_parameters: NDArray[Any] | None
    """Gradient by `Robot.parameters()` for each state (..., parameters); `None` unless requested."""
    steps: LinearizedSteps | None = None
    """How steps with contact were differentiated; `None` for explicit methods."""


def clip_torques(
    torques: NDArray[Any] | None, limits: NDArray[np.float64] | None
) -> tuple[NDArray[Any] | None, NDArray[np.bool_] | None]:
    """Torques clipped to the limits, and a mask of those within; the mask is `None` if no torque is clipped.
    """
    if torques is None or limits is None:
        return torques, None
    effort = limits.astype(torques.dtype)
    within = np.abs(torques) <= effort
    return (torques, None) if within.all() else (np.clip(torques, -effort, effort), within)


def mask_clipped(gradient: RolloutPullback, within: NDArray[np.bool_] | None) -> RolloutPullback:
    """Gradient by the torques before they are clipped."""
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
    dt: float = defaults.DT,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    spacing: int = 0,
    parameters: bool = False,
    threads: int | None = None,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> RolloutPullback:
    """Gradient of a loss of `rollout`, from its gradients by the states.

    This is reverse mode through time, in O(n) for each step.

    The motion is that of `rollout` with the same arguments. It differs in effects whose gradients are not
    available; `step_pullback`, `robot_dynamics.jax` and `robot_dynamics.torch` differ in the same way:

    - `integrator` is an explicit method, ``"rk4"`` by default. Position limits and contact are left out;
      ``rd.Simulation(robot, integrator="rk4").left_out`` lists them.
    - With an explicit method, actuators, equalities and the springs of tendons and ball joints raise
      ValueError, unless `without` leaves them out.
    - Damping acts, and the sign of friction is held. Torques beyond the effort limits have the gradient
      0.

    With ``integrator="implicit"`` or ``"mujoco"`` everything acts as in `rollout`, with contact, stops and
    static friction. Each step is pulled back by its derivatives, which `linearize_step` describes. `steps` of
    the result counts those that are analytic, at a transition, or differences. The forces that one step
    passes to the next count as constant. These methods compute in float64, without gradients by parameters.

    The backward pass computes the states again from checkpoints. One state is computed in float64.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Initial configurations.
    v : array_like, shape (..., nv), optional
        Initial velocities [rad/s or m/s]; default: 0.
    tau : array_like, shape (..., nv) or (..., steps, nv), optional
        Torques [N·m or N], held over all steps or given for each step; default: 0.
    by_position : array_like, shape (..., nv), optional
        Gradient of the loss by the final q, along displacements q ⊕ δq; default: 0. See
        `cotangent_from_coordinates`.
    by_velocity : array_like, shape (..., nv), optional
        Gradient of the loss by the final v; default: 0.
    by_position_trajectory : array_like, shape (..., samples, nv), optional
        Gradient of the loss by q after each `stride` steps, along displacements; default: 0.
    by_velocity_trajectory : array_like, shape (..., samples, nv), optional
        Gradient of the loss by v after each `stride` steps; default: 0.
    steps : int
        Number of steps.
    dt : float
        Step size [s].
    integrator : str
        Explicit method, ``"implicit"`` or ``"mujoco"``; see `simulate`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `simulate`.
    dissipation : bool
        Whether damping and friction act.
    stride : int
        Number of steps between samples of the trajectory; 0 for no trajectory.
    spacing : int
        Number of steps between checkpoints. 0 stands for √steps, which needs the least memory; `steps`
        keeps all states.
    parameters : bool
        Whether to compute the gradient by `parameters()`.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `simulate`.

    Returns
    -------
    RolloutPullback
        Gradient by the initial state, the torques and the parameters.

    Raises
    ------
    BadStatesError
        Some states have no valid motion; `result` has the others.
    SingularMassError
        M(q) of one state is singular.
    SimulationError
        The integrator or the step is invalid, or the integrator has no gradients.
    ShapeError
        A gradient does not broadcast to the shape of its states.
    ValueError
        An effect has no gradients, or a gradient by a trajectory lacks its `stride`.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> q, v, tau = [0.3, 1.2], [0.0, 0.0], np.zeros((100, 2))
    >>> gradient = robot.rollout_pullback(q, v, tau, by_velocity=[1.0, 0.0], steps=100, dt=1e-3)
    >>> ahead = robot.rollout(q, v, tau + [0.0, 1e-6], steps=100, dt=1e-3).v[0]
    >>> behind = robot.rollout(q, v, tau - [0.0, 1e-6], steps=100, dt=1e-3).v[0]
    >>> bool(abs((ahead - behind) / 2e-6 - gradient.by_force[:, 1].sum()) < 1e-7)
    True
    """
    inputs = RolloutInputs.of(robot, q, v, tau, steps)
    off = disabled_effects(without, dissipation, stops=True)
    torques, within = clip_torques(inputs.tau, effort_limits(robot, conservative, off))
    lead, kind = inputs.q.shape[:-1], inputs.q.dtype

    def cotangent(name: str, given: Numbers | None, own: tuple[int, ...]) -> NDArray[Any]:
        array = np.zeros(own, kind) if given is None else np.asarray(given)
        try:
            return np.broadcast_to(array, (*lead, *own))
        except ValueError:
            message = f"{name} has shape {array.shape}, it must broadcast to {(*lead, *own)}"
            raise ShapeError(message) from None

    samples = steps // stride if stride > 0 else 0
    if ground is not None and integrator not in CONTACT_METHODS:
        raise ValueError(f"integrator={integrator!r} has no contact: a ground needs integrator='implicit'")
    if stride == 0 and not (by_position_trajectory is None and by_velocity_trajectory is None):
        raise ValueError("gradients by a trajectory need the stride of its samples")
    trajectory = None
    if samples > 0:
        own = (samples, robot.nv)
        trajectory = (
            cotangent("by_position_trajectory", by_position_trajectory, own),
            cotangent("by_velocity_trajectory", by_velocity_trajectory, own),
        )
    try:
        gradients, counts = robot._rollout_pullback(
            inputs.q,
            inputs.v,
            torques,
            cotangent("by_position", by_position, (robot.nv,)),
            cotangent("by_velocity", by_velocity, (robot.nv,)),
            trajectory,
            each_step=inputs.each_step,
            dt=dt,
            steps=steps,
            integrator=integrator,
            conservative=conservative,
            without=off,
            stride=stride,
            spacing=spacing,
            parameters=parameters,
            threads=threads,
            controls=None if controls is None else dict(controls),
            ground=grounds.native(ground),
        )
    except BadStatesError as error:
        error.result = mask_clipped(RolloutPullback(*error.result), within)
        raise
    found = RolloutPullback(*gradients, None if counts is None else LinearizedSteps(*counts))
    return mask_clipped(found, within)


def step_pullback(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    by_position: Numbers | None = None,
    by_velocity: Numbers | None = None,
    dt: float,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    parameters: bool = False,
    threads: int | None = None,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> RolloutPullback:
    """Gradient of a loss of one `step`, from its gradients by q and v after the step.

    It is the product of Aᵀ and Bᵀ of `linearize_step` with these gradients, without the matrices. See
    `rollout_pullback` for the effects that act.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : array_like, shape (..., nv), optional
        Torques [N·m or N]; default: 0.
    by_position : array_like, shape (..., nv), optional
        Gradient of the loss by q after the step, along displacements q ⊕ δq; default: 0.
    by_velocity : array_like, shape (..., nv), optional
        Gradient of the loss by v after the step; default: 0.
    dt : float
        Step size [s].
    integrator : str
        Explicit method, ``"implicit"`` or ``"mujoco"``; see `simulate`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `simulate`.
    dissipation : bool
        Whether damping and friction act.
    parameters : bool
        Whether to compute the gradient by `parameters()`.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `simulate`.

    Returns
    -------
    RolloutPullback
        Gradient by q, v, the torques and the parameters.

    Raises
    ------
    BadStatesError
        Some states have no valid motion; `result` has the others.
    SingularMassError
        M(q) of one state is singular.
    SimulationError
        The integrator or the step is invalid, or the integrator has no gradients.
    ValueError
        An effect has no gradients.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> q, v, tau = [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
    >>> gradient = robot.step_pullback(q, v, tau, by_velocity=[1.0, 0.0], dt=1e-3)
    >>> A, B = robot.linearize_step(q, v, tau, dt=1e-3)
    >>> bool(np.allclose(gradient.by_position, A[2, :2])), bool(np.allclose(gradient.by_force, B[2]))
    (True, True)
    """
    if tau is not None:
        # All axes of the torques but the last are those of a batch.
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
        dt=dt,
        integrator=integrator,
        conservative=conservative,
        without=without,
        dissipation=dissipation,
        parameters=parameters,
        threads=threads,
        controls=controls,
        ground=ground,
    )

"""JAX: the dynamics as functions of arrays, under `jit`, `vmap`, `grad`, `jvp`, `vjp` and `scan`, on the CPU.

XLA calls the library without Python, apart from rollouts with contact. Arrays are float64
(``jax_enable_x64``) or float32. Their leading dimensions broadcast as everywhere in this package.

Reverse mode computes vector-Jacobian products in O(n), without a Jacobian or M. Forward mode multiplies with
the derivatives. Gradients of `inverse_dynamics`, `forward_dynamics`, `mass_matrix` and `frame_pose` have
derivatives in turn (`jax.hessian`, `jax.grad` of `jax.grad`); those by parameters, of `rollout` and of
forward mode raise an error. A gradient by q has its nq numbers. The functions depend on the direction of a
quaternion only, so an optimiser must normalise q after its step (`Robot.normalize`).

Results are NaN for an invalid state (not finite, a quaternion not of unit length, a singular M) and for
parameters that are not finite. Results of the other states are valid. Errors in the arguments raise an
exception of this package. A robot stays in memory after its first call. Ctrl-C takes effect at the end of a
call.

    import jax, jax.numpy as jnp
    import robot_dynamics as rd
    from robot_dynamics.jax import inverse_dynamics

    jax.config.update("jax_enable_x64", True)
    robot = rd.example("panda")

    @jax.jit
    def effort(q):
        rest = jnp.zeros(7)
        return (inverse_dynamics(robot, q, rest, rest) ** 2).sum()

    jax.grad(effort)(jnp.zeros((1000, 7)))     # (1000, 7)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from robot_dynamics import defaults
from robot_dynamics.errors import DTypeError, ShapeError

if TYPE_CHECKING:
    import jax

    from robot_dynamics.ground import AnyGround
    from robot_dynamics.robot import Robot


def inverse_dynamics(
    robot: Robot, q: jax.Array, v: jax.Array, a: jax.Array, *, parameters: jax.Array | None = None
) -> jax.Array:
    """Inverse dynamics τ = M(q) a + C(q, v) v + g(q), differentiable by q, v, a and parameters.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : jax.Array, shape (..., nq)
        Configuration.
    v : jax.Array, shape (..., nv)
        Velocity [rad/s or m/s].
    a : jax.Array, shape (..., nv)
        Acceleration [rad/s² or m/s²].
    parameters : jax.Array, shape (n,) or (..., n), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.

    Returns
    -------
    jax.Array, shape (..., nv)
        Torques τ [N·m or N]; NaN for invalid states.

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    """
    return _compute_row(robot, "inverse_dynamics", ("q", "v", "a"), (q, v, a), parameters)


def forward_dynamics(
    robot: Robot, q: jax.Array, v: jax.Array, tau: jax.Array, *, parameters: jax.Array | None = None
) -> jax.Array:
    """Forward dynamics a = M⁻¹(τ − C v − g), differentiable by q, v, τ and parameters.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : jax.Array, shape (..., nq)
        Configuration.
    v : jax.Array, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : jax.Array, shape (..., nv)
        Torques [N·m or N].
    parameters : jax.Array, shape (n,) or (..., n), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.

    Returns
    -------
    jax.Array, shape (..., nv)
        Acceleration a [rad/s² or m/s²]; NaN for invalid states and singular M.

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    """
    return _compute_row(robot, "forward_dynamics", ("q", "v", "tau"), (q, v, tau), parameters)


def mass_matrix(robot: Robot, q: jax.Array) -> jax.Array:
    """Mass matrix M(q), differentiable by q.

    Parameters
    ----------
    robot : Robot
        Robot.
    q : jax.Array, shape (..., nq)
        Configuration.

    Returns
    -------
    jax.Array, shape (..., nv, nv)
        M(q) [kg·m², kg·m, kg]; NaN for invalid states.

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    """
    return _compute_row(robot, "mass_matrix", ("q",), (q,))


def frame_pose(robot: Robot, q: jax.Array, frame: str | int) -> jax.Array:
    """Pose of a frame in the world as a matrix [R p; 0 1], differentiable by q.

    Parameters
    ----------
    robot : Robot
        Robot.
    q : jax.Array, shape (..., nq)
        Configuration.
    frame : str or int
        Name or number of the frame.

    Returns
    -------
    jax.Array, shape (..., 4, 4)
        `world_from_frame`, p in metres; NaN for invalid states.

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    FrameError
        The frame does not exist.
    """
    index = robot.frame_names.index(frame) if isinstance(frame, str) and frame in robot.frame_names else frame
    if not isinstance(index, int) or not 0 <= index < len(robot.frame_names):
        from robot_dynamics.errors import FrameError

        raise FrameError(f"robot `{robot.name}` has no frame {frame!r}; see `frame_names`")
    return _compute_row(robot, "frame_pose", ("q",), (q,), frame=index)


class Rollout(NamedTuple):
    """Motions of many states."""

    q: jax.Array
    """Final configurations (..., nq)."""
    v: jax.Array
    """Final velocities (..., nv) [rad/s or m/s]."""
    q_trajectory: jax.Array
    """Configurations after each `stride` steps (..., samples, nq)."""
    v_trajectory: jax.Array
    """Velocities after each `stride` steps (..., samples, nv) [rad/s or m/s]."""


def rollout(
    robot: Robot,
    q: jax.Array,
    v: jax.Array | None = None,
    tau: jax.Array | None = None,
    *,
    steps: int,
    dt: float = defaults.DT,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stride: int = 0,
    parameters: jax.Array | None = None,
    ground: AnyGround | None = None,
) -> Rollout:
    """`Robot.rollout`, differentiable by q, v, tau and parameters.

    Reverse mode computes the states again from √steps checkpoints. The sign of friction is held. The effects
    act as in `Robot.rollout_pullback`: those without gradients are left out or raise an error.

    One call of XLA computes all steps. Those with contact (``"implicit"``, ``"mujoco"``) are called through
    Python, in float64, and have reverse mode only.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : jax.Array, shape (..., nq)
        Initial configurations.
    v : jax.Array, shape (..., nv), optional
        Initial velocities [rad/s or m/s]; default: 0.
    tau : jax.Array, shape (..., nv) or (..., steps, nv), optional
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
    parameters : jax.Array, shape (n,) or (..., n), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.
        Methods with contact take none.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `Robot.simulate`.

    Returns
    -------
    Rollout
        Final states and trajectories; NaN for invalid states.

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    SimulationError
        The integrator or the step is invalid.
    ValueError
        An effect has no gradients, `tau` does not have `steps` rows, or an explicit method has a ground.
    """
    import jax.numpy as jnp

    from robot_dynamics.motion import disabled_effects, effort_limits
    from robot_dynamics.pullbacks import CONTACT_METHODS
    from robot_dynamics.xla import calls

    off = disabled_effects(without, dissipation, stops=True)
    if integrator in CONTACT_METHODS:
        how = {"steps": steps, "dt": dt, "integrator": integrator, "stride": stride}
        how |= {"conservative": conservative, "without": off, "ground": ground}
        return _contact_rollout(robot, q, v, tau, parameters, how)
    if ground is not None:
        raise ValueError(f"integrator={integrator!r} has no contact: a ground needs integrator='implicit'")
    row, dissipates = robot._differentiable_row(dt=dt, integrator=integrator, conservative=conservative, without=off)
    given, own, lead = _start(robot, q, v, tau, steps)
    torques = "none"
    if tau is not None:
        torques = "each" if own[2] == 2 else "held"
        limits = effort_limits(robot, conservative, off)
        if limits is not None:
            limits = limits.astype(given[2].dtype)
            given[2] = jnp.clip(given[2], -limits, limits)
    if parameters is not None:
        parameters = _array("parameters", parameters)
        count = len(robot.parameter_names)
        lead = jnp.broadcast_shapes(lead, _batch_shape([("q", given[0], (robot.nq,)), ("parameters", parameters, (count,))], robot))
        parameters = _broadcast_parameters(parameters, lead)
    samples = steps // stride if stride > 0 else 0
    ends = calls.rollout(
        robot,
        given=_broadcast(given, own, lead),
        own=tuple(own),
        settings=calls.RolloutSettings(torques, steps, dt, row, dissipates, stride if samples else 0),
        parameters=parameters,
    )
    nothing = [jnp.zeros((*lead, 0, width), given[0].dtype) for width in (robot.nq, robot.nv)]
    return Rollout(*ends, *nothing[len(ends) - 2 :])


def step(
    robot: Robot,
    q: jax.Array,
    v: jax.Array,
    tau: jax.Array | None = None,
    *,
    dt: float,
    integrator: str = "rk4",
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    parameters: jax.Array | None = None,
    ground: AnyGround | None = None,
) -> tuple[jax.Array, jax.Array]:
    """One step, differentiable by q, v, tau and parameters; see `rollout`.

    Parameters
    ----------
    robot : Robot
        Robot, whose geometry is used.
    q : jax.Array, shape (..., nq)
        Configuration.
    v : jax.Array, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : jax.Array, shape (..., nv), optional
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
    parameters : jax.Array, shape (n,) or (..., n), optional
        Inertias, passive forces and gravity in the order of `Robot.parameters()`; default: those of `robot`.
        Methods with contact take none.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `Robot.simulate`.

    Returns
    -------
    q : jax.Array, shape (..., nq)
        Configuration after the step.
    v : jax.Array, shape (..., nv)
        Velocity after the step [rad/s or m/s].

    Raises
    ------
    ImportError
        JAX is missing.
    ShapeError
        An array has the wrong shape.
    DTypeError
        An array has an unsupported dtype, or float64 and float32 are mixed.
    SimulationError
        The integrator or the step is invalid.
    ValueError
        An effect has no gradients.
    """
    import jax.numpy as jnp

    q = _array("q", q)
    if tau is not None:
        tau = _array("tau", tau)
        q = jnp.broadcast_to(q, (*jnp.broadcast_shapes(q.shape[:-1], tau.shape[:-1]), *q.shape[-1:]))
    how: dict[str, Any] = {"integrator": integrator, "conservative": conservative, "without": without}
    how["ground"] = ground
    end = rollout(robot, q, v, tau, steps=1, dt=dt, dissipation=dissipation, parameters=parameters, **how)
    return end.q, end.v


def _contact_rollout(
    robot: Robot, q: Any, v: Any, tau: Any, parameters: Any, how: dict[str, Any]
) -> Rollout:
    """Rollout with contact."""
    from robot_dynamics.xla.contact_rollouts import contact_rollout

    if parameters is not None:
        raise ValueError(f"integrator={how['integrator']!r} takes no parameters: use `Robot.with_parameters`")
    given, own, lead = _start(robot, q, v, tau, how["steps"])
    if given[0].dtype != "float64":
        raise DTypeError("rollouts with contact need float64 arrays; set jax_enable_x64")
    return Rollout(*contact_rollout(robot, _broadcast(given, own, lead), how))


def _start(robot: Robot, q: Any, v: Any, tau: Any, steps: int) -> tuple[list[Any], list[int], tuple[int, ...]]:
    """Arrays of the start and the torques, the number of own dimensions of each, and those of the batch."""
    import jax.numpy as jnp

    q = _array("q", q)
    v = jnp.zeros(robot.nv, q.dtype) if v is None else _array("v", v)
    lead = _batch_shape([("q", q, (robot.nq,)), ("v", v, (robot.nv,))], robot)
    if tau is None:
        return [q, v], [1, 1], lead
    tau = _array("tau", tau)
    last = (steps, robot.nv) if tau.ndim > len(lead) + 1 else (robot.nv,)
    lead = jnp.broadcast_shapes(lead, _batch_shape([("q", q, (robot.nq,)), ("tau", tau, last)], robot))
    return [q, v, tau], [1, 1, len(last)], lead


def _compute_row(
    robot: Robot,
    name: str,
    names: tuple[str, ...],
    given: tuple[Any, ...],
    parameters: Any = None,
    **attributes: int,
) -> jax.Array:
    """Result of a row of the table with one result."""
    from robot_dynamics.xla import calls

    arrays = [_array(own, array) for own, array in zip(names, given, strict=True)]
    widths = [robot.nq if own == "q" else robot.nv for own in names]
    every: list[tuple[str, Any, tuple[int, ...]]] = [
        (own, x, (width,)) for own, x, width in zip(names, arrays, widths, strict=True)
    ]
    if parameters is not None:
        parameters = _array("parameters", parameters)
        every.append(("parameters", parameters, (len(robot.parameter_names),)))
    lead = _batch_shape(every, robot)
    spread = _broadcast(arrays, [1] * len(arrays), lead)
    if parameters is not None:
        parameters = _broadcast_parameters(parameters, lead)
    result: jax.Array = calls.row(robot, name, spread, parameters, **attributes)[0]
    return result


def _broadcast_parameters(parameters: Any, lead: tuple[int, ...]) -> Any:
    """Parameters of each state, or one array that all states share."""
    import jax.numpy as jnp

    return parameters if parameters.ndim == 1 else jnp.broadcast_to(parameters, (*lead, parameters.shape[-1]))


def _array(name: str, given: Any) -> Any:
    """JAX array of float64 or float32."""
    try:
        import jax.numpy as jnp
    except ImportError as error:
        raise ImportError("robot_dynamics.jax needs JAX: pip install jax") from error

    array = jnp.asarray(given)
    if jnp.issubdtype(array.dtype, jnp.integer):
        return array.astype(jnp.result_type(float))
    if array.dtype not in (jnp.float32, jnp.float64):
        raise DTypeError(f"{name} has dtype {array.dtype}; only float64 and float32 are supported: convert it yourself")
    return array


def _batch_shape(given: list[tuple[str, Any, tuple[int, ...]]], robot: Robot) -> tuple[int, ...]:
    """Leading dimensions of the batch, broadcast as in NumPy."""
    import jax.numpy as jnp

    leads = []
    first, one, _ = given[0]
    for name, array, own in given:
        if array.shape[array.ndim - len(own) :] != own:
            needs = ", ".join(map(str, own))
            raise ShapeError(f"{name} has shape {array.shape}, robot `{robot.name}` needs (..., {needs})")
        if array.dtype != one.dtype:
            raise DTypeError(f"{first} is {one.dtype} and {name} is {array.dtype}: nothing is converted silently")
        leads.append(array.shape[: array.ndim - len(own)])
    try:
        return tuple(jnp.broadcast_shapes(*leads))
    except ValueError:
        shapes = ", ".join(f"{name} has shape {array.shape}" for name, array, _ in given)
        raise ShapeError(f"{shapes}: the leading dimensions do not broadcast") from None


def _broadcast(arrays: list[Any], own: list[int], lead: tuple[int, ...]) -> list[Any]:
    """Arrays broadcast to the dimensions of the whole batch."""
    import jax.numpy as jnp

    return [
        jnp.broadcast_to(array, (*lead, *array.shape[array.ndim - axes :]))
        for array, axes in zip(arrays, own, strict=True)
    ]
